#pragma once

#include <clsdf/export.hpp>
#include <clsdf/field.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/outputs.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

typedef struct _cl_event* cl_event;

/// What the calls of a DistanceTransform and of a Plan take and return.
namespace clsdf {

/// How far a call is.
struct Progress {
    enum class Stage : std::int32_t {
        compiling = 0,  ///< programs are built or loaded
        computing = 1,
        testing = 2,  ///< programs that were compiled compute a known field; a step of compiling, too
    };

    Stage stage = Stage::computing;
    double fraction = 0;    ///< of the stage, 0 to 1; of compiling and testing an estimate that need not reach 1
    std::size_t step = 0;   ///< of compiling, from 1
    std::size_t steps = 0;  ///< of compiling, at most; >= step
};

/// Options of one call; constructors and plans take them, too. The functions are called until the call returns, and on
/// the thread that called. They must not make or use transforms of the device: a call that would wait for the one at
/// work throws Error(invalid_argument). Their exceptions end the call and are passed on.
struct CallOptions {
    /// Called between launches of calls that compute, and before each step of building programs; with outputs in memory
    /// of the device only at the end. A plan's runs have no progress: they do not return to the host.
    std::function<void(const Progress& progress)> progress{};
    /// Asked between launches and before each step of building programs; if it says true, Error(cancelled) is thrown.
    std::function<bool()> should_stop{};
    /// Warnings of this call, as of the mesh's sign rule or of points that are not finite.
    std::function<void(const std::string& message)> log{};
    /// The call reads and writes the caller's memory after these events, which belong to the device's context.
    std::span<const cl_event> wait_list{};
    /// For measuring: the device counts the work, which takes time. Plans do not count.
    bool count_work = false;
    /// Of query(): a point that is not finite, or too far from the mesh, is Error(invalid_argument) that names it.
    /// Otherwise it gets no distance, and `log` gets one warning with the count.
    bool refuse_unusable_points = false;
};

struct WorkCounts;

/// Times and memory of a call. Times are the host's wall-clock seconds. Work that the device has not finished when the
/// host continues is counted in the next stage.
struct TransformStatistics {
    std::size_t slabs = 0;  ///< parts of the grid that were computed one after the other; 1: all at once
    /// The most that buffers on the device took at once; of a Plan, its own buffers. A field that is computed in place,
    /// on a processor, is not among them.
    std::size_t device_bytes = 0;
    /// The library's own arrays on the host for slabs.
    std::size_t host_bytes = 0;

    double compile_seconds = 0;  ///< building or loading the device's programs and testing them; in none of the others
    /// In this call programs computed for the first time on this device, and were tested (records: see
    /// Device::keep_records()): compile_seconds is what that took.
    bool first_use = false;
    double polyhedra_seconds = 0;  ///< preparing the mesh
    double field_seconds = 0;      ///< the samples or points

    std::size_t unusable_points = 0;  ///< of query(): points that are not finite or too far from the mesh

    /// For measuring: clsdf/tuning.hpp. Never null after a call.
    std::shared_ptr<const WorkCounts> work{};
};

/// Memory that a transform keeps between calls, in bytes, beside the mesh itself and the free buffers that it uses
/// again.
struct KeptMemory {
    std::size_t host_bytes = 0;    ///< what follows from the triangles and the positions
    std::size_t device_bytes = 0;  ///< within TransformOptions::kept_bytes
    // Of the transform's Device, for all its transforms; Device::release_memory() gives them back.
    std::size_t shared_host_bytes = 0;    ///< for copies, most of it pinned
    std::size_t shared_device_bytes = 0;  ///< that no transform uses
};

/// One box of many.
struct Request {
    Grid grid;
    Band band;
    OutputTargets targets;
};

/// Equal blocks of one lattice: the leaves of an octree, the patches of a level. A block takes 24 bytes, where a
/// Request takes over 200.
struct BlockSet {
    Grid lattice;  ///< its origin and spacing count
    Band band;
    Index3 size{};                    ///< samples of each block
    std::span<const Index3> first{};  ///< the first sample of each block, on the lattice
    /// The arrays of the first block; those of the others follow by OutputArray::block_stride.
    OutputTargets targets;
};

/// A box of the domain, and what is asked in it: see DistanceTransform::restrict_to().
struct Region {
    Box box;
    double half_width = 0;  ///< the largest distance asked for, of bands, points and boxes; positive and finite
    double spacing = 0;     ///< the largest spacing of grids; 0 if there are only points and boxes
};

/// The position of a box relative to a mesh. The values of the enumerators never change.
enum class BoxPlace : std::uint8_t {
    within = 0,   ///< the surface may be within the half width of a point of the box
    inside = 1,   ///< the surface is farther from every point of the box, and all of them are inside
    outside = 2,  ///< the same, and all of them are outside
    beyond = 3,   ///< the same, of a mesh that has no sign
};

/// Called with the slabs of a field, one after the other: whole slices, the samples of `part` of its grid. The values
/// are there until it returns. It may use the transform. Its exceptions are passed on; std::bad_alloc becomes
/// Error(out_of_memory).
using SlabSink = std::function<void(const Grid& part, const FieldSlab& values)>;

/// How a field is computed slab by slab.
struct SlabOptions {
    /// The sink is called on a thread of its own, while the next slab is computed; else on the calling thread, between
    /// slabs.
    bool sink_has_own_thread = false;
};

}  // namespace clsdf
