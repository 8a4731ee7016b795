#pragma once

#include <clsdf/arrays.hpp>
#include <clsdf/calls.hpp>
#include <clsdf/export.hpp>
#include <clsdf/outputs.hpp>
#include <clsdf/topology.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

typedef struct _cl_command_queue* cl_command_queue;

namespace clsdf {

class DistanceTransform;

/// The outcome of a point in a PointPlan's run. The values of the enumerators never change.
enum class PointStatus : std::uint8_t {
    found = 0,
    not_finite = 1,  ///< the distance is NaN; there is no triangle
    too_far = 2,     ///< the distance is the half width, or NaN if that is infinite; there is no triangle
    /// The distance is NaN, and there is no triangle: exact arithmetic did not suffice for the sign. Only a point may
    /// be left so that has a coordinate below 2^-300 units, but not 0, a unit being about 1/256 of the mesh. It lies in
    /// the mesh's box, or anywhere if open edges count. It is left if open edges count, if the mesh has coordinates
    /// beyond 2^-60 and 2^40, if a coordinate of the point, the small one included, is between 2^-424 and 2^-60, or if
    /// two below 2^-424 differ by a factor above 2^90. query() has its sign.
    sign_open = 3,
};

/// Points in memory of the device that are looked up again and again: DistanceTransform::plan_points(). A run has the
/// bytes of query(), but for PointStatus::sign_open. Nothing of it comes to the host. The plan has its own copy of what
/// it needs and may outlive the transform; its destructor waits for what it has enqueued. One thread at a time. Once
/// moved from, every member but assignment and the destructor throws Error(invalid_argument).
class CLSDF_EXPORT PointPlan {
public:
    PointPlan(PointPlan&&) noexcept;
    PointPlan& operator=(PointPlan&&) noexcept;
    ~PointPlan();

    /// The most points of a run.
    std::size_t count() const;
    double half_width() const;
    /// With the distance.
    OutputSet outputs() const;
    SignRule sign() const;

    /// Enqueues the search for points.count points, at most count(), on the caller's queue (null: the device's own),
    /// after the events of `wait_list`. Points and targets are buffers of the device's context, with any offset and
    /// strides, one target for each of outputs(). Never blocks and never allocates device memory. If `done` is not
    /// null, it gets the event of the end, which the caller releases. May be called again at once, on any queue of the
    /// device's context, in order or not: runs of a plan follow one another.
    ///
    /// status: an array of bytes, one PointStatus of each point, or none. Nothing else tells of points without a
    /// distance.
    ///
    /// Throws Error(invalid_argument) for too many points, for memory that is missing, too small, no buffer, of another
    /// context or may not be used so, for arrays that overlap, and for a queue or an event of another context;
    /// Error(unsupported) for memory of the host and types that are not written; Error(device_failure), also for an
    /// event that has failed. Then nothing is enqueued. Error(out_of_memory): the host's memory does not suffice. Some
    /// commands may be enqueued then, and the next run follows them.
    void enqueue(cl_command_queue queue, const InputArray& points, const OutputTargets& targets,
                 std::span<const cl_event> wait_list = {}, cl_event* done = nullptr, const OutputArray& status = {});

    /// Prepares the next runs for the present positions of `transform`, which made the plan or has its Device. Blocks:
    /// waits for the last run. The bytes are those of a new plan. Throws what plan_points() throws, and
    /// Error(invalid_argument) for a transform of another Device. After an error the plan is as it was.
    void update(const DistanceTransform& transform, const CallOptions& call = {});

    /// Of making or updating it. device_bytes: what the plan has on the device, beside what the transform keeps, too.
    const TransformStatistics& statistics() const;

private:
    friend class DistanceTransform;
    struct State;
    explicit PointPlan(std::unique_ptr<State> state);
    State& state() const;
    std::unique_ptr<State> state_;
};

}  // namespace clsdf
