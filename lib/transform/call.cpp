#include "transform/call.hpp"

#include <clsdf/error.hpp>

#include "scan/programs.hpp"

#include <algorithm>

namespace clsdf::transform {

void throw_if_stopped(const CallOptions& call) {
    if (call.should_stop && call.should_stop()) throw Error(ErrorCode::cancelled, "the computation was cancelled");
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
        throw_if_stopped(call_);
        const std::size_t steps = std::max(most, step_);
        if (call_.compiling) call_.compiling({std::max<std::size_t>(step_, 1), steps, is_waiting});
    };
    return {[this, step] {
                ++step_;
                step(false);
            },
            [step] { step(true); }, log_};
}

}  // namespace clsdf::transform
