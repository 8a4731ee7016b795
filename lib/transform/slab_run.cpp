#include "core/parallel.hpp"
#include "core/stopwatch.hpp"
#include "scan/layout_of.hpp"
#include "scan/slabs.hpp"
#include "transform/transform_state.hpp"

#include <algorithm>

namespace clsdf {

/// Computes a grid slab by slab. If the device has too little memory for a slab, the slab is halved. A slab that cannot
/// be halved is tried once more, after the data kept for later calls are released.
class DistanceTransform::State::SlabRun {
public:
    /// All arguments that are references must outlive this.
    SlabRun(State& state, const Grid& grid, const Band& band, OutputSet outputs, std::span<const Grid> wanted,
            scan::SlabPipeline& pipeline, const CallOptions& call)
        : keeps_budget_{state},
          state_(state),
          grid_(grid),
          band_(band),
          outputs_(outputs),
          wanted_(wanted),
          pipeline_(pipeline),
          caller_(call),
          compiling_(caller_) {}

    /// Into the arrays or, if not in place, to the sink.
    CallStatistics run(std::vector<Grid> slabs, const scan::HostArrays& arrays, bool in_place) {
        prepare(slabs.size() == 1);
        std::reverse(slabs.begin(), slabs.end());
        while (!slabs.empty()) {
            const Grid slab = slabs.back();
            slabs.pop_back();
            scan::SlabPipeline::Slot& slot = pipeline_.next();
            try {
                const std::scoped_lock lock(state_.mutex);
                if (in_place)
                    pipeline_.place(slot, slab, arrays_from(done_, arrays));
                else
                    pipeline_.place_own(slot, slab, arrays);
                compute(slab, slot);
            } catch (const Error& error) {
                // The length of a slab's lists is known only when they are made.
                const bool is_divisible = scan::is_divisible(slab);
                if (!caller_.is_short_of_memory(error) || (!is_divisible && has_room_)) throw;
                if (is_divisible) {
                    const auto [lower, upper] = scan::halves_of(slab);
                    slabs.insert(slabs.end(), {upper, lower});
                } else {
                    has_room_ = true;
                    slabs.push_back(slab);
                }
                make_room(slot);
                continue;
            }
            pipeline_.deliver(slot, slab);
            done_ += slab.sample_count();
            has_room_ = false;
        }
        finish();
        return statistics_;
    }

private:
    /// Compiles, and takes a plan of an earlier call or makes the inputs of new ones.
    void prepare(bool is_whole) {
        const std::scoped_lock lock(state_.mutex);
        caller_.throw_if_stopped();
        state_.compile(grid_, band_, outputs_, caller_.options().count_work, compiling_);
        state_.pool->restart_peak();
        if (is_whole) plan_ = state_.take_plan(grid_, band_, outputs_, wanted_, caller_.options().count_work);
        if (!plan_) make_inputs();
    }

    void make_inputs() {
        const Stopwatch watch;
        inputs_ = state_.inputs(grid_, band_, outputs_);
        statistics_.polyhedra_seconds = watch.seconds();
        caller_.throw_if_stopped();
    }

    /// The caller's arrays from a sample on.
    static scan::HostArrays arrays_from(std::size_t sample, const scan::HostArrays& arrays) {
        scan::HostArrays part;
        for_each_output(
            [&](const OutputInfo& row, const auto& array, auto& of_part) { of_part = array.from_sample(row, sample); },
            arrays, part);
        return part;
    }

    void compute(const Grid& slab, const scan::SlabPipeline::Slot& slot) {
        const bool is_part = slab.sample_count() < grid_.sample_count();
        if (!plan_) {
            // A part of the grid needs a part of what the grid needs.
            transform::Inputs inputs = inputs_;
            if (is_part) state_.stages->select(slab, scan::layout_of(slab, band_, state_.sign), inputs);
            plan_ = state_.make_plan(std::move(inputs), slab, band_, outputs_, wanted_, caller_.options().count_work,
                                     caller_, compiling_);
        }
        const auto share = [&](std::size_t samples) {
            return static_cast<double>(samples) / static_cast<double>(grid_.sample_count());
        };
        run_plan(slot, share(done_), share(done_ + slab.sample_count()));
        add_slab(statistics_, plan_->statistics);
        if (is_part) plan_.reset();
    }

    /// The samples of one slab. Its progress runs from `begin` to `end`.
    void run_plan(const scan::SlabPipeline::Slot& slot, double begin, double end) {
        const Stopwatch watch;
        const device::Context& context = device::context_of(state_.device);
        std::function<void(double)> between;
        if (caller_.is_watching())
            between = [&](double fraction) {
                caller_.throw_if_stopped();
                caller_.progress(begin + (end - begin) * fraction);
            };
        device::guarded([&] {
            try {
                caller_.throw_if_stopped();
                scan::CommandChain chain(context.queue(), {});
                plan_->enqueue(chain, slot.buffers(), between);
                slot.enqueue_handover(context.queue());
                context.queue().finish();
                plan_->read_counters();
                plan_->read_times(context.queue());
            } catch (...) {
                // Commands that are still running write to the caller's memory.
                context.drain();
                throw;
            }
        });
        plan_->statistics.field_seconds = watch.seconds();
    }

    /// Releases what the slab had, and what is kept for later calls.
    void make_room(scan::SlabPipeline::Slot& slot) {
        const std::scoped_lock lock(state_.mutex);
        // Commands that are still running use the buffers.
        device::guarded([&] { device::context_of(state_.device).queue().finish(); });
        pipeline_.take_back(slot);
        plan_.reset();
        state_.forget();
        if (!inputs_.records) make_inputs();
    }

    /// Waits for the sink, and keeps the plan of the whole grid for the next call.
    void finish() {
        pipeline_.finish();
        {
            const std::scoped_lock lock(state_.mutex);
            statistics_.compile_seconds = compiling_.seconds;
            statistics_.first_use = compiling_.first_use;
            statistics_.device_bytes = state_.pool->peak();
            statistics_.host_bytes = pipeline_.host_bytes();
            inputs_ = {};
            if (plan_) state_.keep(std::move(plan_), caller_.options().count_work);
        }
        caller_.progress(1.0);
    }

    KeepsBudget keeps_budget_;  // destroyed last, when the other members have released their memory
    State& state_;
    const Grid& grid_;
    const Band& band_;
    OutputSet outputs_;
    std::span<const Grid> wanted_;
    scan::SlabPipeline& pipeline_;
    transform::Caller caller_;
    transform::Compiling compiling_;
    transform::Inputs inputs_;  ///< of the whole grid
    std::unique_ptr<transform::GridPlan> plan_;
    CallStatistics statistics_;
    std::size_t done_ = 0;   ///< samples
    bool has_room_ = false;  ///< the present slab cannot be divided, and is tried again
};

CallStatistics DistanceTransform::State::compute_slabs(const Grid& grid, const Band& band, OutputSet outputs,
                                                       const scan::HostArrays& arrays, bool in_place,
                                                       std::vector<Grid> slabs, std::span<const Grid> wanted,
                                                       scan::SlabPipeline& pipeline, const CallOptions& call) {
    return SlabRun(*this, grid, band, outputs, wanted, pipeline, call).run(std::move(slabs), arrays, in_place);
}

CallStatistics DistanceTransform::State::compute_grid(const Grid& grid, const Band& band, OutputSet outputs,
                                                      const scan::HostTargets& targets, const CallOptions& call) {
    const device::Context& context = device::context_of(device);
    check(grid, band, outputs);
    const bool in_place = targets.are_packed();
    const auto store = [&](const Grid& part, const scan::HostArrays& values) { targets.store(part, values); };
    const scan::SlabLimits limits =
        in_place ? scan::limits_of(context.capabilities()) : scan::stream_limits_of(context.capabilities());
    std::vector<Grid> slabs = scan::slabs_of(grid, limits, scan::widest_of(targets.arrays()));
    scan::SlabPipeline pipeline(context, pool, in_place ? scan::ArraySink() : scan::ArraySink(store), slabs.size() > 1);
    return compute_slabs(grid, band, outputs, targets.arrays(), in_place, std::move(slabs), {}, pipeline, call);
}

CallStatistics DistanceTransform::State::compute_batch(const transform::Batch& batch, std::span<const Request> requests,
                                                       std::span<const scan::HostTargets> targets,
                                                       scan::SlabPipeline& pipeline, const CallOptions& call) {
    const std::size_t first = batch.requests.front();
    const Request& request = requests[first];
    const OutputSet outputs = scan::outputs_of(request.targets);
    if (batch.requests.size() == 1) return compute_grid(request.grid, request.band, outputs, targets[first], call);
    const device::Context& context = device::context_of(device);
    std::vector<Grid> wanted;
    for (const std::size_t n : batch.requests) wanted.push_back(requests[n].grid);
    const scan::HostArrays& arrays = targets[first].arrays();
    return compute_slabs(
        batch.block, request.band, outputs, arrays, false,
        scan::slabs_of(batch.block, scan::stream_limits_of(context.capabilities()), scan::widest_of(arrays)), wanted,
        pipeline, call);
}

CallStatistics DistanceTransform::State::compute_requests(std::span<const Request> requests, const CallOptions& call) {
    const std::vector<scan::HostTargets> targets = transform::targets_of(requests, [&](const Request& request) {
        check(request.grid, request.band, scan::outputs_of(request.targets));
    });
    std::vector<scan::HostArrays> arrays;
    for (const scan::HostTargets& target : targets) arrays.push_back(target.arrays());
    const std::vector<transform::Batch> batches = transform::batches_of(requests, arrays, mesh().box());
    double cost = 0, done = 0;
    for (const transform::Batch& batch : batches) cost += batch.cost;
    const device::Context& context = device::context_of(device);
    const transform::Batch* computed = nullptr;
    const auto store = [&](const Grid& part, const scan::HostArrays& values) {
        constexpr std::size_t chunk = 8;
        for_each_chunk(computed->requests.size(), chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) targets[computed->requests[n]].store(part, values);
        });
    };
    // On a processor the next slab would take the cores that store the one before.
    scan::SlabPipeline pipeline(context, pool, store, !context.capabilities().is_processor);
    CallStatistics total;
    for (const transform::Batch& batch : batches) {
        computed = &batch;
        CallOptions batch_call = call;
        if (call.progress)
            batch_call.progress = [&](Progress progress) {
                if (progress.stage == Progress::Stage::computing)
                    progress.fraction = (done + batch.cost * progress.fraction) / cost;
                call.progress(progress);
            };
        add_call(total, compute_batch(batch, requests, targets, pipeline, batch_call));
        done += batch.cost;
    }
    return total;
}

}  // namespace clsdf
