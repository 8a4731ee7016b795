#pragma once

#include <clsdf/arrays.hpp>
#include <clsdf/calls.hpp>
#include <clsdf/export.hpp>
#include <clsdf/fractions.hpp>
#include <clsdf/outer.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

typedef struct _cl_command_queue* cl_command_queue;

namespace clsdf {

class Device;

/// The number of rows that a run of a FractionPlan finds, in this layout.
struct DeviceFractionCount {
    std::uint64_t rows = 0;  ///< cells that the surface meets, also if there is less room; 0 if `is_complete` is 0 and
                             ///< the memory of the plan itself is too small, or a vertex is 2^53 cells away or more
    std::uint64_t is_complete = 0;  ///< 1: the arrays hold all rows; 0: they are as before

    friend bool operator==(const DeviceFractionCount&, const DeviceFractionCount&) = default;
};

/// Fractions of the cells of a grid that go to the caller's device memory again and again, of a surface whose vertices
/// may move. Kernels find and compute them in each run, in memory of the plan. They have the bytes of fractions(). The
/// destructor waits for the runs. One thread at a time. Once moved from, every member but assignment and the destructor
/// throws Error(invalid_argument).
class CLSDF_EXPORT FractionPlan {
public:
    /// room: the most rows of a run. The plan's own memory is for a quarter more triangles in cells than the surface
    /// has there now, and for `room` rows. Finds the rows once, to know that. Blocks. Throws Error(invalid_argument) as
    /// fractions() does; Error(unsupported) for a grid or a surface whose cells and faces 32 bits cannot number: 6e8
    /// cells, 1.4e9 triangles; Error(wrong_results) if the device's kernels are found to be wrong;
    /// Error(out_of_memory); Error(device_failure). Of `call`, should_stop and progress count.
    FractionPlan(const Device& device, const OuterSurface& surface, const Grid& grid, std::size_t room,
                 const FractionOptions& options = {}, const CallOptions& call = {});
    FractionPlan(FractionPlan&&) noexcept;
    FractionPlan& operator=(FractionPlan&&) noexcept;
    ~FractionPlan();

    const Grid& grid() const;
    const FractionOptions& options() const;
    std::size_t room() const;
    /// Of the surface.
    std::size_t vertex_count() const;
    /// How many cells the surface met when the plan was made or updated.
    std::size_t row_count() const;

    /// Enqueues the rows into these buffers of the device's context on the caller's queue (null: the device's own),
    /// after the events of `wait_list`. Never blocks and never allocates device memory. If `done` is not null, it gets
    /// the event of the end, which the caller releases. May be called again at once, on any queue of the device's
    /// context, in order or not: runs of a plan follow one another.
    ///
    /// rows: of any offset and strides; rows.room may be less than room(). Rows beyond their number stay as they are.
    /// `full` needs no room, unless there are arrays of rows, too. count: gets a DeviceFractionCount; may be missing.
    ///
    /// Throws Error(invalid_argument) for memory that is read-only, too small, of another context or no buffer, for
    /// arrays that overlap and for more room than the plan has; Error(unsupported) for memory of the host and other
    /// types; Error(device_failure), also for an event that has failed. Then nothing is enqueued. Error(out_of_memory):
    /// the host's memory does not suffice. Some commands may be enqueued then, and the next run follows them.
    void enqueue(cl_command_queue queue, const FractionRows& rows, const DeviceRange& count,
                 std::span<const cl_event> wait_list = {}, cl_event* done = nullptr);
    /// The same for other vertices of the surface, in memory of the device: as many, of float or double, of any
    /// strides, read when the run begins. Its faces then must not meet but in common edges and vertices, as those of a
    /// rigid body; this is not checked.
    void enqueue(cl_command_queue queue, const InputArray& vertices, const FractionRows& rows, const DeviceRange& count,
                 std::span<const cl_event> wait_list = {}, cl_event* done = nullptr);

    /// Another surface, and another grid and other room, for the next runs. Blocks: waits for the last run. Throws as
    /// the constructor. After an error the plan is as it was.
    void update(const OuterSurface& surface, const CallOptions& call = {});
    void update(const OuterSurface& surface, const Grid& grid, std::size_t room, const CallOptions& call = {});

    /// Of making or updating it. device_bytes: what the plan has on the device.
    const TransformStatistics& statistics() const;

private:
    struct State;
    State& state() const;
    std::unique_ptr<State> state_;
};

}  // namespace clsdf
