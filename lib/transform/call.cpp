#include "transform/call.hpp"

#include "scan/programs.hpp"

#include <algorithm>

namespace clsdf::transform {

template <typename Function, typename... Arguments>
auto Caller::pass_on(const Function& function, const Arguments&... arguments) {
    try {
        return function(arguments...);
    } catch (...) {
        has_thrown_ = true;
        throw;
    }
}

void Caller::throw_if_stopped() {
    if (options_.should_stop && pass_on(options_.should_stop))
        throw Error(ErrorCode::cancelled, "the computation was cancelled");
}

void Caller::progress(double fraction) {
    if (options_.progress) pass_on(options_.progress, fraction);
}

void Caller::compiling(const Compilation& compilation) {
    if (options_.compiling) pass_on(options_.compiling, compilation);
}

void CallMutex::check_thread() const {
    if (owner_.load() == std::this_thread::get_id())
        throw Error(ErrorCode::invalid_argument,
                    "a function of a call's options used the transform that makes the call; use it when the call has "
                    "returned");
}

void CallMutex::lock() {
    check_thread();
    mutex_.lock();
    owner_ = std::this_thread::get_id();
}

void CallMutex::unlock() {
    owner_ = std::thread::id();
    mutex_.unlock();
}

void add_slab(TransformStatistics& total, const TransformStatistics& slab) {
    total.triangles = slab.triangles;
    total.polyhedra = slab.polyhedra;
    total.box_polyhedra = slab.box_polyhedra;
    total.saddle_vertices = slab.saddle_vertices;
    total.point_sites = slab.point_sites;
    total.coarse_pairs += slab.coarse_pairs;
    total.coarse_bricks += slab.coarse_bricks;
    ++total.slabs;
    total.brick_pairs += slab.brick_pairs;
    total.lanes_evaluated += slab.lanes_evaluated;
    total.samples_covered += slab.samples_covered;
    total.band_samples += slab.band_samples;
    total.lists_seconds += slab.lists_seconds;
    total.sign_seconds += slab.sign_seconds;
    total.field_seconds += slab.field_seconds;
    total.bricks_seconds += slab.bricks_seconds;
    total.fill_seconds += slab.fill_seconds;
    for (const auto& [name, count] : slab.method_counts) {
        MethodCount& sum = total.method_counts[name];
        sum = {count.of_mesh ? count.value : sum.value + count.value, count.of_mesh};
    }
}

void add_call(TransformStatistics& total, const TransformStatistics& call) {
    const std::size_t slabs = total.slabs + call.slabs;
    add_slab(total, call);
    total.slabs = slabs;
    total.polyhedra_seconds += call.polyhedra_seconds;
    total.compile_seconds += call.compile_seconds;
    total.first_use |= call.first_use;
    total.device_bytes = std::max(total.device_bytes, call.device_bytes);
    total.host_bytes = std::max(total.host_bytes, call.host_bytes);
}

device::BuildWatch Compiling::watch(std::size_t variant_steps) {
    const std::size_t most = scan::Programs::common_programs + variant_steps;
    const auto step = [this, most](bool is_waiting) {
        caller_.throw_if_stopped();
        caller_.compiling({std::max<std::size_t>(step_, 1), std::max(most, step_), is_waiting});
    };
    return {[this, step] {
                ++step_;
                step(false);
            },
            [step] { step(true); }, log_};
}

}  // namespace clsdf::transform
