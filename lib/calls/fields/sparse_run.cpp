#include "calls/fields/slab_plans.hpp"
#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "core/stopwatch.hpp"
#include "device/read_back.hpp"
#include "plan/slabs.hpp"
#include "targets/host_arrays.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <mutex>
#include <numeric>
#include <vector>

namespace clsdf {

namespace {

using plans::Batch;
using plans::Slab;
using targets::SparseTarget;

using ListHead = std::array<cl_uint, CLSDF_STORED>;

/// The first samples of bricks of a part, which are numbered with x running fastest.
class BrickNumbers {
public:
    explicit BrickNumbers(const Grid& part)
        : first_(part.first), x_(part.size[0] / brick_side), y_(part.size[1] / brick_side) {}

    Index3 operator()(std::int64_t number) const {
        return {first_[0] + number % x_ * brick_side, first_[1] + number / x_ % y_ * brick_side,
                first_[2] + number / x_ / y_ * brick_side};
    }
    std::int64_t row() const { return x_; }

private:
    Index3 first_;
    std::int64_t x_, y_;
};

std::vector<BrickRun> runs_inside(std::span<const cl_uchar> marks, const BrickNumbers& first_of) {
    std::vector<BrickRun> runs;
    const auto row = first_of.row();
    const auto count = static_cast<std::int64_t>(marks.size());
    const auto is_inside = [&](std::int64_t n) { return marks[static_cast<std::size_t>(n)] == CLSDF_INSIDE_BRICK; };
    for (std::int64_t begin = 0; begin < count; begin += row)
        for (std::int64_t n = begin; n < begin + row; ++n) {
            if (!is_inside(n)) continue;
            const std::int64_t from = n;
            while (n < begin + row && is_inside(n)) ++n;
            runs.push_back({first_of(from), n - from});
        }
    return runs;
}

/// The first `bytes` bytes of a buffer whose commands have ended: on a processor the buffer itself, else a copy.
class ReadBuffer {
public:
    ReadBuffer(const device::Context& context, const cl::Buffer& buffer, std::size_t bytes)
        : context_(context), buffer_(buffer) {
        if (bytes == 0) return;
        if (context.capabilities().is_processor) {
            context.run_blocking([&](cl::Event* ended) {
                mapped_ = context.queue().enqueueMapBuffer(buffer, CL_TRUE, CL_MAP_READ, 0, bytes, nullptr, ended);
            });
            return;
        }
        copy_.resize(bytes);
        context.read(context.queue(), buffer, 0, bytes, copy_.data());
    }
    ReadBuffer(const ReadBuffer&) = delete;
    ReadBuffer& operator=(const ReadBuffer&) = delete;
    ~ReadBuffer() {
        if (mapped_ == nullptr) return;
        try {
            context_.queue().enqueueUnmapMemObject(buffer_, mapped_);
        } catch (const cl::Error&) {
            // The queue's next command tells.
        }
    }

    template <class Value>
    const Value* values() const {
        return static_cast<const Value*>(mapped_ != nullptr ? mapped_ : static_cast<const void*>(copy_.data()));
    }

private:
    const device::Context& context_;
    cl::Buffer buffer_;
    void* mapped_ = nullptr;
    UninitializedVector<std::byte> copy_;
};

/// About how many bricks the band overlaps: those of a plane in an average direction, for the mesh's area.
std::size_t expected_bricks(std::span<const Vec3> vertices, std::span<const Triangle> triangles, const Grid& grid,
                            const Band& band, SignRule sign) {
    double area = 0;
    for (const auto& [a, b, c] : triangles) {
        const Vec3 &p = vertices[a], &q = vertices[b], &r = vertices[c];
        std::array<double, 3> u{}, v{};
        for (std::size_t axis = 0; axis < 3; ++axis) u[axis] = q[axis] - p[axis], v[axis] = r[axis] - p[axis];
        area += 0.5 * std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
    }
    const double side =
        static_cast<double>(brick_side) * std::cbrt(grid.spacing[0] * grid.spacing[1] * grid.spacing[2]);
    const double width = band.outside + (sign == SignRule::none ? band.outside : band.inside);
    const double of_grid = static_cast<double>(grid.size[0]) * static_cast<double>(grid.size[1]) *
                           static_cast<double>(grid.size[2]) / static_cast<double>(brick_samples);
    const double expected = 1.1 * area / (side * side) * (1.6 + width / side);
    return static_cast<std::size_t>(std::clamp(expected, 0.0, of_grid)) + 1;
}

}  // namespace

/// Computes a sparse field slab by slab, as HostRun does a dense one. The device stores the values of the bricks in the
/// order in which it ends them; the host puts them into the order of the lattice.
class DistanceTransform::State::SparseRun {
public:
    /// All arguments that are references must outlive this.
    SparseRun(State& state, const Batch& batch, SparseTarget& target, const CallOptions& call)
        : keeps_budget_{state},
          state_(state),
          batch_(batch),
          target_(target),
          slabs_(engine::sparse_slabs_of(batch.job.grid)),
          running_{call},
          plans_(state, state.pool, false, running_) {
        std::ranges::reverse(slabs_);
    }

    CallStatistics run() {
        start();
        while (!slabs_.empty()) {
            const auto divide = [&] {
                make_room();
                return divide_next();
            };
            calls::with_remedies(&running_, {{divide, true}, {[] { return true; }}}, [&] {
                const std::scoped_lock lock(state_.mutex);
                state_.require_sound();  // another call may have run since the last slab
                compute();
                collect();
            });
            deliver();
            slabs_.pop_back();
        }
        {
            const std::scoped_lock lock(state_.mutex);
            running_.statistics.device_bytes = state_.pool->peak();
            running_.statistics.host_bytes = host_bytes_;
        }
        return running_.finish();
    }

private:
    void start() {
        const std::scoped_lock lock(state_.mutex);
        running_.throw_if_stopped();
        state_.compile(batch_.job, running_,
                       {checks::field_subject(state_, batch_.job, checks::FieldKernels::of_sparse_fields)});
        state_.pool->restart_peak();
    }

    /// Computes the next slab, again if its bricks are more than there is room for.
    void compute() {
        const Slab slab{&batch_, slabs_.back()};
        if (!plan_ && slab.is_whole()) plan_ = state_.take_plan(batch_.job);
        if (!plan_) plan_ = plans_.make(slab);
        const double share = share_of(slab.grid);
        // The coarse bricks' lists say how many bricks there may be.
        const auto coarse = static_cast<double>(plan_->statistics.coarse_bricks);
        const std::size_t guess = static_cast<std::size_t>(std::ceil(bricks_of_coarse_ * coarse)) + 64;
        const std::size_t most = target_.most();
        std::size_t room = std::clamp<std::size_t>(guess, 1, std::max<std::size_t>(most, 1));
        for (;;) {
            run_plan(room, share);
            if (count() <= room || count() > most) break;
            room = count();
        }
        if (coarse > 0) bricks_of_coarse_ = std::max(bricks_of_coarse_, 1.1 * static_cast<double>(count()) / coarse);
    }

    double share_of(const Grid& slab) const {
        return static_cast<double>(slab.sample_count()) / static_cast<double>(batch_.job.grid.sample_count());
    }

    void run_plan(std::size_t room, double share) {
        const Stopwatch watch;
        device::Context& context = state_.context();
        device::BufferPool& pool = *state_.pool;
        engine::OutputBuffers buffers;
        for_each_output(
            [&](const OutputInfo& row, const targets::HostArray& array, device::BufferPool::Lease& lease,
                cl::Buffer& buffer) {
                if (!array.is_wanted) return;
                const std::size_t bytes = room * brick_samples * sample_bytes(row, array.in_double);
                if (array.in_double) buffers.in_double |= bit_of(row);
                if (lease.bytes() < bytes) {
                    lease = {};
                    lease = pool.lease_for_list(bytes, "values of the bricks near the surface");
                }
                buffer = *lease;
            },
            batch_.arrays, values_, buffers);
        const std::size_t list_bytes = (CLSDF_STORED + room) * sizeof(cl_uint);
        if (listed_.bytes() < list_bytes) {
            listed_ = {};
            listed_ = pool.lease_for_list(list_bytes, "list of the bricks near the surface");
        }
        buffers.listed = *listed_;
        head_ = {};
        head_[CLSDF_STORED_ROOM] = static_cast<cl_uint>(room);
        context.run_or_drain([&] {
            running_.throw_if_stopped();
            const cl::CommandQueue& queue = context.queue();
            device::write_values(context, head_, *listed_);
            engine::CommandChain chain(queue, {});
            plan_->enqueue(chain, buffers, running_.between(done_, done_ + share));
            context.finish();
            plan_->read_back(queue);
            device::read_values(context, *listed_, head_);
        });
        plan_->statistics.field_seconds = watch.seconds();
    }

    std::size_t count() const { return head_[CLSDF_STORED_COUNT]; }

    bool is_only_counted() const { return count() > target_.most(); }

    /// Puts the slab's bricks in order.
    void collect() {
        const Grid& part = slabs_.back();
        const device::Context& context = state_.context();
        const BrickNumbers first_of(part);
        context.run_or_drain([&] {
            const std::size_t bricks_of_part = part.sample_count() / brick_samples;
            inside_ = runs_inside(
                {ReadBuffer(context, plan_->marks(), bricks_of_part).values<cl_uchar>(), bricks_of_part}, first_of);
            bricks_.clear();
            if (is_only_counted()) return;
            const ReadBuffer list(context, *listed_, (CLSDF_STORED + count()) * sizeof(cl_uint));
            const cl_uint* numbers = list.values<cl_uint>() + CLSDF_STORED;
            std::vector<cl_uint> order(count());
            std::iota(order.begin(), order.end(), cl_uint{0});
            std::ranges::sort(order, {}, [&](cl_uint place) { return numbers[place]; });
            bricks_.resize(count());
            for (std::size_t n = 0; n < count(); ++n) bricks_[n] = first_of(numbers[order[n]]);
            const targets::HostArrays to = target_.room(count());
            for_each_output(
                [&](const OutputInfo& row, const targets::HostArray& array, const device::BufferPool::Lease& lease) {
                    if (!array.is_wanted) return;
                    const std::size_t bytes = brick_samples * row.sample_bytes();
                    const ReadBuffer values(context, *lease, count() * bytes);
                    const auto* from = values.values<std::byte>();
                    constexpr std::size_t grain = 64;
                    for_each_index(
                        count(),
                        [&](std::size_t n) {
                            std::byte* const place = array.data + n * bytes;
                            // Bricks with both signs and no sample in the band have distances only.
                            if (row.output != Output::distance && order[n] >= head_[CLSDF_STORED_IN_BAND])
                                std::memset(place, 0xFF, bytes);
                            else
                                std::memcpy(place, from + order[n] * bytes, bytes);
                        },
                        grain);
                },
                to, values_);
        });
    }

    void deliver() {
        const Grid part = slabs_.back();
        done_ += share_of(part);
        {
            const std::scoped_lock lock(state_.mutex);
            add_slab(running_.statistics, plan_->statistics);
            const Slab slab{&batch_, part};
            if (slab.is_whole()) {
                state_.keep(std::move(plan_));
                plans_.release();
                values_ = {};
                listed_ = {};
                state_.keep_within_budget();
            }
            plan_.reset();
        }
        std::size_t bytes = bricks_.size() * sizeof(Index3);
        for (const OutputInfo& row : output_table())
            if (batch_.arrays[row.output].is_wanted) bytes += bricks_.size() * brick_samples * row.sample_bytes();
        host_bytes_ = std::max(host_bytes_, bytes);
        if (is_only_counted())
            target_.count(count(), {part, {}, {}, inside_});
        else
            target_.take({part, bricks_, {}, inside_});
        if (slabs_.size() > 1) running_.report({.fraction = done_});
    }

    /// Releases what the next slab had, and what is kept for later calls.
    void make_room() {
        const std::scoped_lock lock(state_.mutex);
        device::guarded([&] { state_.context().finish(); });
        values_ = {};
        listed_ = {};
        plan_.reset();
        state_.forget();
    }

    /// Returns whether the next slab was divided.
    bool divide_next() {
        const Grid slab = slabs_.back();
        if (!engine::is_divisible(slab)) return false;
        const auto [lower, upper] = engine::halves_of(slab);
        slabs_.back() = upper;
        slabs_.push_back(lower);
        return true;
    }

    KeepsBudget keeps_budget_;  // destroyed last, when the other members have released their memory
    State& state_;
    const Batch& batch_;
    SparseTarget& target_;
    std::vector<Grid> slabs_;  ///< the next one is the last
    calls::RunningCall running_;
    SlabPlans plans_;
    std::unique_ptr<engine::GridPlan> plan_;  ///< of the next slab
    PerOutput<device::BufferPool::Lease> values_;
    device::BufferPool::Lease listed_;
    ListHead head_{};
    double bricks_of_coarse_ = 24;  ///< that have values, at most, of those slabs so far
    double done_ = 0;               ///< the share of the samples
    std::vector<Index3> bricks_;    ///< of the latest slab
    std::vector<BrickRun> inside_;
    std::size_t host_bytes_ = 0;
};

engine::Job DistanceTransform::State::check_sparse(const Grid& grid, const Band& band, OutputSet extras,
                                                   bool counts) const {
    grid.validate();
    band.validate();
    if (band.has_signs_only)
        refuse(
            "a sparse field has the distances near the surface, and the signs alone are asked for; give the "
            "band a width, or compute a dense field");
    if (!std::isfinite(band.outside) || (sign != SignRule::none && !std::isfinite(band.inside)))
        refuse(
            "a sparse field needs a band with an end, and its half widths are {} inside and {} "
            "outside; give it finite ones, or compute a dense field",
            band.inside, band.outside);
    if (method)
        refuse_unsupported(
            "sparse fields are computed from leaned frusta, scanned by bricks, alone; compute a dense field");
    const Grid bricks = in_whole_bricks(grid);
    bricks.validate();
    return check({bricks, band, extras, {}, counts});
}

CallStatistics DistanceTransform::State::compute_sparse(const engine::Job& job, const SparseSink& sink,
                                                        const CallOptions& call) {
    const Batch batch{.job = job, .arrays = targets::arrays_for(job.outputs)};
    targets::SinkTarget target(batch.arrays, sink);
    return SparseRun(*this, batch, target, call).run();
}

CallStatistics DistanceTransform::State::compute_sparse(const engine::Job& job, SparseField& field,
                                                        const CallOptions& call) {
    const Batch batch{.job = job, .arrays = targets::arrays_for(job.outputs)};
    const std::size_t expected = [&] {
        const std::scoped_lock lock(mutex);
        context().begin_call();
        return expected_bricks(kept_mesh->present().positions, kept_mesh->triangles(), job.grid, job.band, sign);
    }();
    targets::FieldTarget target(batch.arrays, field, expected);
    return SparseRun(*this, batch, target, call).run();
}

CallStatistics DistanceTransform::State::compute_sparse(const engine::Job& job, const targets::SparseArrays& arrays,
                                                        SparseCounts& counts, const CallOptions& call) {
    const Batch batch{.job = job, .arrays = targets::arrays_for(job.outputs)};
    targets::ArraysTarget target(arrays, counts);
    return SparseRun(*this, batch, target, call).run();
}

CallStatistics DistanceTransform::State::compute_sparse(std::span<const engine::Job> jobs,
                                                        std::span<SparseField> fields, const CallOptions& call) {
    std::vector<targets::HostArrays> arrays;
    for (const engine::Job& job : jobs) arrays.push_back(targets::arrays_for(job.outputs));
    const std::vector<Batch> batches =
        plans::batches_of(jobs, std::span<const targets::HostArrays>(arrays), kept_mesh->box());
    double cost = 0, done = 0;
    for (const Batch& batch : batches) cost += batch.cost;
    CallStatistics total;
    for (const Batch& batch : batches) {
        const SparseSink sink = [&](const SparseSlab& part) {
            for_each_index(batch.requests.size(), [&](std::size_t n) {
                const std::size_t request = batch.requests[n];
                targets::add_part(part, {jobs[request].grid, &fields[request]});
            });
        };
        targets::SinkTarget target(batch.arrays, sink);
        const double share = batch.cost / cost;
        add_call(total, SparseRun(*this, batch, target, calls::part_of(call, done, done + share)).run());
        done += share;
    }
    return total;
}

}  // namespace clsdf
