#pragma once

#include <clsdf/arrays.hpp>
#include <clsdf/calls.hpp>
#include <clsdf/export.hpp>
#include <clsdf/segments.hpp>
#include <clsdf/topology.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

typedef struct _cl_command_queue* cl_command_queue;

namespace clsdf {

class DistanceTransform;

/// The number of links that a run of a LinkPlan writes, in this layout. It is that of the grid's links, also if there
/// is less room.
struct DeviceLinkCount {
    std::uint64_t links = 0;
    std::uint64_t is_complete =
        0;  ///< 1: the arrays hold all links; 0: there is too little room, and they are as before

    friend bool operator==(const DeviceLinkCount&, const DeviceLinkCount&) = default;
};

/// Links of a grid that go to the caller's device memory again and again: DistanceTransform::plan_links(). They are
/// found when the plan is made or updated, on a GPU by kernels; a run copies them within the device, reads nothing back
/// and waits for nothing. They have the bytes of DistanceTransform::links(). Otherwise it is as a Plan: it may outlive
/// the transform, and its destructor waits for its runs. One thread at a time. Once moved from, every member but
/// assignment and the destructor throws Error(invalid_argument).
class CLSDF_EXPORT LinkPlan {
public:
    LinkPlan(LinkPlan&&) noexcept;
    LinkPlan& operator=(LinkPlan&&) noexcept;
    ~LinkPlan();

    const Grid& grid() const;
    std::span<const LinkDirection> directions() const;
    const LinkOptions& options() const;
    /// The most rows of a run.
    std::size_t room() const;
    SignRule sign() const;

    /// Enqueues the links into these buffers of the device's context on the caller's queue (null: the device's own),
    /// after the events of `wait_list`. Never blocks and never allocates device memory. If `done` is not null, it gets
    /// the event of the end, which the caller releases. May be called again at once, on any queue of the device's
    /// context, in order or not: runs of a plan follow one another.
    ///
    /// targets: of any offset and strides; targets.room may be less than room(). Rows beyond the number of links stay
    /// as they are; `dense` without arrays of rows needs the plan's room alone. count: gets a DeviceLinkCount; may be
    /// missing.
    ///
    /// Throws Error(invalid_argument) for memory that is read-only, too small, of another context or no buffer, for
    /// arrays that overlap and for more room than the plan has; Error(unsupported) for memory of the host and other
    /// types; Error(device_failure), also for an event that has failed. Then nothing is enqueued. Error(out_of_memory):
    /// the host's memory does not suffice. Some commands may be enqueued then, and the next run follows them.
    void enqueue(cl_command_queue queue, const LinkTargets& targets, const DeviceRange& count,
                 std::span<const cl_event> wait_list = {}, cl_event* done = nullptr);

    /// Prepares the next runs for the present positions of `transform`, which made the plan or has its Device. Blocks:
    /// waits for the last run. Throws what plan_links() throws, and Error(invalid_argument) for a transform of another
    /// Device. After an error the plan is as it was.
    void update(const DistanceTransform& transform, const CallOptions& call = {});
    /// The same with another grid and other room.
    void update(const DistanceTransform& transform, const Grid& grid, std::size_t room, const CallOptions& call = {});

    /// Of making or updating it. device_bytes: what the plan has on the device.
    const TransformStatistics& statistics() const;

private:
    friend class DistanceTransform;
    struct State;
    explicit LinkPlan(std::unique_ptr<State> state);
    State& state() const;
    std::unique_ptr<State> state_;
};

}  // namespace clsdf
