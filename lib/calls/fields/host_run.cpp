#include "calls/fields/slab_plans.hpp"
#include "checks/known_targets.hpp"
#include "core/common_part.hpp"
#include "core/parallel.hpp"
#include "core/stopwatch.hpp"
#include "plan/slabs.hpp"
#include "targets/slab_pipeline.hpp"
#include "targets/stored_boxes.hpp"

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>

namespace clsdf {

namespace {

using engine::Job;
using plans::Batch;
using plans::Slab;

/// The bytes of samples that are worth two or three more launches, so that a half of them is read while the other is
/// computed.
constexpr std::size_t least_bytes_in_halves = std::size_t{8} << 20;

/// Computes a plan's samples, which are [begin, end) of the call's work, and returns when they are there. gather:
/// enqueues the commands behind them. in_halves: reads the samples into their arrays, too, the lower half while the
/// upper one is computed.
void run(engine::GridPlan& plan, const targets::OutputMemories& memories, calls::RunningCall& running, double begin,
         double end, const std::function<void(engine::CommandChain&)>& gather, bool in_halves) {
    const Stopwatch watch;
    const device::Context& context = device::context_of(plan.device);
    // Its commands write to the caller's memory.
    context.run_or_drain([&] {
        running.throw_if_stopped();
        engine::CommandChain chain(context.queue(), {});
        plan.enqueue(chain, memories.buffers, running.between(begin, end));
        gather(chain);
        memories.enqueue_handover(context.queue());
        const engine::GridPlan::Samples& lower = plan.lower_half();
        const bool is_read = in_halves && lower.end > 0;
        if (is_read) {
            context.queue().flush();
            memories.read(context, context.transfers(),
                          {device::Milestone{lower.end, lower.complete}, {memories.samples, chain.last()}});
        }
        context.finish();
        plan.read_back(context.queue());
        plan.statistics.field_seconds = watch.seconds();
        if (in_halves && !is_read) memories.read(context, context.queue());
    });
}

/// The boxes of a slab that its requests ask for, if the device has memory of its own and they are few: the device
/// gathers them, so that they alone come to the host.
class Gathering {
public:
    Gathering(const device::Context& context, const Slab& slab, std::span<const Request> requests) {
        if (!context.capabilities().has_own_memory || slab.batch->requests.size() < 2) return;
        for (const std::size_t n : slab.batch->requests) {
            boxes_.push_back(common_part(slab.grid, requests[n].grid));
            starts_.push_back(samples_);
            if (boxes_.back()) samples_ += boxes_.back()->sample_count();
        }
        // To copy them takes time, too.
        if (samples_ > slab.grid.sample_count() / 10 * 9) *this = {};
    }

    bool is_empty() const { return samples_ == 0; }
    std::size_t samples() const { return samples_; }

    /// visit(request of the batch, its box, where its samples begin)
    template <class Visit>
    void for_each_box(const Visit& visit) const {
        for (std::size_t n = 0; n < boxes_.size(); ++n)
            if (boxes_[n]) visit(n, *boxes_[n], starts_[n]);
    }

    /// Copies the boxes of a slab's samples on the device.
    void enqueue(engine::CommandChain& chain, const device::Context& context, const cl::Program& program,
                 const Grid& slab, const targets::OutputMemories& from, const targets::OutputMemories& to) {
        for_each_output(
            [&](const OutputInfo& row, const targets::HostArray& array, const cl::Buffer& samples,
                const cl::Buffer& gathered) {
                if (!array.is_wanted) return;
                const std::size_t bytes = sample_bytes(row, array.in_double);
                std::vector<targets::TargetBox> places;
                for_each_box([&](std::size_t, const Grid& box, std::size_t start) {
                    OutputArray packed;
                    packed.offset = start * bytes;
                    const auto sample = static_cast<std::ptrdiff_t>(bytes);
                    packed.strides = {sample, sample * box.size[0], sample * box.size[0] * box.size[1]};
                    packed.component_stride = sample / static_cast<std::ptrdiff_t>(row.components);
                    places.push_back({gathered(), *targets::stored_box(slab, box, packed)});
                });
                stores_.emplace_back(context, program, slab,
                                     targets::StoredElements{row.components, bytes / row.components}, samples,
                                     std::move(places));
                stores_.back().enqueue(chain);
            },
            from.arrays, from.buffers, to.buffers);
    }

private:
    Gathering() = default;

    std::vector<std::optional<Grid>> boxes_;  // of each request of the batch
    std::vector<std::size_t> starts_;
    std::size_t samples_ = 0;
    std::vector<targets::BoxStore> stores_;
};

}  // namespace

/// Computes slabs one after another, each in the arrays of its request or in memory that is handed on to store(). If
/// memory is short, a slab is divided; one that cannot be divided is tried once more when what is kept for later calls
/// has been released.
class DistanceTransform::State::HostRun {
public:
    /// The values of a slab; gathered: of the boxes that its requests ask for, one after another.
    using Store = std::function<void(const Slab& slab, const Gathering& gathered, const targets::HostArrays& values)>;

    /// All arguments that are references must outlive this. requests: those that the batches name. overlap: the next
    /// slab is computed while one is stored.
    HostRun(State& state, std::span<const Batch> batches, std::span<const Request> requests, bool overlap,
            const Store& store, const CallOptions& call)
        : keeps_budget_{state},
          state_(state),
          batches_(batches),
          requests_(requests),
          store_(store),
          slabs_(plans::slabs_of(batches, engine::stream_limits_of(capabilities()), engine::limits_of(capabilities()))),
          running_{call},
          plans_(state, state.pool, false, running_),
          pipeline_(state.context(), overlap && slabs_.size() > 1),
          is_single_(slabs_.size() == 1) {
        std::ranges::reverse(slabs_);
        for (const Batch& batch : batches) cost_ += batch.cost;
    }

    CallStatistics run() {
        start();
        while (!slabs_.empty()) {
            targets::SlabPipeline::Slot* slot = &pipeline_.next();
            std::shared_ptr<Gathering> gathering;
            const auto divide = [&] {
                make_room(*slot);
                slot = &pipeline_.next();
                return divide_next();
            };
            // The length of a slab's lists is known only when they are made.
            calls::with_remedies(&running_, {{divide, true}, {[] { return true; }}}, [&] {
                const std::scoped_lock lock(state_.mutex);
                state_.require_sound();  // another call may have run since the last slab
                gathering = std::make_shared<Gathering>(state_.context(), slabs_.back(), requests_);
                compute(*slot, *gathering);
            });
            const Slab slab = slabs_.back();
            slabs_.pop_back();
            pipeline_.deliver(
                *slot, slab.batch->in_place ? targets::SlabPipeline::HandOn()
                                            : [this, slab, gathering](const targets::HostArrays& values) {
                                                  store_(slab, *gathering, values);
                                              });
        }
        return finish();
    }

private:
    const device::Context::Capabilities& capabilities() const { return state_.context().capabilities(); }

    void start() {
        const std::scoped_lock lock(state_.mutex);
        running_.throw_if_stopped();
        for (const Batch& batch : batches_) state_.compile(batch.job, running_);
        const bool may_gather = state_.context().capabilities().has_own_memory && requests_.size() > batches_.size();
        if (may_gather) state_.test(checks::stored_boxes_subject(state_.device, state_.programs), running_);
        state_.pool->restart_peak();
    }

    /// Computes the next slab, by the plan of an earlier call if there is one.
    void compute(targets::SlabPipeline::Slot& slot, Gathering& gathering) {
        const Slab& slab = slabs_.back();
        const engine::Job& job = slab.batch->job;
        const targets::HostArrays& arrays = slab.batch->arrays;
        const std::size_t samples = slab.grid.sample_count();
        const std::size_t first = job.grid.offset(0, 0, slab.grid.first[2] - job.grid.first[2]);
        slot.is_gathered = !gathering.is_empty();
        device::guarded([&] {
            device::Context& context = state_.context();
            device::BufferPool& pool = *state_.pool;
            if (slot.is_gathered) {
                const std::size_t wanted = gathering.samples();
                slot.memories.place(context, pool, arrays, samples);
                slot.gathered.place(context, pool, slot.own.for_samples(arrays, wanted), wanted);
            } else {
                slot.memories.place(
                    context, pool,
                    slab.batch->in_place ? targets::arrays_from(first, arrays) : slot.own.for_samples(arrays, samples),
                    samples);
            }
        });
        const auto gather = [&](engine::CommandChain& chain) {
            if (slot.is_gathered)
                gathering.enqueue(chain, state_.context(), state_.programs.store.get(), slab.grid, slot.memories,
                                  slot.gathered);
        };
        const bool in_halves = is_in_halves(slot, slab);
        slot.is_read = in_halves;
        if (!plan_ && slab.is_whole()) plan_ = state_.take_plan(job);
        if (!plan_) plan_ = plans_.make(slab, in_halves);
        const double share =
            slab.batch->cost / cost_ * static_cast<double>(samples) / static_cast<double>(job.grid.sample_count());
        clsdf::run(*plan_, slot.memories, running_, done_, done_ + share, gather, in_halves);
        done_ += share;
        if (slabs_.size() > 1) running_.report({.fraction = done_});
        add_slab(running_.statistics, plan_->statistics);
        if (slab.is_whole()) state_.keep(std::move(plan_));
        plan_.reset();
        if (slab.is_whole()) {
            plans_.release();  // it was the only slab of its batch
            state_.keep_within_budget();
        }
    }

    /// Whether the samples of a slab, which is the only one, are read as they are computed.
    bool is_in_halves(const targets::SlabPipeline::Slot& slot, const Slab& slab) const {
        return capabilities().has_own_memory && is_single_ && slab.batch->in_place && !slot.is_gathered &&
               slab.grid.sample_count() * targets::widest_of(slab.batch->arrays) >= least_bytes_in_halves;
    }

    /// Releases what the next slab had, and what is kept for later calls.
    void make_room(targets::SlabPipeline::Slot& slot) {
        const std::scoped_lock lock(state_.mutex);
        // Commands that are still running use the buffers.
        device::guarded([&] { state_.context().finish(); });
        pipeline_.discard(slot);
        plan_.reset();
        state_.forget();
    }

    /// Returns whether the next slab was divided.
    bool divide_next() {
        const Slab slab = slabs_.back();
        if (!engine::is_divisible(slab.grid)) return false;
        const auto [lower, upper] = engine::halves_of(slab.grid);
        slabs_.back().grid = upper;
        slabs_.push_back({slab.batch, lower});
        return true;
    }

    /// Waits until all slabs are stored.
    const CallStatistics& finish() {
        pipeline_.finish();
        {
            const std::scoped_lock lock(state_.mutex);
            running_.statistics.device_bytes = state_.pool->peak();
            running_.statistics.host_bytes = pipeline_.host_bytes();
        }
        return running_.finish();
    }

    KeepsBudget keeps_budget_;  // destroyed last, when the other members have released their memory
    State& state_;
    std::span<const Batch> batches_;
    std::span<const Request> requests_;
    const Store& store_;
    std::vector<Slab> slabs_;  ///< the next one is the last
    calls::RunningCall running_;
    SlabPlans plans_;
    std::unique_ptr<engine::GridPlan> plan_;  ///< of the next slab
    targets::SlabPipeline pipeline_;
    bool is_single_;   ///< there is one slab, unless it is divided
    double cost_ = 0;  ///< of all batches
    double done_ = 0;  ///< which share of it has been computed
};

CallStatistics DistanceTransform::State::compute_slabs(const engine::Job& job, const SlabSink& sink,
                                                       const SlabOptions& options, const CallOptions& call) {
    const Batch batch{.job = job, .arrays = targets::arrays_for(job.outputs)};
    const HostRun::Store hand_on = [&](const Slab& slab, const Gathering&, const targets::HostArrays& values) {
        sink(slab.grid, targets::slab_of(values, slab.grid.sample_count()));
    };
    return HostRun(*this, {&batch, 1}, {}, options.sink_has_own_thread, hand_on, call).run();
}

CallStatistics DistanceTransform::State::compute_on_host(std::span<const Request> requests, const CallOptions& call,
                                                         std::span<const Grid> wanted) {
    targets::wait_for(context(), call.wait_list);
    std::vector<engine::Job> jobs;
    const auto targets = plans::targets_of(requests, host_targets(jobs, call.count_work));
    std::vector<Batch> batches =
        plans::batches_of(std::span<const engine::Job>(jobs), std::span(targets), kept_mesh->box());
    if (!wanted.empty()) batches.front().job.wanted.assign(wanted.begin(), wanted.end());
    const HostRun::Store store = [&](const Slab& slab, const Gathering& gathered, const targets::HostArrays& values) {
        const std::vector<std::size_t>& chosen = slab.batch->requests;
        gathered.for_each_box([&](std::size_t n, const Grid& box, std::size_t start) {
            targets[chosen[n]].store(box, targets::arrays_from(start, values));
        });
        if (!gathered.is_empty()) return;
        constexpr std::size_t chunk = 8;
        for_each_chunk(chosen.size(), chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) targets[chosen[n]].store(slab.grid, values);
        });
    };
    // On a processor the next slab would take the cores that store the one before.
    return HostRun(*this, batches, requests, !context().capabilities().is_processor, store, call).run();
}

}  // namespace clsdf
