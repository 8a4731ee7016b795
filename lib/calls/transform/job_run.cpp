#include "core/parallel.hpp"
#include "core/stopwatch.hpp"
#include "plan/slabs.hpp"
#include "prepare/layout_of.hpp"
#include "transform/transform_state.hpp"

#include <algorithm>

namespace clsdf {

namespace {

using transform::Job;

/// Computes a plan's samples, which are [begin, end) of the call's work, and returns when they are there.
void run(transform::GridPlan& plan, const scan::OutputMemories& memories, transform::Caller& caller, double begin,
         double end) {
    const Stopwatch watch;
    const device::Context& context = device::context_of(plan.device);
    device::guarded([&] {
        try {
            caller.throw_if_stopped();
            scan::CommandChain chain(context.queue(), {});
            plan.enqueue(chain, memories.buffers, caller.between(begin, end));
            memories.enqueue_handover(context.queue());
            context.queue().finish();
            plan.read_back(context.queue());
        } catch (...) {
            // Commands that are still running write to the caller's memory.
            context.drain();
            throw;
        }
    });
    plan.statistics.field_seconds = watch.seconds();
}

/// in_place: the samples are computed in the arrays.
std::vector<Grid> slabs_for(const Job& job, const device::Context& context, const scan::HostArrays& arrays,
                            bool in_place) {
    const device::Context::Capabilities& capabilities = context.capabilities();
    return scan::slabs_of(job.grid, in_place ? scan::limits_of(capabilities) : scan::stream_limits_of(capabilities),
                          scan::widest_of(arrays));
}

}  // namespace

/// Computes a job slab by slab, into the arrays or, if not in place, to the pipeline's sink. If memory is short, a slab
/// is divided; one that cannot be divided is tried once more when what is kept for later calls has been released.
class DistanceTransform::State::JobRun {
public:
    /// All arguments that are references must outlive this.
    JobRun(State& state, const Job& job, scan::SlabPipeline& pipeline, const CallOptions& call)
        : keeps_budget_{state}, state_(state), job_(job), pipeline_(pipeline), caller_{call}, compiling_(caller_) {}

    CallStatistics run(std::vector<Grid> slabs, const scan::HostArrays& arrays, bool in_place) {
        prepare(slabs.size() == 1);
        std::reverse(slabs.begin(), slabs.end());
        while (!slabs.empty()) {
            scan::SlabPipeline::Slot* slot = &pipeline_.next();
            const auto divide = [&] {
                make_room(*slot);
                slot = &pipeline_.next();
                if (!scan::is_divisible(slabs.back())) return false;
                const auto [lower, upper] = scan::halves_of(slabs.back());
                slabs.back() = upper;
                slabs.push_back(lower);
                return true;
            };
            // The length of a slab's lists is known only when they are made.
            transform::with_remedies(&caller_, {{divide, true}, {[] { return true; }}}, [&] {
                const std::scoped_lock lock(state_.mutex);
                if (!inputs_.records && !plan_) make_inputs();
                pipeline_.place(*slot, slabs.back(),
                                in_place ? scan::arrays_from(done_, arrays)
                                         : slot->own.for_samples(arrays, slabs.back().sample_count()));
                compute(slabs.back(), slot->memories);
            });
            pipeline_.deliver(*slot, slabs.back());
            done_ += slabs.back().sample_count();
            slabs.pop_back();
        }
        finish();
        return statistics_;
    }

private:
    /// Compiles, and takes a plan of an earlier call or makes the inputs of new ones.
    void prepare(bool is_whole) {
        const std::scoped_lock lock(state_.mutex);
        caller_.throw_if_stopped();
        state_.compile(job_, compiling_);
        state_.pool->restart_peak();
        if (is_whole) plan_ = state_.take_plan(job_);
        if (!plan_) make_inputs();
    }

    void make_inputs() {
        const Stopwatch watch;
        inputs_ = state_.inputs(job_);
        statistics_.polyhedra_seconds = watch.seconds();
        caller_.throw_if_stopped();
    }

    void compute(const Grid& slab, const scan::OutputMemories& memories) {
        const std::size_t all = job_.grid.sample_count(), end = done_ + slab.sample_count();
        const bool is_part = slab.sample_count() < all;
        if (!plan_) {
            // A part of the grid needs a part of what the grid needs.
            transform::Inputs inputs = inputs_;
            if (is_part) state_.stages->select(slab, scan::layout_of(slab, job_.band, state_.sign), inputs);
            plan_ = state_.make_plan(state_, std::move(inputs), job_.part(slab), caller_);
        }
        const auto share = [&](std::size_t samples) { return static_cast<double>(samples) / static_cast<double>(all); };
        clsdf::run(*plan_, memories, caller_, share(done_), share(end));
        add_slab(statistics_, plan_->statistics);
        if (is_part) plan_.reset();
    }

    /// Releases what the slab had, and what is kept for later calls.
    void make_room(scan::SlabPipeline::Slot& slot) {
        const std::scoped_lock lock(state_.mutex);
        // Commands that are still running use the buffers.
        device::guarded([&] { state_.context().queue().finish(); });
        pipeline_.take_back(slot);
        plan_.reset();
        state_.forget();
    }

    /// Waits for the sink, and keeps the plan of the whole grid for the next call.
    void finish() {
        pipeline_.finish();
        {
            const std::scoped_lock lock(state_.mutex);
            compiling_.describe(statistics_);
            statistics_.device_bytes = state_.pool->peak();
            statistics_.host_bytes = pipeline_.host_bytes();
            inputs_ = {};
            if (plan_) state_.keep(std::move(plan_));
        }
        caller_.report({.fraction = 1});
    }

    KeepsBudget keeps_budget_;  // destroyed last, when the other members have released their memory
    State& state_;
    const Job& job_;
    scan::SlabPipeline& pipeline_;
    transform::Caller caller_;
    transform::Compiling compiling_;
    transform::Inputs inputs_;  ///< of the whole grid
    std::unique_ptr<transform::GridPlan> plan_;
    CallStatistics statistics_;
    std::size_t done_ = 0;  ///< samples
};

std::optional<CallStatistics> DistanceTransform::State::run_kept(const Job& job, const scan::HostArrays& arrays,
                                                                 const CallOptions& call) {
    transform::Caller caller{call};
    CallStatistics statistics;
    {
        const std::scoped_lock lock(mutex);
        std::unique_ptr<transform::GridPlan> plan = take_plan(job);
        if (!plan) return std::nullopt;
        context().require_usable();
        pool->restart_peak();
        scan::OutputMemories memories;
        try {
            device::guarded([&] { memories.place(context(), *pool, arrays, job.grid.sample_count()); });
        } catch (const Error& error) {
            if (!caller.is_short_of_memory(error)) throw;
            keep(std::move(plan));
            return std::nullopt;
        }
        clsdf::run(*plan, memories, caller, 0, 1);
        device::guarded([&] { memories.read(context(), context().queue()); });
        statistics = plan->statistics;
        statistics.slabs = 1;
        statistics.device_bytes = pool->peak();
        keep(std::move(plan));
    }
    caller.report({.fraction = 1});
    return statistics;
}

CallStatistics DistanceTransform::State::compute_slabs(const Job& job, const SlabSink& sink, const SlabOptions& options,
                                                       const CallOptions& call) {
    const auto hand_on = [&](const Grid& part, const scan::HostArrays& values) {
        sink(part, scan::slab_of(values, part.sample_count()));
    };
    scan::SlabPipeline pipeline(context(), pool, hand_on, options.sink_has_own_thread);
    const scan::HostArrays arrays = scan::arrays_for(job.outputs);
    return JobRun(*this, job, pipeline, call).run(slabs_for(job, context(), arrays, false), arrays, false);
}

CallStatistics DistanceTransform::State::compute_one(const Request& request, const scan::HostTargets& targets,
                                                     const CallOptions& call) {
    const Job job{request.grid, request.band, scan::outputs_of(targets.arrays), {}, call.count_work};
    const bool in_place = targets.are_packed;
    if (in_place)
        if (const auto kept = run_kept(job, targets.arrays, call)) return *kept;
    check(job);
    std::vector<Grid> slabs = slabs_for(job, context(), targets.arrays, in_place);
    scan::ArraySink store;
    if (!in_place) store = [&](const Grid& part, const scan::HostArrays& values) { targets.store(part, values); };
    scan::SlabPipeline pipeline(context(), pool, store, slabs.size() > 1);
    return JobRun(*this, job, pipeline, call).run(std::move(slabs), targets.arrays, in_place);
}

CallStatistics DistanceTransform::State::compute_many(std::span<const Request> requests, const CallOptions& call) {
    const auto targets = transform::targets_of(requests, [&](const Request& request) { return host_targets(request); });
    std::vector<scan::HostArrays> arrays;
    for (const scan::HostTargets& target : targets) arrays.push_back(target.arrays);
    const std::vector<transform::Batch> batches =
        transform::batches_of(requests, arrays, stages->mesh().box(), call.count_work);
    double cost = 0, done = 0;
    for (const transform::Batch& batch : batches) cost += batch.cost;
    const transform::Batch* computed = nullptr;
    const auto store = [&](const Grid& part, const scan::HostArrays& values) {
        constexpr std::size_t chunk = 8;
        for_each_chunk(computed->requests.size(), chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) targets[computed->requests[n]].store(part, values);
        });
    };
    // On a processor the next slab would take the cores that store the one before.
    scan::SlabPipeline pipeline(context(), pool, store, !context().capabilities().is_processor);
    CallStatistics total;
    for (const transform::Batch& batch : batches) {
        computed = &batch;
        const CallOptions batch_call = transform::part_of(call, done / cost, (done + batch.cost) / cost);
        const std::size_t first = batch.requests.front();
        if (batch.requests.size() == 1)
            add_call(total, compute_one(requests[first], targets[first], batch_call));
        else
            add_call(total, JobRun(*this, batch.job, pipeline, batch_call)
                                .run(slabs_for(batch.job, context(), arrays[first], false), arrays[first], false));
        done += batch.cost;
    }
    return total;
}

}  // namespace clsdf
