#pragma once

#include "cutting/cancellation.hpp"
#include "mesh/mesh_arrays.hpp"
#include "points/few_points.hpp"
#include "points/usable_points.hpp"
#include "scenes/body_tree.hpp"
#include "scenes/frame.hpp"

#include <clsdf/mesh.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>

/// The bodies that points are looked up among, by the host.
namespace clsdf::scenes {

class MeetingLines;

/// The mesh of one or more bodies.
struct SearchedShape {
    points::PointInputs inputs;  ///< of points::bring_to_host()
    Box sign_box;                ///< around all that is inside
    points::UsableRange usable;
    std::optional<points::FinishingSources> finishing{};  ///< of the inputs
    bool has_film = false;                                ///< points outside the box may be inside
};

struct SearchedBody {
    const SearchedShape* shape = nullptr;  ///< null: the body is switched off
    const Frame* frame = nullptr;
};

struct SearchedScene {
    std::span<const SearchedBody> bodies;
    const BodyTree& tree;                       ///< of those that are on
    std::span<const std::uint32_t> with_films;  ///< the same, which have films; ascending
    const cutting::Cancellation& cancellation;
    /// Returns the lines in which the bodies meet, made when they are asked for first. For one thread at a time. Empty:
    /// a point has the least of the bodies' values; else that of their union, and all bodies are closed and look
    /// outwards.
    std::function<std::shared_ptr<const MeetingLines>()> meeting_lines{};
};

/// How far away a face of a body counts.
struct HalfWidths {
    std::span<const double> each;  ///< one for all bodies, or one a body; not negative
    double greatest;

    double of(std::uint32_t body) const { return each[each.size() == 1 ? 0 : body]; }
};

inline const engine::PointMesh& mesh_of(const SearchedBody& body) {
    return *body.shape->inputs.on_host;
}

/// Above the rounding of coordinates in the scene.
inline constexpr double relative_rounding = 4e-15;

double largest_of(const Vec3& p);
/// The largest coordinate of a body, in its own frame and of its translation.
double largest_of(const SearchedBody& body);

/// Above the rounding of a point and of the body, in the scene's units: what is no farther apart counts as touching.
double rounding_of(const SearchedBody& body, const Vec3& p);

inline bool is_usable(const SearchedBody& body, const Vec3& in_body) {
    return engine::contains(body.shape->usable.limits, in_body);
}

/// A search within a half width in a body that need not decide signs.
points::NearestOfPoint nearest_within(const SearchedBody& body, const Vec3& in_body, double half_width,
                                      std::uint32_t& near);

/// The most points that are looked up in one body at once.
inline constexpr std::size_t most_at_once = 64;
/// The signs of points in a body, at most most_at_once, that are CLSDF_POINT_UNDECIDED. squared: see
/// points::LocatedPoints.
void find_signs(const SearchedBody& body, std::span<const Vec3> in_body, std::span<const double> squared,
                std::span<std::uint8_t> signs);

enum class PlaceInBody : std::uint8_t { outside, on, inside };
/// on: no farther than `rounding` from the surface.
PlaceInBody place_in(const SearchedBody& body, const Vec3& point, double rounding);

}  // namespace clsdf::scenes
