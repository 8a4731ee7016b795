#include "points/point_run.hpp"

#include "core/parallel.hpp"
#include "hilbert_curve.h"
#include "launch/short_launches.hpp"
#include "points/signs_by_host.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace clsdf::points {

namespace {

// Groups that measure points, and how many points make another one worthwhile.
constexpr std::size_t most_measuring_groups = 512, measured_together = 1024;
// Points of a launch of the search on a GPU: their lists of faces take 64 bytes a point.
constexpr std::size_t most_listed = std::size_t{1} << 19;
// First estimates for the crossings of a point on a core, and for what each corner of the open edges adds.
constexpr double seconds_per_ray = 1e-5, seconds_per_corner = 1e-7;

}  // namespace

Box box_of_curve(const engine::PointFaces& mesh) {
    Box box = mesh.box;  // enlarged: neighbours outside stay neighbours
    const double margin = box.longest_side() / 8;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] -= margin;
        box.upper[axis] += margin;
    }
    return box;
}

double search_limit(const engine::PointFaces& mesh, double half_width) {
    const double units = half_width / mesh.lattice.unit * (1 + 1e-9) + 1e-6;
    return units * units;
}

std::size_t points_in_run(const device::Context& context, std::size_t count) {
    return std::clamp<std::size_t>(count / (8 * context.capabilities().compute_units), 1, most_in_run);
}

void enqueue_outputs(const engine::Launches& launches, const engine::DeviceTools& tools, const PointInputs& inputs,
                     const engine::Finishing& finishing, const LookedUpPoints& points, bool by_sides,
                     const cl::Buffer& signs, double half_width, const engine::OutputBuffers& outputs) {
    device::LentKernel kernel = launches.kernel(tools.programs.points, "finish_points");
    const cl_uint last =
        engine::set_arguments(kernel, 0, points.in_units, points.places, points.faces,
                              inputs.sides ? *inputs.sides->sides : points.places,  // or unused
                              cl_uint{by_sides}, signs, cl_uint{0}, static_cast<cl_uint>(points.count),
                              cl_double{half_width}, **inputs.mesh->polyhedra, outputs[Output::distance]);
    finishing.set_arguments(kernel, last, outputs);
    launches.launch(kernel, {points.count});
}

void enqueue_tree_search(const engine::Launches& launches, const engine::DeviceTools& tools, const PointInputs& inputs,
                         const cl::Buffer& in_units, std::size_t begin, std::size_t end, std::size_t run, double most,
                         const cl::Buffer& faces, const cl::Buffer& squared) {
    const engine::PointFaces& mesh = *inputs.mesh;
    const engine::WideLeaves& leaves = *inputs.leaves;
    launches.launch(tools.programs.points, "nearest_of_points",
                    {chunk_count(end - begin, run), tools.programs.part_group()}, leaves.tree->shape,
                    *leaves.device_nodes, *leaves.device_leaves, **mesh.polyhedra, **mesh.faces, in_units,
                    static_cast<cl_uint>(begin), static_cast<cl_uint>(end), static_cast<cl_uint>(run), cl_double{most},
                    faces, squared);
}

PointRun::PointRun(const engine::DeviceTools& tools, std::size_t most)
    : most_(most),
      extents_(tools.pool->lease(most_measuring_groups * sizeof(PointExtent), "extents of points")),
      cells_(tools.pool->lease(sizeof(PointCells), "cells of points")),
      keys_(tools.pool->lease(most * sizeof(cl_uint), "keys of points")),
      order_(tools.pool->lease(most * sizeof(cl_uint), "order of points")),
      sort_(*tools.pool, most),
      in_units_(tools.pool->lease(most * sizeof(Vec3), "points")),
      faces_(tools.pool->lease(most * sizeof(cl_uint), "nearest faces of points")),
      squared_(tools.pool->lease(most * sizeof(double), "squared distances of points")),
      signs_(tools.pool->lease(most, "signs of points")),
      open_(tools.pool->lease(most * sizeof(cl_uint), "points without a sign")),
      left_(tools.pool->lease(most * sizeof(cl_uint), "points without a sign")) {
    if (tools.programs.body != KernelBody::by_group) return;
    const std::size_t together = std::min(most, most_listed);
    listed_ = tools.pool->lease(together * CLSDF_LISTED_FACES * sizeof(cl_uint), "faces near points");
    listed_counts_ = tools.pool->lease(together * sizeof(cl_uint), "faces near points");
}

std::size_t PointRun::device_bytes() const {
    std::size_t bytes = sort_.device_bytes();
    for (const device::BufferPool::Lease* lease : {&extents_, &cells_, &keys_, &order_, &in_units_, &faces_, &squared_,
                                                   &signs_, &open_, &left_, &listed_, &listed_counts_})
        bytes += lease->bytes();
    return bytes;
}

void PointRun::enqueue_measure(const engine::Launches& launches, const engine::DeviceTools& tools,
                               const DevicePoints& all, const PointLimits& usable, const engine::PointFaces& mesh) {
    const std::size_t groups = std::clamp<std::size_t>(all.count / measured_together, 1, most_measuring_groups);
    const cl::Program program = tools.programs.point_order;
    launches.launch(program, "measure_points", {groups * engine::common_group}, all.source,
                    static_cast<cl_uint>(all.count), usable, all.memory, *extents_);
    launches.launch(program, "join_extents", {engine::common_group}, static_cast<cl_uint>(groups),
                    limits_of(box_of_curve(mesh)), *extents_, *cells_);
}

void PointRun::enqueue(const engine::Launches& launches, const engine::DeviceTools& tools, const PointInputs& inputs,
                       const PointBatch& batch, const std::function<void(double)>& between) {
    const engine::Finishing finishing(inputs.mesh->lattice, inputs.sites, inputs.is_inside_out);
    const LookedUpPoints points{batch.points.count, *in_units_, *order_, *faces_};
    const auto enqueue_outputs = [&](bool by_sides) {
        points::enqueue_outputs(launches, tools, inputs, finishing, points, by_sides, *signs_, batch.half_width,
                                batch.outputs);
    };
    enqueue_order(launches, tools, *inputs.mesh, batch);
    enqueue_search(launches, tools, inputs, batch, between);
    if (inputs.sides) enqueue_outputs(true);
    enqueue_signs(launches, tools, inputs, batch);
    enqueue_outputs(false);
    enqueue_marks(launches, tools, inputs, finishing, batch);
}

void PointRun::enqueue_order(const engine::Launches& launches, const engine::DeviceTools& tools,
                             const engine::PointFaces& mesh, const PointBatch& batch) {
    const DevicePoints& points = batch.points;
    const auto count = static_cast<cl_uint>(points.count);
    const cl::Program program = tools.programs.point_order;
    launches.launch(program, "keys_of_points", {points.count}, points.source, count, batch.usable, points.memory,
                    *cells_, *keys_);
    engine::sort_by_keys(launches, tools.programs, sort_, *keys_, points.count, 3 * CLSDF_CURVE_BITS, *order_);
    PointUnits units{{}, mesh.lattice.unit};
    std::copy(mesh.lattice.origin.begin(), mesh.lattice.origin.end(), units.origin);
    launches.launch(program, "gather_points", {points.count}, points.source, count, batch.usable, units, points.memory,
                    *order_, *in_units_);
}

void PointRun::enqueue_search(const engine::Launches& launches, const engine::DeviceTools& tools,
                              const PointInputs& inputs, const PointBatch& batch,
                              const std::function<void(double)>& between) {
    const engine::PointFaces& mesh = *inputs.mesh;
    const cl_double most = search_limit(mesh, batch.half_width);
    const std::size_t count = batch.points.count;
    std::size_t begun = 0;
    const engine::ShortLaunches short_launches(
        tools.context,
        between ? [&] { between(static_cast<double>(begun) / static_cast<double>(count)); } : std::function<void()>());
    const auto search_by_group = [&](cl_uint begin, cl_uint end) {
        const engine::FittedTree& tree = *inputs.tree;
        const engine::DividedFaces& divided = *tree.divided;
        const cl::Program program = inputs.needs_deep_stack() ? tools.programs.nearest_deep : tools.programs.nearest;
        const engine::WorkItems points{end - begin};
        launches.launch(program, "list_faces", points, divided.tree, *tree.nodes, *tree.faces, *in_units_, begin, end,
                        most, *listed_, *listed_counts_);
        launches.launch(program, "decide_faces", points, *divided.order, **mesh.polyhedra, **mesh.faces, *in_units_,
                        begin, end, most, *listed_, *listed_counts_, *faces_, *squared_);
        launches.launch(program, "search_again", points, divided.tree, *tree.nodes, *tree.faces, *divided.order,
                        **mesh.polyhedra, **mesh.faces, *in_units_, begin, end, *listed_counts_, *faces_, *squared_);
    };
    const std::size_t fitting = short_launches.most(seconds_per_search);
    const std::size_t together = inputs.tree ? std::min(fitting, most_listed) : fitting;
    short_launches.one_by_one(chunk_count(count, together), [&](std::size_t) {
        const std::size_t end = std::min(begun + together, count);
        if (inputs.tree)
            search_by_group(static_cast<cl_uint>(begun), static_cast<cl_uint>(end));
        else
            enqueue_tree_search(launches, tools, inputs, *in_units_, begun, end, points_in_run(tools.context, count),
                                most, *faces_, *squared_);
        begun = end;
    });
}

void PointRun::enqueue_signs(const engine::Launches& launches, const engine::DeviceTools& tools,
                             const PointInputs& inputs, const PointBatch& batch) {
    const engine::PointFaces& mesh = *inputs.mesh;
    const DevicePoints& points = batch.points;
    // If there is a film, a point anywhere may be inside.
    const PointLimits limits = mesh.film ? batch.usable : limits_of(mesh.sign_box());
    const bool is_decided = inputs.has_exact_signs();
    launches.launch(tools.programs.point_order, "find_open_points", {points.count}, points.source,
                    static_cast<cl_uint>(points.count), limits, cl_uint{inputs.sign == SignRule::none},
                    cl_uint{inputs.sides != nullptr}, cl_uint{!is_decided}, points.memory, *order_, *squared_, *signs_,
                    *cells_, is_decided ? *open_ : *left_);
    if (!is_decided) return;
    const DeviceSignFaces& surface = *inputs.sign_faces;
    const auto given = [&](const device::BufferPool::Lease& lease) {
        return lease.bytes() > 0 ? *lease : *surface.positions;  // unused
    };
    const engine::ShortLaunches short_launches(tools.context, {});
    const double seconds = seconds_per_ray + seconds_per_corner * static_cast<double>(surface.corner_count);
    short_launches.over(points.count, seconds, [&](std::size_t begin, std::size_t end) {
        const auto decide = [&](const auto& tree, const cl::Buffer& nodes, const cl::Buffer& order) {
            launches.launch(tools.programs.point_signs, "decide_open_points", {end - begin}, points.source,
                            points.memory, static_cast<cl_uint>(begin), static_cast<cl_uint>(end), tree, nodes, order,
                            surface.faces, **inputs.triangles, *surface.positions, given(surface.sign_positions),
                            given(surface.counts), given(surface.corners), given(surface.begins), *in_units_, *order_,
                            *squared_, *open_, *cells_, *signs_, *left_);
        };
        if (inputs.tree) {
            const engine::DividedFaces& divided = *inputs.tree->divided;
            decide(divided.tree, *inputs.tree->nodes, *divided.order);
        } else {
            const cl::Buffer& nodes = *inputs.leaves->device_nodes;
            decide(inputs.leaves->tree->shape, nodes, nodes);  // without an order
        }
    });
}

void PointRun::enqueue_marks(const engine::Launches& launches, const engine::DeviceTools& tools,
                             const PointInputs& inputs, const engine::Finishing& finishing, const PointBatch& batch) {
    device::LentKernel kernel = launches.kernel(tools.programs.point_order, "mark_points");
    const engine::OutputBuffers& outputs = batch.outputs;
    const bool has_status = batch.status.has_value();
    const cl_uint last = engine::set_arguments(
        kernel, 0, batch.points.source, static_cast<cl_uint>(batch.points.count), batch.usable,
        cl_uint{std::isfinite(batch.half_width)}, cl_double{batch.half_width}, cl_uint{batch.leaves_open},
        cl_uint{has_status}, has_status ? batch.status->places : ValuePlaces{}, batch.points.memory, *order_, *signs_,
        has_status ? batch.status->memory : *signs_, **inputs.mesh->polyhedra, outputs[Output::distance]);
    finishing.set_arguments(kernel, last, outputs);
    launches.launch(kernel, {batch.points.count});
}

}  // namespace clsdf::points
