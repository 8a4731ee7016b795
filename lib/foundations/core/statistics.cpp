#include "core/statistics.hpp"

#include <algorithm>

namespace clsdf {

MethodCount& count_named(std::vector<MethodCount>& counts, const std::string& name) {
    const auto found = std::ranges::find(counts, name, &MethodCount::name);
    return found != counts.end() ? *found : counts.emplace_back(MethodCount{name});
}

void add_slab(CallStatistics& total, const CallStatistics& slab) {
    total.triangles = slab.triangles;
    total.polyhedra = slab.polyhedra;
    total.box_polyhedra = slab.box_polyhedra;
    total.saddle_vertices = slab.saddle_vertices;
    total.point_sites = slab.point_sites;
    total.coarse_pairs += slab.coarse_pairs;
    total.coarse_bricks += slab.coarse_bricks;
    ++total.slabs;
    for (const auto count : device_counts) total.*count += slab.*count;
    total.lists_seconds += slab.lists_seconds;
    total.sign_seconds += slab.sign_seconds;
    total.field_seconds += slab.field_seconds;
    total.bricks_seconds += slab.bricks_seconds;
    total.fill_seconds += slab.fill_seconds;
    for (const MethodCount& count : slab.method_counts) {
        MethodCount& sum = count_named(total.method_counts, count.name);
        sum.value = count.of_mesh ? count.value : sum.value + count.value;
        sum.of_mesh = count.of_mesh;
    }
}

void add_call(CallStatistics& total, const CallStatistics& call) {
    const std::size_t slabs = total.slabs + call.slabs;
    add_slab(total, call);
    total.slabs = slabs;
    total.polyhedra_seconds += call.polyhedra_seconds;
    total.compile_seconds += call.compile_seconds;
    total.first_use |= call.first_use;
    total.device_bytes = std::max(total.device_bytes, call.device_bytes);
    total.host_bytes = std::max(total.host_bytes, call.host_bytes);
}

}  // namespace clsdf
