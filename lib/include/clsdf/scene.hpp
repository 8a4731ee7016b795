#pragma once

#include <clsdf/distance_transform.hpp>
#include <clsdf/export.hpp>
#include <clsdf/outer.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace clsdf {

/// The pose of a body, whose points x are at R x + t. `rotation` has the rows of R.
struct Pose {
    std::array<Vec3, 3> rotation{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    Vec3 translation{};
};

/// The pose of a 4 x 4 matrix, by rows, whose last row is 0, 0, 0, 1. Its rotation may be rounded to floats: it is
/// replaced by the nearest rotation, as by Scene::set_poses(), with the same bytes on every machine. Throws
/// Error(invalid_argument) for another last row and for what that refuses.
CLSDF_EXPORT Pose pose_of(std::span<const double, 16> matrix);

/// What a scene keeps between calls.
struct SceneOptions {
    /// Limit of the memory that is kept of each mesh: see TransformOptions::kept_bytes.
    std::optional<std::size_t> kept_bytes{};
    /// outer: query() and query_poses() give the distance to the surface of the union of all bodies that are on, inside
    /// overlaps, too, with the outputs of the closest point there (docs/scenes.md, 'The union itself'). Each body's
    /// mesh is replaced by its own outer surface when it is added, and add() throws as the constructor of a
    /// DistanceTransform with TransformOptions::surface does. compute() gives the field of the mesh of outer(), without
    /// sites and barycentric coordinates; query() with a half width for each body throws Error(invalid_argument).
    Surface surface = Surface::given;
};

/// The value of Output::body beyond the half width or the band.
inline constexpr std::uint32_t no_body = 0xFFFFFFFFU;

/// A point and the body that it is looked up in, by their numbers.
struct PointOfBody {
    std::uint32_t point = 0;
    std::uint32_t body = 0;
};

/// The arrays to which Scene::query() writes: those of DistanceTransform::query(), with Output::body, and one of its
/// own, packed and on the host, with an item for each point, or empty.
struct SceneTargets {
    OutputTargets outputs;
    /// 1 if the distance is that of the union of the bodies, or the half width and the union's is not less, else 0:
    /// then the union's surface may be farther away (docs/scenes.md).
    std::span<std::uint8_t> is_own{};
};

/// The outer surface of the bodies of a scene: the boundary of what is inside at least one of them.
struct SceneSurface {
    /// `faces`: within the mesh of their body. whole_faces and the like: of the triangles of the bodies' own outer
    /// surfaces.
    OuterSurface surface;
    std::vector<std::uint32_t> bodies;  ///< of each triangle of surface.mesh
};

/// Many bodies, each a mesh with its own sign rule and pose: points among them, and fields of all of them.
///
/// A body is added, gets a number, counted from 0, and keeps it. Bodies may share a mesh (instances): then they share
/// its prepared data, too. Points are looked up in the body's own coordinates, so nothing is prepared again when poses
/// change. Fields are computed from the moved positions.
///
/// The distance is the least of the bodies' signed distances. Outside all bodies it is the distance to their union.
/// Inside it is the depth in the deepest body: the union's surface is at least as far away; SceneOptions::surface has
/// the union's own distance. A body without a sign counts with its distance. docs/scenes.md has the proof and a
/// picture, docs/accuracy.md what poses cost.
///
/// Members that are const may be called from several threads at once; the others, assignment and the destructor need
/// the scene for themselves. Fields take turns. After an error the scene is that of before. Once moved from, every
/// member but assignment and the destructor throws Error(invalid_argument). Points are looked up by the host, on all
/// cores.
class CLSDF_EXPORT Scene {
public:
    /// Without bodies. device: whose memory points and results may be in.
    explicit Scene(Device device, const SceneOptions& options = {});
    Scene(Scene&&) noexcept;
    Scene& operator=(Scene&&) noexcept;
    ~Scene();

    // Bodies.

    /// Adds a mesh, which is copied, and returns the body's number. Throws what the constructor of DistanceTransform
    /// throws; Error(invalid_argument) for a pose that set_poses() refuses; Error(unsupported) for the sign rule
    /// `below`, whose walls do not turn with a body: close_down() makes a closed mesh.
    std::uint32_t add(const Mesh& mesh, const Pose& pose = {}, SignRule sign = SignRule::automatic,
                      const CallOptions& call = {});
    std::uint32_t add(const MeshView& mesh, const Pose& pose = {}, SignRule sign = SignRule::automatic,
                      const CallOptions& call = {});
    /// Adds many bodies, which are prepared on all cores, and returns the number of the first; those of the others
    /// follow. poses: of each, or empty. Throws as add(), and Error(invalid_argument) for another number of poses; then
    /// none is added. Functions of `call` are called by one thread at a time.
    std::uint32_t add(std::span<const Mesh> meshes, std::span<const Pose> poses = {},
                      SignRule sign = SignRule::automatic, const CallOptions& call = {});
    /// Adds a body that has the mesh and the sign rule of another one.
    std::uint32_t add_instance(std::uint32_t of, const Pose& pose = {});

    /// Moves all bodies, from the positions that their meshes have. Elements of R R^T may differ from the identity's by
    /// 1e-5, so that rotations may be rounded to floats: each is replaced by the nearest rotation. Throws
    /// Error(invalid_argument) that names the body if its matrix is no rotation or its translation is not finite, and
    /// unless there are as many poses as bodies.
    void set_poses(std::span<const Pose> poses);
    /// Moves some bodies. Also throws Error(invalid_argument) if a body is not there or is named twice.
    void set_poses(std::span<const std::uint32_t> bodies, std::span<const Pose> poses);
    /// Gives the mesh of a body, and so all its instances, new positions before their poses; throws as
    /// DistanceTransform::set_positions().
    void set_positions(std::uint32_t body, const InputArray& positions, const CallOptions& call = {});
    /// Switches a body off, as if it were not there, or on again.
    void set_active(std::uint32_t body, bool is_active);

    std::size_t size() const;
    bool is_active(std::uint32_t body) const;
    /// Where the body is, with the rotation that is used.
    Pose pose(std::uint32_t body) const;
    /// Never `automatic`.
    SignRule sign(std::uint32_t body) const;
    /// Whether a body that is on has a sign.
    bool has_sign() const;
    /// The rule of fields: that of the bodies that are on and have a sign, `nonzero` if they have several, else none.
    SignRule sign() const;
    /// Around the bodies that are on, where they are. Throws Error(invalid_argument) if there is none.
    Box box() const;
    /// The memory that is kept of all meshes.
    KeptMemory memory() const;

    /// The outer surface of the bodies that are on, where they are: faces are cut where bodies meet, and what lies in
    /// another body is left out, as by clsdf::outer() of each body and then of all. Distances to this mesh are those to
    /// the union, within overlaps, too; fractions() of it are those of the union. It is made anew by each call, in time
    /// that grows with the bodies' faces: for bodies at rest, not for each step of many. Of `call`, should_stop counts,
    /// and log, which gets the bodies' warnings. Throws Error(invalid_argument) if no body is on, and the errors of
    /// outer(), which name the body; in particular Error(unsupported) for an open one.
    SceneSurface outer(const CallOptions& call = {}) const;

    // Fields. All throw Error(invalid_argument) if there is no body that is on.

    /// As DistanceTransform::compute(): the least of the bodies' signed distances, with the outputs of the body that
    /// has it, and Output::body. If several have it, in the precision of the distance's array, the lowest number wins.
    /// A sample that is in the depth of a body, beyond its band, is beyond the band of the field, whatever else is
    /// near; there is no body then. A body without a sign has none with exact signs, either, and does not count in a
    /// field of signs alone.
    ///
    /// Each body has the bytes of a transform of its own that was moved there by DistanceTransform::set_motion(), or of
    /// its mesh if the pose is the identity. So has the field of bodies that are farther from each other than the band
    /// is wide. Takes the time of each body's part of the grid: its box, and the half width outside around it.
    ///
    /// The field's rule is sign(). Throws as DistanceTransform::compute(); Error(invalid_argument) for a field of signs
    /// alone or exact signs if no body has a sign.
    Field compute(const Grid& grid, const Band& band, OutputSet outputs = Output::distance,
                  const CallOptions& call = {}, TransformStatistics* statistics = nullptr) const;

    /// Into the caller's arrays, of the host or of the device, which is mapped; the distance must have one.
    TransformStatistics compute(const Grid& grid, const Band& band, const OutputTargets& targets,
                                const CallOptions& call = {}) const;

    // Points. All throw Error(invalid_argument) if there is no body that is on.

    /// As DistanceTransform::query(), of the body whose signed distance is the least. If several have exactly that, in
    /// double, the lowest number wins. Triangles and sites are those of its mesh; closest points, gradients and offsets
    /// are in the scene's coordinates. Beyond the half width there is no body, and the distance is the half width,
    /// negative if the point is inside a body; so also where the surface of another body is near, in the depth of one.
    ///
    /// If SceneOptions::surface is outer, the distance of a point inside is that to the surface of the union, with the
    /// outputs of the closest point there; where bodies cut each other these are the lowest body's, with the site 7.
    ///
    /// A result depends on the point, the half width, and the bodies, their positions and poses, alone. A point is not
    /// usable if it is not finite, or if a body that may be nearest is too far for DistanceTransform::query().
    ///
    /// Throws what that throws, and Error(invalid_argument) if `is_own` has another length than the points.
    TransformStatistics query(const InputArray& points, double half_width, const SceneTargets& targets,
                              const CallOptions& call = {}) const;

    /// The same with a half width for each body, by its number: one of which no face is within its own does not count,
    /// unless the point is inside. Beyond all of them the distance is the greatest, with a sign as above. Also throws
    /// Error(invalid_argument) for another number of them, and if `is_own` is not empty.
    TransformStatistics query(const InputArray& points, std::span<const double> half_widths,
                              const SceneTargets& targets, const CallOptions& call = {}) const;

    /// As query(), for many configurations of the bodies in one call: `poses` has size() of them for each, and arrays
    /// have an item for each configuration and point, those of a configuration one after the other. Each has the bytes
    /// of set_poses() and query(). The scene's own poses stay. Also throws Error(invalid_argument) if the poses are no
    /// multiple of the bodies, and names the configuration and the body of a pose that set_poses() refuses.
    TransformStatistics query_poses(const InputArray& points, std::span<const Pose> poses, double half_width,
                                    const SceneTargets& targets, const CallOptions& call = {}) const;

    /// The outputs of each pair of a point and a body, by that body alone. An array has an item for each pair. Throws
    /// as query(), and Error(invalid_argument) that names a pair whose point or body is not there, or whose body is
    /// off.
    TransformStatistics query_pairs(const InputArray& points, std::span<const PointOfBody> pairs, double half_width,
                                    const OutputTargets& targets, const CallOptions& call = {}) const;

    /// The same with a half width for each body, by its number.
    TransformStatistics query_pairs(const InputArray& points, std::span<const PointOfBody> pairs,
                                    std::span<const double> half_widths, const OutputTargets& targets,
                                    const CallOptions& call = {}) const;

    /// 1 for each point that is inside a body, else 0; a point on the surface of a body is not inside this one. A point
    /// that is not finite has 0.
    void contains(const InputArray& points, std::span<std::uint8_t> is_inside, const CallOptions& call = {}) const;

    /// The sum of the bodies' winding numbers, in their order: see DistanceTransform::winding(). Adds doubles, each as
    /// exact as an array of doubles has it.
    void winding(const InputArray& points, std::span<double> results, const CallOptions& call = {}) const;

    /// The place of each box: inside if it is inside one of the bodies, `outside` (`beyond` if no body has a sign) if
    /// it is that of all of them, else within. As DistanceTransform::classify(); in addition, a box may be within that
    /// is farther from a body which is turned, by less than the box is large: the smallest box around it in the body's
    /// coordinates decides.
    void classify(std::span<const Box> boxes, double half_width, std::span<BoxPlace> places) const;

private:
    struct State;
    State& state() const;
    std::unique_ptr<State> state_;
};

}  // namespace clsdf
