#pragma once

#include <clsdf/arrays.hpp>
#include <clsdf/calls.hpp>
#include <clsdf/export.hpp>
#include <clsdf/sparse.hpp>
#include <clsdf/topology.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

typedef struct _cl_command_queue* cl_command_queue;

/// Sparse fields that stay in memory of the device. docs/sparse.md.
namespace clsdf {

class DistanceTransform;

/// The counts that a run of a SparsePlan writes, in this layout. They are those of the whole field, also if
/// the arrays have less room.
struct DeviceSparseCounts {
    std::uint64_t bricks = 0;
    std::uint64_t runs = 0;
    std::uint64_t is_complete = 0;  ///< 1: the arrays hold the field; 0: they had too little room, and are undefined

    friend bool operator==(const DeviceSparseCounts&, const DeviceSparseCounts&) = default;
};

/// The caller's memory of the device for a sparse field; none of it overlaps. It needs room for what the plan has room
/// for.
struct SparseDeviceTargets {
    DeviceRange counts;  ///< a DeviceSparseCounts
    DeviceRange bricks;  ///< Index3 of each brick, as in SparseTargets; not needed without room for bricks
    DeviceRange inside;  ///< a BrickRun each; not needed without room for runs
    /// Packed arrays of 512 samples for each brick that there is room for, with the plan's outputs and the types of
    /// output_table(); the triangle may also be int32. Not needed without room for bricks.
    OutputTargets values{};
};

/// A sparse field that is computed again and again into the caller's device memory: DistanceTransform::plan_sparse().
/// Counts, bricks and values stay there: a run reads nothing back and waits for nothing. They have the bytes and the
/// order of DistanceTransform::compute_sparse(). Otherwise it is as a Plan: it may outlive the transform, and its
/// destructor waits for its runs. One thread at a time. Once moved from, every member but assignment and the destructor
/// throws Error(invalid_argument).
class CLSDF_EXPORT SparsePlan {
public:
    SparsePlan(SparsePlan&&) noexcept;
    SparsePlan& operator=(SparsePlan&&) noexcept;
    ~SparsePlan();

    const SparseRequest& request() const;
    /// How many bricks and runs its runs have room for.
    const SparseCounts& room() const;
    SignRule sign() const;

    /// Enqueues the computation into this memory on the caller's queue (null: the device's own), after the events of
    /// `wait_list`. Never blocks and never allocates device memory. If `done` is not null, it gets the event of the
    /// end, which the caller releases. May be called again at once, on any queue of the device's context, in order or
    /// not: runs of a plan follow one another.
    ///
    /// Throws Error(invalid_argument) for memory that is missing, read-only, too small, of another context or no
    /// buffer, for arrays that overlap and outputs that the plan has not, and after a failed update();
    /// Error(unsupported) for doubles, strides and memory of the host; Error(device_failure), also for an event that
    /// has failed. Error(out_of_memory): the host's memory does not suffice.
    void enqueue(cl_command_queue queue, const SparseDeviceTargets& targets, std::span<const cl_event> wait_list = {},
                 cl_event* done = nullptr);

    /// Prepares the next runs for the present positions of `transform`, which made the plan or has its Device. Blocks:
    /// waits for the last run. Throws as Plan::update() does.
    void update(const DistanceTransform& transform, const CallOptions& call = {});
    /// The same with another grid, band and outputs, and with other room: after a field that had too little, or for a
    /// grid that follows its mesh.
    void update(const DistanceTransform& transform, const SparseRequest& request, const SparseCounts& room,
                const CallOptions& call = {});

    /// Of making or updating it. device_bytes: what the plan has on the device, beside what the transform keeps, too.
    const TransformStatistics& statistics() const;

private:
    friend class DistanceTransform;
    struct State;
    explicit SparsePlan(std::unique_ptr<State> state);
    State& state() const;
    std::unique_ptr<State> state_;
};

}  // namespace clsdf
