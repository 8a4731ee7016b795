#pragma once

#include <clsdf/device.hpp>
#include <clsdf/export.hpp>
#include <clsdf/field.hpp>
#include <clsdf/laboratory.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/outputs.hpp>
#include <clsdf/topology.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

typedef struct _cl_event* cl_event;

namespace clsdf {

class FieldMethod;

/// Progress of building the device's programs; see CallOptions::compiling.
struct Compilation {
    std::size_t step = 0;     ///< from 1
    std::size_t steps = 0;    ///< about; >= step
    bool is_waiting = false;  ///< another process compiles the same programs; this one waits
};

/// The method, how the sign is decided, and what is kept.
struct TransformOptions {
    SignRule sign = SignRule::automatic;
    KernelBody body = KernelBody::automatic;  ///< clsdf/laboratory.hpp
    /// The method of a library beside the core. Null: leaned frusta by bricks.
    std::shared_ptr<const FieldMethod> method{};
    std::function<void(const std::string& message)> log{};  ///< warnings; on the calling thread, as CallOptions' are
    /// Limit of the device memory that is kept between calls, in bytes: polyhedra of lattices, lists of the last four
    /// grids, and what points need. The default is the polyhedra of two lattices (280 bytes a triangle each) and all
    /// that points need, or 256 MiB if that is more. 0 keeps nothing. Data that all grids and points share is kept
    /// first, then the lattices and grids that were used last.
    std::optional<std::size_t> kept_bytes{};
};

/// Counts and times of a computation. Times are the host's wall-clock seconds.
struct TransformStatistics : WorkCounts {
    std::size_t slabs = 0;  ///< parts of the grid that were computed one after the other; 1: all at once
    /// The most that buffers on the device took at once; of a Plan, its own buffers. A field that is computed in place,
    /// on a processor, is not among them.
    std::size_t device_bytes = 0;
    /// The library's own arrays on the host for slabs.
    std::size_t host_bytes = 0;

    /// Building or loading the device's programs and testing them, since the transform was made or computed last; in
    /// none of the times below.
    double compile_seconds = 0;
    /// Programs were used for the first time on this device and driver version, and tested: compile_seconds is what
    /// their compilation took. Later computations and processes find them.
    bool first_use = false;
    double polyhedra_seconds = 0;
    // By the host's clock. Work that the device has not finished when the host continues counts to the next stage.
    double lists_seconds = 0;  ///< the sign's sweep included
    double sign_seconds = 0;   ///< of these, the sweep
    double field_seconds = 0;
    // The kernels' own share, by the device's clock; 0 unless its queue was made with profiling enabled.
    double bricks_seconds = 0;  ///< the scan
    double fill_seconds = 0;
};

/// Options of one call. Its functions run on the calling thread. They must not make or use transforms of the device. A
/// call of the transform that is at work throws Error(invalid_argument).
struct CallOptions {
    /// Called between launches of calls that compute; with targets on the device only at the end, with 1. A plan has no
    /// progress: its runs do not return to the host.
    std::function<void(double fraction)> progress{};
    /// Called before each step of building, loading and testing programs; while another process compiles them, again
    /// and again.
    std::function<void(const Compilation& compilation)> compiling{};
    std::function<bool()> should_stop{};        ///< asked between launches; if it says true, Error(cancelled) is thrown
    bool count = false;                         ///< fill the statistics counted on the device; costs time; not of plans
    TransformStatistics* statistics = nullptr;  ///< set at the end of a call that succeeds
};

/// One box of many: see DistanceTransform::compute().
struct Request {
    Grid grid;
    Band band;
    OutputTargets targets;
};

/// The position of a box relative to a mesh: see DistanceTransform::classify().
enum class BoxPlace : std::uint8_t {
    near,     ///< the surface may be within the half width of a point of the box
    inside,   ///< the surface is farther from every point of the box, and all of them are inside
    outside,  ///< the same, and all of them are outside
    far,      ///< the same, of a mesh that has no sign
};

/// Called with the slabs of a field, one after the other: whole slices, the samples of `part` of its grid. The values
/// are there until it returns. Its exceptions are passed on; std::bad_alloc becomes Error(out_of_memory).
using SlabSink = std::function<void(const Grid& part, const FieldSlab& values)>;

/// How a field is computed slab by slab.
struct SlabOptions {
    /// The sink runs on a thread of its own, while the next slab is computed; else on the caller's, between slabs.
    bool overlap = true;
};

class DistanceTransform;

namespace transform {
struct PlanState;
}  // namespace transform

/// Boxes that are computed again and again into the caller's device memory: DistanceTransform::plan(). A plan holds all
/// that depends on positions, grids and bands: polyhedra, lists, the sign's crossings, buffers. It has its own copy of
/// what it needs and may outlive the transform; its destructor waits for what it has enqueued. One thread at a time.
/// Once moved from, every member but assignment and the destructor throws Error(invalid_argument).
class CLSDF_EXPORT Plan {
public:
    Plan(Plan&&) noexcept;
    Plan& operator=(Plan&&) noexcept;
    ~Plan();

    /// One without targets if the plan was made from a grid.
    std::span<const Request> requests() const;
    SignRule sign() const;

    /// Enqueues the computation of all requests into their targets on the caller's queue (null: the device's own),
    /// after the events of `wait_list`. Never blocks and never allocates device memory. Returns the event of its end,
    /// which the caller releases. May be called again at once, on any queue of the device's context, in order or not:
    /// runs of a plan follow one another.
    ///
    /// Throws Error(device_failure), also for an event that has failed; Error(invalid_argument) for a plan that was
    /// made without targets, after a failed move() or replan(), and for a queue or an event of another context.
    cl_event enqueue(cl_command_queue queue, std::span<const cl_event> wait_list = {});

    /// Enqueues one run that writes to other targets: one OutputTargets for each request. This is for codes that swap
    /// two sets of arrays. The outputs are those of the plan. If a request's target is packed and aligned
    /// (OutputTarget::offset), the new target must be so, too; a plan without targets takes only such targets. The
    /// replacement of any other target may have another offset and other strides; its elements must be the same. A
    /// copied box whose offset or strides differ from those of the run before costs one small command.
    ///
    /// Also throws Error(invalid_argument) if there are not as many targets as requests, and for memory that is
    /// missing, read-only, too small or no buffer; Error(unsupported) for other targets. Then nothing is enqueued.
    /// Error(out_of_memory): the host's memory does not suffice. Some commands may be enqueued then, and the next run
    /// follows them.
    cl_event enqueue(cl_command_queue queue, std::span<const OutputTargets> targets,
                     std::span<const cl_event> wait_list = {});
    /// The same of a plan with one request.
    cl_event enqueue(cl_command_queue queue, const OutputTargets& targets, std::span<const cl_event> wait_list = {});

    /// Prepares the next runs for the present positions of `transform`, which made the plan or has its Device. If
    /// `grids` is not empty, it has a grid for each request, of any lattice, whose samples fit the request's target.
    /// Blocks: waits for the last run, and replaces the plan's buffers, so that enqueue() need not. The bytes are those
    /// of a new plan. Throws Error(invalid_argument, out_of_memory, device_failure or cancelled). If a grid is refused,
    /// the plan stays as it was. After any other error it must be moved again before enqueue().
    void move(const DistanceTransform& transform, std::span<const Grid> grids = {}, const CallOptions& call = {});
    /// The same with other requests, any number of them: the boxes of a mesh that was refined anew. The plan uses its
    /// buffers again if they are large enough. If a request is refused, also with Error(unsupported), the plan stays as
    /// it was.
    void replan(const DistanceTransform& transform, std::span<const Request> requests, const CallOptions& call = {});

    /// device_bytes: what the plan has on the device, beside the polyhedra that the transform keeps, too.
    const TransformStatistics& statistics() const;

private:
    friend class DistanceTransform;
    explicit Plan(std::unique_ptr<transform::PlanState> state);
    transform::PlanState& state() const;
    std::unique_ptr<transform::PlanState> state_;
};

/// Memory that a transform keeps between calls, in bytes, beside the mesh itself and the free buffers that it uses
/// again.
struct KeptMemory {
    std::size_t host_bytes = 0;    ///< what follows from the triangles and the positions: about 85 a triangle
    std::size_t device_bytes = 0;  ///< within TransformOptions::kept_bytes
};

/// The exact distance to a mesh, on any number of grids.
///
/// A transform prepares the mesh when a call first needs it. It keeps the data of grids within
/// TransformOptions::kept_bytes. Neither changes a byte of a field. The bytes depend on the mesh's first and last
/// positions, the lattice (origin and spacing), the band and the device. They do not depend on the block of the lattice
/// that is computed, on other calls or on threads.
///
/// Members that are const may be called from several threads at once; their work takes turns on the device. move(),
/// assignment and the destructor need the transform for themselves. Calls that return results wait for earlier commands
/// of the device's queue. If one of these waits for an event of the caller's, another thread must set it. Once moved
/// from, every member but assignment and the destructor throws Error(invalid_argument).
class CLSDF_EXPORT DistanceTransform {
public:
    /// Copies and checks the mesh, describes its topology and builds the programs that all computations need. Throws
    /// Error(invalid_mesh), also if it does not meet `sign`; Error(device_failure, unsupported, out_of_memory,
    /// cancelled).
    DistanceTransform(Device device, const Mesh& mesh, TransformOptions options = {}, const CallOptions& call = {});
    /// The view's arrays may be memory of the device's context, which is read after the events of `wait_list`.
    DistanceTransform(Device device, const MeshView& mesh, TransformOptions options = {}, const CallOptions& call = {},
                      std::span<const cl_event> wait_list = {});
    DistanceTransform(DistanceTransform&&) noexcept;
    DistanceTransform& operator=(DistanceTransform&&) noexcept;
    ~DistanceTransform();

    const Topology& topology() const;
    /// The rule in use, never `automatic`.
    SignRule sign() const;

    /// Gives the same triangles new positions, one for each vertex of the mesh that the transform was made from. What
    /// follows from the triangles stays: their order, which vertices count as one, topology() and sign(). Fields of
    /// later calls depend on the first and on these positions only. Faces may lose their area and regain it, vertices
    /// that come to coincide stay separate; plans keep the positions they were made with.
    ///
    /// Positions in memory of the device are read after the events of `wait_list`. All of them come to the host, whose
    /// exact decisions and tables need every position: mapped, 12 or 24 bytes each. They may change when move()
    /// returns.
    ///
    /// Throws Error(invalid_argument) if the number of positions differs, for memory that is missing, too small or of
    /// another context, or if vertices that had equal coordinates, and count as one, move apart; Error(invalid_mesh) if
    /// a vertex in use is not finite; Error(unsupported) for a restricted transform or a buffer that the host may not
    /// read. After an error the positions are those of before.
    void move(const Triples& positions, std::span<const cl_event> wait_list = {});
    /// The same of a temporary container.
    template <detail::DyingArray Array>
    void move(Array&& positions) {
        move(Triples(positions));
    }

    /// Moves the vertices to R x + t, a rigid motion. x are the positions of the mesh that the transform was made from,
    /// so errors do not add up over many motions. `rotation` has the rows of R. A coordinate is three multiplications
    /// and additions, each rounded once: fma(R[a][0], x[0], fma(R[a][1], x[1], fma(R[a][2], x[2], t[a]))). Throws
    /// Error(invalid_mesh) if a position is not finite, Error(invalid_argument) if R is no rotation: each element of R
    /// R^T may differ from the identity's by 1e-12, and det R must be positive.
    void move(const std::array<Vec3, 3>& rotation, const Vec3& translation);

    /// A transform for a part of the domain. It keeps only the triangles near the box and, for a sign, those with
    /// smaller x in the rows of its samples. Samples, points and boxes must lie in the box. Spacings must not exceed
    /// `spacing`; half widths and `within` must not exceed `half_width`. Other calls throw Error(invalid_argument) that
    /// names the box. The results have the bytes of the whole transform. The part cannot be moved or restricted again
    /// (Error(unsupported)). The whole transform is prepared first, which blocks. It may be destroyed afterwards.
    ///
    /// Throws Error(invalid_argument) for a box with a coordinate that is not finite or a lower corner above its upper
    /// one, and for lengths that are not positive and finite; Error(unsupported) for a transform that is restricted
    /// already or has TransformOptions::method; Error(out_of_memory).
    DistanceTransform restrict_to(const Box& box, double half_width, double spacing) const;

    /// Builds the other programs that such a field needs and, the first time on this device and driver version, tests
    /// them: known fields are computed and compared. Computations do it by themselves; this is for programs that
    /// want to choose when. Returns whether something was tested. Throws Error(device_failure) that names the device,
    /// its platform and their versions if the device computes wrong values or if its compiler has ended earlier
    /// processes; Error(cancelled).
    bool compile(const Grid& grid, const Band& band, const Outputs& outputs = {}, const CallOptions& call = {}) const;

    /// The field on the host. A large grid is computed in slabs; the bytes are the same.
    Field operator()(const Grid& grid, const Band& band, const Outputs& outputs = {},
                     const CallOptions& call = {}) const;

    /// Writes the outputs that have a target; the distance must have one. Targets are all on the host or all on the
    /// device. Device memory is written by a plan(), which cannot be cancelled while samples are computed. An error
    /// leaves the targets undefined. The targets are written after the events of `wait_list`, and before the call
    /// returns. Throws Error(invalid_argument) for a grid, a band or a target's memory out of range and for an event of
    /// another context; Error(unsupported) for other elements and for a signed field of a mesh beyond the limits of
    /// Grid; Error(out_of_memory, device_failure or cancelled).
    void compute(const Grid& grid, const Band& band, const OutputTargets& targets, const CallOptions& call = {},
                 std::span<const cl_event> wait_list = {}) const;

    /// Many boxes in one call, in any order, of any lattices, bands and outputs: the patches of a refined mesh, with
    /// their ghost samples. Each gets the bytes of a call of its own. Boxes of one lattice, one band and the same
    /// outputs are computed together if that is cheaper. Then a sample that several boxes share is computed once, and
    /// slabs are as large as those of compute_slabs(). No two targets may overlap. If a request is refused, nothing is
    /// computed, and the message names its index. Throws what a call for each request would throw.
    /// CallOptions::progress covers all requests. The statistics are sums; their figures of memory are maxima.
    void compute(std::span<const Request> requests, const CallOptions& call = {},
                 std::span<const cl_event> wait_list = {}) const;

    /// The same for fields of any size: hands whole slices to the sink in the order of z, about 16 million samples (64
    /// MiB of distances, 384 MiB of closest points) or 32 slices at a time. All outputs of two slabs are in memory: one
    /// is computed while the sink has the other. The bytes are those of the whole. After an error the sink has returned
    /// and is not called again. Throws what compute() and the sink throw, Error(invalid_argument) for an empty sink.
    void compute_slabs(const Grid& grid, const Band& band, const Outputs& outputs, const SlabSink& sink,
                       const SlabOptions& options = {}, const CallOptions& call = {}) const;

    /// The slabs of compute_slabs() on a device that sets no closer limit.
    static std::vector<Grid> slabs_of(const Grid& grid);

    /// The signed distance at points anywhere, in the mesh's units and in any order, and all else that has a target;
    /// docs/library.md, 'Points', says what each output is. Beyond `within`, which is not negative and may be infinite,
    /// the distance is `within` with the point's sign, and there is no triangle. The sign is that of the exact winding
    /// number (or parity) at the given doubles; a point on the surface has the distance +0. A voxel, as a measure, is
    /// 1/256 of the longest side of the mesh's box, or 1 if the mesh has no extent.
    ///
    /// The points and each target may be memory of the host or of the device, and may share a buffer. A target has
    /// points.count values, packed or strides[0] bytes from point to point. The call begins after the events of
    /// `wait_list`, and returns when the targets are written. Memory of the device is mapped: if the device has its own
    /// memory, points and outputs pass through the host, which sorts the points. Until the call returns, no other
    /// command or call may write to a target's buffer between the target's first and last byte.
    ///
    /// A result depends on the point, `within`, the mesh's positions and the device: not on other points, their order
    /// or number, and not on threads or TransformOptions::method. The first call prepares the mesh and keeps about 550
    /// bytes a triangle, the first one of many points 240 more (TransformOptions::kept_bytes). An error leaves the
    /// targets undefined.
    ///
    /// Throws Error(invalid_argument) that names the index of a point that is not finite or more than 1e14 voxels from
    /// the mesh's box; for a `within` that is negative, NaN or finite beyond a float; for memory too small or of
    /// another context. Error(unsupported) for a buffer that the host may not read or write; Error(out_of_memory or
    /// cancelled).
    void query(const Triples& points, double within, const OutputTargets& targets, const CallOptions& call = {},
               std::span<const cl_event> wait_list = {}) const;
    /// The same of a temporary container.
    template <detail::DyingArray Array>
    void query(Array&& points, double within, const OutputTargets& targets, const CallOptions& call = {}) const {
        query(Triples(points), within, targets, call);
    }

    /// Sets the place of each box. Boxes and half_width are in the mesh's units; boxes include their limits, and may be
    /// points. A box is `near` if it is within half_width of the smallest box around a triangle. So a box that is a
    /// little farther than half_width from the surface may be `near`, too. The other answers are exact. Blocks; cannot
    /// be cancelled.
    ///
    /// An answer depends on the box, half_width and the mesh's positions alone. Works on the host, on all cores. Keeps
    /// what query() keeps. Throws Error(invalid_argument) that names the index of a box with a coordinate that is not
    /// finite or a lower corner above its upper one, for half_width below 0 or NaN, and if there are not as many places
    /// as boxes; Error(out_of_memory).
    void classify(std::span<const Box> boxes, double half_width, std::span<BoxPlace> places) const;

    KeptMemory memory() const;

    /// A plan of one grid, without targets: each Plan::enqueue() gets them. They must be packed and aligned. Blocks;
    /// sizes and fills every buffer. Throws Error(invalid_argument, out_of_memory, device_failure or cancelled).
    Plan plan(const Grid& grid, const Band& band, const Outputs& outputs = {}, const CallOptions& call = {}) const;

    /// The same for the request's targets, buffers of the device's context. Offsets and strides are multiples of the
    /// elements' size. If a target is not packed or not aligned, or has distances in double, the plan computes in its
    /// own memory and copies. Also throws Error(unsupported) for other elements, or for memory of the host.
    Plan plan(const Request& request, const CallOptions& call = {}) const;

    /// The same for many boxes, as compute() has them. The targets must not overlap, and must outlive the plan. Boxes
    /// that share a block with other boxes are copied, too. Throws Error(invalid_argument, unsupported, out_of_memory,
    /// device_failure or cancelled), with the request's index.
    Plan plan(std::span<const Request> requests, const CallOptions& call = {}) const;

    /// The statistics().device_bytes of such a plan, which is made and given back: takes its time and its memory.
    std::size_t plan_bytes(std::span<const Request> requests, const CallOptions& call = {}) const;

private:
    friend class Plan;
    DistanceTransform() = default;
    /// Into memory of the device, by way of a plan.
    void compute_on_device(std::span<const Request> requests, const CallOptions& call,
                           std::span<const cl_event> wait_list) const;
    struct State;
    State& state() const;
    std::unique_ptr<State> state_;
};

}  // namespace clsdf
