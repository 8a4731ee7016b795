#pragma once

#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include "finish/finishing.hpp"
#include "launch/device_tools.hpp"
#include "launch/launches.hpp"
#include "launch/programs.hpp"
#include "launch/radix_sort.hpp"
#include "points/device_points.hpp"
#include "points/face_sides.hpp"
#include "points/point_scan.hpp"
#include "points/sign_faces.hpp"
#include "tree/binary_tree.hpp"
#include "tree/point_mesh.hpp"
#include "tree/wide_tree.hpp"

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

/// Points in memory of the device on their way to their outputs: launches that do not wait for one another's results on
/// the host.
namespace clsdf::points {

/// The inputs of a query.
struct PointInputs {
    std::shared_ptr<const engine::PointFaces> mesh;
    std::shared_ptr<const engine::PointMesh> on_host;            ///< the same for the host; of few points alone
    std::shared_ptr<const device::BufferPool::Lease> triangles;  ///< if there are sign faces: those of the mesh
    std::shared_ptr<const engine::FittedTree> tree;    ///< that points are looked up in; of the body by_group alone
    std::shared_ptr<const engine::WideLeaves> leaves;  ///< the same of the body by_vector, and of few points
    std::shared_ptr<const ScannedMesh> scanned;        ///< null: points are looked up one by one
    std::shared_ptr<const FaceSides> sides;            ///< null: signs by crossings; else the sites have normals
    std::shared_ptr<const engine::DeviceSites> sites;  ///< with normals if the gradient is asked for
    /// Null: the host orders the points, and counts crossings; of the body by_vector alone. If they are not exact, the
    /// host counts crossings.
    std::shared_ptr<const DeviceSignFaces> sign_faces;
    /// The mesh and the tree in which the host decides the signs that are left to it; made when they are asked for.
    /// Unless points are few.
    std::function<std::shared_ptr<const engine::PointMesh>()> host_mesh;
    std::function<std::shared_ptr<const engine::WideTree>()> host_tree;
    SignRule sign = SignRule::none;
    bool is_inside_out = false;   ///< the faces look inwards, and the points have a sign
    bool has_deep_stack = false;  ///< the body by_group searches with the large stack, however deep the tree is

    bool needs_deep_stack() const { return has_deep_stack || (tree && tree->divided->depth > engine::stack_entries); }
    bool has_exact_signs() const { return sign_faces && sign_faces->are_exact; }
};

/// Points that are computed at once. The memory that they take is bounded by it; results do not depend on it.
inline constexpr std::size_t most_points = std::size_t{1} << 20;

/// The limit of the search for the nearest face: a squared distance in units, above all rounding of what is compared
/// with `half_width` at the end.
double search_limit(const engine::PointFaces& mesh, double half_width);

/// The box in which points are ordered along a curve: that of the mesh and its surroundings.
Box box_of_curve(const engine::PointFaces& mesh);

/// Points whose nearest faces are known.
struct LookedUpPoints {
    std::size_t count;
    const cl::Buffer& in_units;  ///< a Vec3 of each
    const cl::Buffer& places;    ///< a cl_uint of each: where its results go
    const cl::Buffer& faces;     ///< a cl_uint of each
};

/// Enqueues the outputs of the points that have a sign. by_sides: that of the side of their nearest face, if inputs has
/// sides. signs: a byte of each point.
void enqueue_outputs(const engine::Launches& launches, const engine::DeviceTools& tools, const PointInputs& inputs,
                     const engine::Finishing& finishing, const LookedUpPoints& points, bool by_sides,
                     const cl::Buffer& signs, double half_width, const engine::OutputBuffers& outputs);

/// Enqueues the search of processors for points [begin, end). run: points of a work-item, which follow each other.
/// most: search_limit().
void enqueue_tree_search(const engine::Launches& launches, const engine::DeviceTools& tools, const PointInputs& inputs,
                         const cl::Buffer& in_units, std::size_t begin, std::size_t end, std::size_t run, double most,
                         const cl::Buffer& faces, const cl::Buffer& squared);
/// Points of a work-item of that search, at most; and an estimate of its time, on a core.
inline constexpr std::size_t most_in_run = 64;
inline constexpr double seconds_per_search = 2e-5;
std::size_t points_in_run(const device::Context& context, std::size_t count);

/// Points that are computed at once, and where their results go.
struct PointBatch {
    DevicePoints points;
    PointLimits usable;
    double half_width = 0;
    const engine::OutputBuffers& outputs;  ///< packed
    /// A point whose sign is open is left without a distance; else its outputs are not written.
    bool leaves_open = false;
    struct Status {
        cl::Buffer memory;
        ValuePlaces places;
    };
    std::optional<Status> status{};  ///< a byte of each point
};

/// The memory by which points are looked up, for one thread at a time and one batch after the other.
class PointRun {
public:
    /// For at most `most` points at once, which the memory is in proportion to. Throws Error(out_of_memory).
    PointRun(const engine::DeviceTools& tools, std::size_t most);

    std::size_t most() const { return most_; }
    std::size_t device_bytes() const;

    /// Finds the cells in which points are ordered, from all of them, and those that are not usable.
    void enqueue_measure(const engine::Launches& launches, const engine::DeviceTools& tools, const DevicePoints& all,
                         const PointLimits& usable, const engine::PointFaces& mesh);
    /// Everything else, of points that were among the measured ones. `between`, which may be empty and may throw, is
    /// called between launches with the fraction done; if it is not empty, the device's queue is waited for before.
    void enqueue(const engine::Launches& launches, const engine::DeviceTools& tools, const PointInputs& inputs,
                 const PointBatch& batch, const std::function<void(double)>& between);

    /// A PointCells.
    const cl::Buffer& cells() const { return *cells_; }
    // By the order of the last batch: Vec3, places and faces as cl_uint, double, and a byte of each point.
    const cl::Buffer& in_units() const { return *in_units_; }
    const cl::Buffer& places() const { return *order_; }
    const cl::Buffer& faces() const { return *faces_; }
    const cl::Buffer& squared() const { return *squared_; }
    /// Numbers of the points whose sign is open, PointCells::left of them.
    const cl::Buffer& left() const { return *left_; }

private:
    void enqueue_order(const engine::Launches& launches, const engine::DeviceTools& tools,
                       const engine::PointFaces& mesh, const PointBatch& batch);
    void enqueue_search(const engine::Launches& launches, const engine::DeviceTools& tools, const PointInputs& inputs,
                        const PointBatch& batch, const std::function<void(double)>& between);
    void enqueue_signs(const engine::Launches& launches, const engine::DeviceTools& tools, const PointInputs& inputs,
                       const PointBatch& batch);
    void enqueue_marks(const engine::Launches& launches, const engine::DeviceTools& tools, const PointInputs& inputs,
                       const engine::Finishing& finishing, const PointBatch& batch);

    std::size_t most_;
    device::BufferPool::Lease extents_, cells_, keys_, order_;
    engine::SortMemory sort_;
    device::BufferPool::Lease in_units_, faces_, squared_, signs_, open_, left_;
    device::BufferPool::Lease listed_, listed_counts_;  // of the body by_group
};

}  // namespace clsdf::points
