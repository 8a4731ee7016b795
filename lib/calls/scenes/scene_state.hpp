#pragma once

#include <clsdf/scene.hpp>

#include "calls/call.hpp"
#include "core/call_mutex.hpp"
#include "core/refuse.hpp"
#include "core/statistics.hpp"
#include "device/context.hpp"
#include "scenes/body_tree.hpp"
#include "scenes/frame.hpp"
#include "scenes/meeting_lines.hpp"
#include "targets/host_arrays.hpp"

#include <clsdf/error.hpp>

#include <algorithm>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace clsdf {

/// Throws Error(invalid_argument) that names what the pose is of: " of body 3".
scenes::Frame frame_of(const Pose& pose, const std::string& owner);

inline bool is_moved(const scenes::Frame& frame) {
    return frame.is_turned || frame.translation != Vec3{};
}

/// The bodies of a scene, and what is kept of their meshes.
struct __attribute__((visibility("hidden"))) Scene::State {
    /// The mesh of one or more bodies.
    struct Shape {
        DistanceTransform transform;  ///< in the mesh's own coordinates
        Box box;
        SignRule asked;  ///< the rule that add() was given

        /// For fields of bodies that are not in their own coordinates: the same mesh, where the body of the last one
        /// was. Both are guarded by field_mutex.
        std::optional<DistanceTransform> moved{};
        std::optional<scenes::Frame> moved_to{};
    };

    struct Body {
        Shape* shape;
        scenes::Frame frame;
        bool is_active;
    };

    /// Bodies in the order of their numbers, where their meshes are, as one transform.
    struct JoinedBodies {
        std::vector<std::uint32_t> bodies;
        bool is_inside_out;
        std::vector<scenes::Frame> frames;  ///< empty if the positions are older than the meshes
        DistanceTransform transform;
    };

    /// Bodies of one kind can be joined.
    struct KindOfBody {
        SignRule sign;
        bool is_inside_out;  ///< false if no output depends on it

        friend auto operator<=>(const KindOfBody&, const KindOfBody&) = default;
    };

    /// The outer surface of all bodies that are on, where they are.
    struct CutUnion {
        std::vector<std::uint32_t> bodies, faces;  ///< of each triangle of the transform's mesh
        DistanceTransform transform;
    };

    /// The part of a field's grid that a body reaches.
    struct FieldPart {
        std::uint32_t body;
        Grid grid;
        Grid near;  ///< the samples that are no farther from it than the half width on either side
    };
    /// What the launches of one call compute, in an array of the block: the part of a body, which is the block, by its
    /// transform, or those of several bodies that are joined.
    struct FieldStep {
        struct Members {
            std::vector<std::uint32_t> bodies{};
            bool is_inside_out = false;
        };
        Grid block{};
        std::vector<FieldPart> parts{};
        std::shared_ptr<const Members> members{};  ///< that are joined; null for one body
        std::vector<std::uint32_t> selected{};     ///< the places of the parts' bodies among them

        std::size_t sample_count() const {
            std::size_t sum = 0;
            for (const FieldPart& part : parts) sum += part.grid.sample_count();
            return sum;
        }
    };

    State(Device device_in, const SceneOptions& options_in) : device(std::move(device_in)), options(options_in) {}

    const device::Context& context() const { return device::context_of(device); }

    const Body& body(std::uint32_t number) const {
        if (number >= bodies.size())
            refuse("there is no body {}: the scene has {}, counted from 0", number, bodies.size());
        return bodies[number];
    }
    Body& body(std::uint32_t number) {
        std::as_const(*this).body(number);
        return bodies[number];
    }
    /// Of a body that is on.
    bool has_sign() const {
        return std::ranges::any_of(
            bodies, [](const Body& body) { return body.is_active && body.shape->transform.sign() != SignRule::none; });
    }

    void require_bodies() const {
        if (bodies.empty()) refuse("the scene has no bodies; add one");
        if (std::ranges::none_of(bodies, &Body::is_active))
            refuse("all {} bodies of the scene are switched off; switch one on", bodies.size());
    }

    std::shared_ptr<const scenes::BodyTree> current_tree();

    bool is_union() const { return options.surface == Surface::outer; }
    /// To be called when bodies have been added, moved or switched.
    void forget_poses() {
        tree.reset();
        meeting_lines.reset();
        cut_union.reset();
    }

    // scene.cpp
    /// Of the bodies that are on.
    scenes::BodyTree tree_at(std::span<const scenes::Frame> frames) const;
    template <typename MeshOrView>
    Shape make_shape(const MeshOrView& mesh, SignRule sign, const CallOptions& call) const;
    std::uint32_t add(std::span<const Mesh> meshes, std::span<const Pose> poses, SignRule sign,
                      const CallOptions& call);
    template <typename MeshOrView>
    std::uint32_t add(const MeshOrView& mesh, const Pose& pose, SignRule sign, const CallOptions& call);
    template <typename MakeShape>
    std::uint32_t add_body(const Pose& pose, const MakeShape& make_shape);

    // scene_fields.cpp
    SignRule field_sign() const;
    /// The body's mesh in its own coordinates, if it is not where that is.
    const Mesh* mesh_if_moved(const Body& body) const;
    Box box();
    /// The parts of a field for the bodies that count in it.
    std::vector<FieldPart> parts_of(const Grid& grid, const Band& band) const;
    CallStatistics compute(const Request& request, const CallOptions& call);
    // Both need field_mutex. arrays: packed, of the grid; with the body if there are other outputs than the distance.
    void compute_least(const Request& request, const targets::HostArrays& wanted, const targets::HostArrays& arrays,
                       const CallOptions& call, calls::RunningCall& running);
    /// With the triangle beside the body.
    void compute_union(const Request& request, const targets::HostArrays& arrays, const CallOptions& call,
                       calls::RunningCall& running);
    /// A transform of the body's mesh in the scene's coordinates, until that of another one is asked for. Needs
    /// field_mutex.
    const DistanceTransform& placed(const Body& body);

    // joined_bodies.cpp. All need field_mutex.
    std::optional<KindOfBody> kind_if_joined(const Shape& shape, bool has_normals);
    bool are_joined(std::span<const FieldPart> parts, const KindOfBody& kind, const Grid& grid, const Band& band) const;
    /// Small bodies are joined, those that have no sample of a field in common: so each has the bytes that it has
    /// alone. Their steps come first.
    std::vector<FieldStep> steps_of(const std::vector<FieldPart>& parts, const Request& request);
    /// The transform of the step's members, with its bodies selected, until that of another step is asked for.
    const DistanceTransform& joined_at(const FieldStep& step);

    // scene_outer.cpp
    SceneSurface outer(const CallOptions& call) const;

    // scene_queries.cpp
    class Call;
    /// frames: of all bodies for each configuration, or nothing for the poses that they have. half_widths: one, or one
    /// a body.
    CallStatistics query(const InputArray& points, std::optional<std::span<const scenes::Frame>> frames,
                         std::span<const double> half_widths, const SceneTargets& targets, const CallOptions& call);
    CallStatistics query_pairs(const InputArray& points, std::span<const PointOfBody> pairs,
                               std::span<const double> half_widths, const OutputTargets& targets,
                               const CallOptions& call);

    Device device;
    SceneOptions options;
    std::list<Shape> shapes{};
    std::vector<Body> bodies{};

    std::mutex mutex{};
    std::shared_ptr<const scenes::BodyTree> tree{};               ///< null after a change; guarded by the mutex
    std::shared_ptr<const scenes::MeetingLines> meeting_lines{};  ///< the same

    CallMutex field_mutex{"the scene that makes the call"};  ///< for the transforms that are moved for fields
    std::optional<JoinedBodies> joined{};                    ///< of the last field; guarded by field_mutex
    std::optional<CutUnion> cut_union{};                     ///< the same, unless bodies have moved since
};

}  // namespace clsdf
