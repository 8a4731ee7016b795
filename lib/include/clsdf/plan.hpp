#pragma once

#include <clsdf/calls.hpp>
#include <clsdf/export.hpp>
#include <clsdf/topology.hpp>

#include <memory>
#include <span>

typedef struct _cl_command_queue* cl_command_queue;

namespace clsdf {

class DistanceTransform;

/// Boxes that are computed again and again into the caller's device memory: DistanceTransform::plan(). A plan holds all
/// that depends on positions, grids and bands. It has its own copy of what it needs and may outlive the transform; its
/// destructor waits for what it has enqueued. One thread at a time. Once moved from, every member but assignment and
/// the destructor throws Error(invalid_argument).
class CLSDF_EXPORT Plan {
public:
    Plan(Plan&&) noexcept;
    Plan& operator=(Plan&&) noexcept;
    ~Plan();

    /// One without targets if the plan was made from a grid.
    std::span<const Request> requests() const;
    SignRule sign() const;

    /// Enqueues the computation of all requests into their targets on the caller's queue (null: the device's own),
    /// after the events of `wait_list`. Never blocks and never allocates device memory. If `done` is not null, it gets
    /// the event of the end, which the caller releases. May be called again at once, on any queue of the device's
    /// context, in order or not: runs of a plan follow one another.
    ///
    /// Throws Error(device_failure), also for an event that has failed; Error(invalid_argument) for a plan that was
    /// made without targets, after a failed update(), and for a queue or an event of another context.
    void enqueue(cl_command_queue queue, std::span<const cl_event> wait_list = {}, cl_event* done = nullptr);

    /// Enqueues one run that writes to other targets: one OutputTargets for each request. This is for codes that swap
    /// two sets of arrays. The outputs are those of the plan. If a request's array is packed and aligned
    /// (OutputTargets), the new one must be so, too; a plan without targets takes only such arrays. The replacement of
    /// any other array may have another offset and other strides; its type must be the same. A copied box whose offset
    /// or strides differ from those of the run before costs one small command.
    ///
    /// Also throws Error(invalid_argument) if there are not as many targets as requests, for arrays that overlap, and
    /// for memory that is missing, read-only, too small or no buffer; Error(unsupported) for other targets. Then
    /// nothing is enqueued. Error(out_of_memory): the host's memory does not suffice. Some commands may be enqueued
    /// then, and the next run follows them.
    void enqueue(cl_command_queue queue, std::span<const OutputTargets> targets,
                 std::span<const cl_event> wait_list = {}, cl_event* done = nullptr);
    /// The same of a plan with one request.
    void enqueue(cl_command_queue queue, const OutputTargets& targets, std::span<const cl_event> wait_list = {},
                 cl_event* done = nullptr);

    /// Prepares the next runs for the present positions of `transform`, which made the plan or has its Device. Blocks:
    /// waits for the last run, and replaces the plan's buffers, so that enqueue() need not. The bytes are those of a
    /// new plan. Throws Error(invalid_argument, out_of_memory, device_failure or cancelled). After an error the plan
    /// must be updated again before enqueue(), but for requests or grids that are refused: these leave it as it was.
    void update(const DistanceTransform& transform, const CallOptions& call = {});
    /// The same with a grid for each request, of any lattice, whose samples fit the request's targets.
    void update(const DistanceTransform& transform, std::span<const Grid> grids, const CallOptions& call = {});
    /// The same with other requests, any number of them: the boxes of a mesh that was refined anew. The plan uses its
    /// buffers again if they are large enough. Also throws Error(unsupported).
    void update(const DistanceTransform& transform, std::span<const Request> requests, const CallOptions& call = {});
    void update(const DistanceTransform& transform, const BlockSet& blocks, const CallOptions& call = {});

    /// Of making or updating it. device_bytes: what the plan has on the device, beside what the transform keeps, too.
    const TransformStatistics& statistics() const;

private:
    friend class DistanceTransform;
    struct State;
    explicit Plan(std::unique_ptr<State> state);
    State& state() const;
    std::unique_ptr<State> state_;
};

}  // namespace clsdf
