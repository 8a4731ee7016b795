#include "points/point_query.hpp"

#include "core/large_memory.hpp"
#include "core/parallel.hpp"
#include "core/stopwatch.hpp"
#include "device/buffer_pool.hpp"
#include "launch/commands.hpp"
#include "launch/prefix_sums.hpp"
#include "launch/short_launches.hpp"
#include "points/curve_order.hpp"
#include "points/point_signs.hpp"
#include "tree/point_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

namespace clsdf::points {

namespace {

// Fewer points are taken as they come.
constexpr std::size_t fewest_sorted = 128;
// Points of a work-item on a processor, which share their way through the tree.
constexpr std::size_t most_run = 64;
// Points of a launch on a GPU: their lists of faces take 64 bytes a point.
constexpr std::size_t most_listed = std::size_t{1} << 19;
// First estimate for a search on a core; later launches use the measured time.
constexpr double seconds_per_search = 2e-5;

/// A buffer for a value of each point.
template <typename Value>
class PointBuffer {
public:
    PointBuffer(device::BufferPool& pool, std::size_t count, const char* purpose)
        : lease_(pool.lease(count * sizeof(Value), purpose)) {}

    const cl::Buffer& operator*() const { return *lease_; }
    void write(const cl::CommandQueue& queue, std::span<const Value> values) {
        queue.enqueueWriteBuffer(*lease_, CL_TRUE, 0, values.size_bytes(), values.data());
    }
    void read(const cl::CommandQueue& queue, std::span<Value> values) {
        queue.enqueueReadBuffer(*lease_, CL_TRUE, 0, values.size_bytes(), values.data());
    }

private:
    device::BufferPool::Lease lease_;
};

/// Points on the device, in the order of a curve, and their nearest faces.
class Query {
public:
    /// groups: of the points if they are scanned; null: they are looked up one by one.
    Query(const engine::DeviceTools& tools, const PointInputs& inputs, OrderedPoints points, std::size_t count,
          double half_width, std::unique_ptr<const PointGroups> groups = nullptr)
        : tools_(tools),
          queue_(tools.queue()),
          program_(tools.programs.points),
          inputs_(inputs),
          finishing_(inputs.mesh->lattice, inputs.sites, inputs.is_inside_out),
          half_width_(half_width),
          count_(count),
          groups_(std::move(groups)),
          points_(std::move(points)),
          faces_(*tools_.pool, count, "nearest faces of points"),
          squared_(*tools_.pool, count, "squared distances of points") {}

    void find_nearest(const std::function<void(double)>& between) {
        if (groups_)
            scan_points({tools_, *inputs_.mesh, *inputs_.scanned, *groups_, count_, *points_.in_units, most()}, *faces_,
                        *squared_, between);
        else if (inputs_.tree)
            search_by_group(between);
        else
            search_tree(between);
    }

    const OrderedPoints& points() const { return points_; }
    PointBuffer<std::uint32_t>& faces() { return faces_; }
    PointBuffer<double>& squared() { return squared_; }

    /// Enqueues the outputs of the points that have a sign. by_sides: that of the side of their nearest face.
    void finish(bool by_sides, const cl::Buffer& signs, const engine::OutputBuffers& outputs) {
        finish(count_, points_, faces_, by_sides, signs, outputs);
    }
    /// The same of other points.
    void finish(std::size_t count, const OrderedPoints& points, const PointBuffer<std::uint32_t>& faces, bool by_sides,
                const cl::Buffer& signs, const engine::OutputBuffers& outputs) {
        cl::Kernel kernel(program_, "finish_points");
        const cl_uint last =
            engine::set_arguments(kernel, 0, *points.in_units, *points.places, *faces,
                                  inputs_.sides ? *inputs_.sides->sides : *points.places,  // or unused
                                  cl_uint{by_sides}, signs, cl_uint{0}, static_cast<cl_uint>(count),
                                  cl_double{half_width_}, *inputs_.mesh->polyhedra, outputs[Output::distance]);
        finishing_.set_arguments(kernel, last, outputs);
        engine::launch(queue_, kernel, {count});
    }

    const engine::Finishing& finishing() const { return finishing_; }

private:
    void search_tree(const std::function<void(double)>& between) {
        const engine::PointMesh& mesh = *inputs_.mesh;
        cl::Kernel kernel(program_, "nearest_of_points");
        // How long a search takes depends on the mesh and the point.
        engine::measured_launches(
            tools_.context, count_, seconds_per_search, most_run * engine::cores_of(tools_.context.capabilities()),
            between, [&](std::size_t begin, std::size_t end) {
                engine::launch(queue_, kernel, {chunk_count(end - begin, run()), tools_.programs.part_group()},
                               mesh.tree, *mesh.device_nodes, *mesh.leaves, *mesh.polyhedra, *mesh.faces,
                               *points_.in_units, static_cast<cl_uint>(begin), static_cast<cl_uint>(end),
                               static_cast<cl_uint>(run()), cl_double{most()}, *faces_, *squared_);
            });
    }

    void search_by_group(const std::function<void(double)>& between) {
        const engine::PointMesh& mesh = *inputs_.mesh;
        const engine::FittedTree& tree = *inputs_.tree;
        const engine::DividedFaces& divided = *tree.divided;
        const cl::Program program = inputs_.needs_deep_stack() ? tools_.programs.nearest_deep : tools_.programs.nearest;
        cl::Kernel list(program, "list_faces"), decide(program, "decide_faces"), again(program, "search_again");
        const std::size_t together = std::min(count_, most_listed);
        const PointBuffer<cl_uint> places(*tools_.pool, together * CLSDF_LISTED_FACES, "faces near points"),
            counts(*tools_.pool, together, "faces near points");
        const auto search = [&](std::size_t first, std::size_t last) {
            const engine::WorkItems points{last - first};
            const auto begin = static_cast<cl_uint>(first), end = static_cast<cl_uint>(last);
            engine::launch(queue_, list, points, divided.tree, *tree.nodes, *tree.faces, *points_.in_units, begin, end,
                           cl_double{most()}, *places, *counts);
            engine::launch(queue_, decide, points, *divided.order, *mesh.polyhedra, *mesh.faces, *points_.in_units,
                           begin, end, cl_double{most()}, *places, *counts, *faces_, *squared_);
            engine::launch(queue_, again, points, divided.tree, *tree.nodes, *tree.faces, *divided.order,
                           *mesh.polyhedra, *mesh.faces, *points_.in_units, begin, end, cl_double{most()}, *counts,
                           *faces_, *squared_);
        };
        engine::measured_launches(tools_.context, count_, seconds_per_search,
                                  most_run * engine::cores_of(tools_.context.capabilities()), between,
                                  [&](std::size_t begin, std::size_t end) {
                                      for (std::size_t first = begin; first < end; first += together)
                                          search(first, std::min(end, first + together));
                                  });
    }

    double most() const { return search_limit(*inputs_.mesh, half_width_); }

    std::size_t run() const {
        return std::clamp<std::size_t>(count_ / (8 * tools_.context.capabilities().compute_units), 1, most_run);
    }

    engine::DeviceTools tools_;
    cl::CommandQueue queue_;
    cl::Program program_;
    const PointInputs& inputs_;
    engine::Finishing finishing_;
    double half_width_;
    std::size_t count_;
    std::unique_ptr<const PointGroups> groups_;
    OrderedPoints points_;
    PointBuffer<std::uint32_t> faces_;
    PointBuffer<double> squared_;
};

// By the host: the order of the points and, where the sides of faces do not tell them, their signs.
// --------------------

UninitializedVector<std::uint32_t> order_by_host(const engine::PointMesh& mesh, std::span<const Vec3> points) {
    if (points.size() >= fewest_sorted) return curve_order(points, box_of_curve(mesh));
    UninitializedVector<std::uint32_t> order(points.size());
    std::iota(order.begin(), order.end(), 0U);
    return order;
}

Query query_in_order(const engine::DeviceTools& tools, const PointInputs& inputs, std::span<const Vec3> points,
                     std::span<const std::uint32_t> order, double half_width) {
    device::HostFilling filling(tools.context, tools.pool, points.size() * sizeof(Vec3), "points");
    const std::span<Vec3> in_units(static_cast<Vec3*>(filling.memory()), points.size());
    for_each_index(points.size(), [&](std::size_t i) { in_units[i] = inputs.mesh->in_units(points[order[i]]); });
    std::unique_ptr<const PointGroups> groups;
    if (inputs.scanned) groups = std::make_unique<const PointGroups>(group_points(in_units));
    device::BufferPool::Lease places = device::uploaded(tools.context, tools.pool, order, "order of points");
    return {tools, inputs, {filling.finish(), std::move(places)}, points.size(), half_width, std::move(groups)};
}

/// Returns the seconds spent on signs that the sides of faces do not tell.
double finish_by_host(const engine::DeviceTools& tools, const PointInputs& inputs, Query& query,
                      std::span<const Vec3> points, std::span<const std::uint32_t> order,
                      const engine::OutputBuffers& outputs) {
    const cl::CommandQueue& queue = tools.queue();
    PointBuffer<std::uint8_t> device_signs(*tools.pool, points.size(), "signs of points");
    std::vector<std::uint8_t> signs(points.size(), std::uint8_t{CLSDF_POINT_UNDECIDED});
    if (inputs.sides) {
        query.finish(true, *device_signs, outputs);
        device_signs.read(queue, signs);
    }
    const Stopwatch watch;
    if (std::find(signs.begin(), signs.end(), CLSDF_POINT_UNDECIDED) != signs.end()) {
        UninitializedVector<double> squared(points.size());
        query.squared().read(queue, squared);
        find_signs(*inputs.mesh, inputs.sign, {points, order, squared}, signs);
        device_signs.write(queue, signs);
        query.finish(false, *device_signs, outputs);
    }
    return watch.seconds();
}

// By the device.
// -------------------------------------------------------------------------------------------------------

/// Enqueues the decision of signs that need no crossings. Returns those that do.
PointBuffer<cl_uint> find_open(const engine::DeviceTools& tools, const PointInputs& inputs, const DeviceBatch& batch,
                               Query& query, const cl::Buffer& signs) {
    PointBuffer<cl_uint> open(*tools.pool, batch.points.count, "points without a sign");
    cl::Kernel kernel(tools.programs.point_order, "find_open_points");
    // If open edges count, a point anywhere may be inside.
    const PointLimits limits = inputs.mesh->film ? batch.usable : limits_of(inputs.mesh->box);
    engine::launch(tools.queue(), kernel, {batch.points.count}, batch.points.source,
                   static_cast<cl_uint>(batch.points.count), limits, cl_uint{inputs.sign == SignRule::none},
                   cl_double{nearly_on_surface}, static_cast<cl_uint>(batch.first_place),
                   cl_uint{inputs.sides != nullptr}, batch.points.memory, *query.points().places, *query.squared(),
                   signs, *open);
    return open;
}

/// Decides signs by the host, and enqueues the outputs. starts: of each point in the list of `total` points.
void finish_open(const engine::DeviceTools& tools, const PointInputs& inputs, const DeviceBatch& batch, Query& query,
                 const cl::Buffer& starts, std::size_t total, const engine::OutputBuffers& outputs) {
    const cl::CommandQueue& queue = tools.queue();
    const char* const purpose = "points whose crossings are counted";
    PointBuffer<OpenPoint> listed(*tools.pool, total, purpose);
    const OrderedPoints ordered{tools.pool->lease(total * sizeof(Vec3), purpose),
                                tools.pool->lease(total * sizeof(cl_uint), purpose)};
    PointBuffer<std::uint32_t> faces(*tools.pool, total, purpose);
    cl::Kernel kernel(tools.programs.point_order, "list_open_points");
    engine::launch(queue, kernel, {batch.points.count}, batch.points.source, static_cast<cl_uint>(batch.points.count),
                   static_cast<cl_uint>(batch.first_place), batch.points.memory, starts, *query.points().in_units,
                   *query.points().places, *query.faces(), *query.squared(), *listed, *ordered.in_units,
                   *ordered.places, *faces);
    UninitializedVector<OpenPoint> open(total);
    listed.read(queue, open);
    std::vector<Vec3> positions(total);
    std::vector<double> squared(total);
    std::vector<std::uint32_t> order(total);
    for (std::size_t i = 0; i < total; ++i) {
        std::copy(std::begin(open[i].position), std::end(open[i].position), positions[i].begin());
        squared[i] = open[i].squared;
        order[i] = static_cast<std::uint32_t>(i);
    }
    std::vector<std::uint8_t> signs(total, std::uint8_t{CLSDF_POINT_UNDECIDED});
    find_signs(*inputs.mesh, inputs.sign, {positions, order, squared}, signs);
    PointBuffer<std::uint8_t> device_signs(*tools.pool, total, purpose);
    device_signs.write(queue, signs);
    query.finish(total, ordered, faces, false, *device_signs, outputs);
}

/// Returns the seconds spent on signs that the sides of faces do not tell.
double finish_on_device(const engine::DeviceTools& tools, const PointInputs& inputs, const DeviceBatch& batch,
                        Query& query, const engine::OutputBuffers& outputs) {
    const std::size_t count = batch.points.count;
    PointBuffer<std::uint8_t> signs(*tools.pool, count, "signs of points");
    if (inputs.sides) query.finish(true, *signs, outputs);
    const Stopwatch watch;
    const device::BufferPool::Lease starts = tools.pool->lease((count + 1) * sizeof(cl_uint), "points without a sign");
    engine::PrefixSums sums(tools, *find_open(tools, inputs, batch, query, *signs), *starts, count, "points");
    query.finish(false, *signs, outputs);
    if (const std::size_t total = sums.total(); total > 0)
        finish_open(tools, inputs, batch, query, *starts, total, outputs);
    return watch.seconds();
}

/// Enqueues the outputs of points that are not usable.
void leave_unusable(const engine::DeviceTools& tools, const PointInputs& inputs, const DeviceBatch& batch,
                    const Query& query, double half_width, const engine::OutputBuffers& outputs) {
    cl::Kernel kernel(tools.programs.point_order, "leave_unusable_points");
    const cl_uint last = engine::set_arguments(kernel, 0, batch.points.source, static_cast<cl_uint>(batch.points.count),
                                               batch.usable, cl_uint{std::isfinite(half_width)}, cl_double{half_width},
                                               static_cast<cl_uint>(batch.first_place), batch.points.memory,
                                               *inputs.mesh->polyhedra, outputs[Output::distance]);
    query.finishing().set_arguments(kernel, last, outputs);
    engine::launch(tools.queue(), kernel, {batch.points.count});
}

/// Looks up points of the host that are all usable, by way of memory of the device.
PointTimes query_uploaded(const engine::DeviceTools& tools, const PointInputs& inputs, std::span<const Vec3> points,
                          double half_width, const engine::OutputBuffers& outputs,
                          const std::function<void(double)>& between) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const PointLimits everywhere{{-infinity, -infinity, -infinity}, {infinity, infinity, infinity}};
    const device::BufferPool::Lease positions =
        device::uploaded(tools.context, tools.pool, points, "points of the caller");
    const DevicePoints on_device = packed_points(*positions, points.size());
    const device::BufferPool::Lease cells = measure_points(tools, on_device, everywhere, box_of_curve(*inputs.mesh));
    return query_points(tools, inputs, {on_device, everywhere, *cells, false}, half_width, outputs, between);
}

}  // namespace

Box box_of_curve(const engine::PointMesh& mesh) {
    Box box = mesh.box;  // enlarged: neighbours outside stay neighbours
    const double margin = box.longest_side() / 8;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] -= margin;
        box.upper[axis] += margin;
    }
    return box;
}

double search_limit(const engine::PointMesh& mesh, double half_width) {
    const double units = half_width / mesh.lattice.unit * (1 + 1e-9) + 1e-6;
    return units * units;
}

PointTimes query_points(const engine::DeviceTools& tools, const PointInputs& inputs, std::span<const Vec3> points,
                        double half_width, const targets::HostArrays& arrays,
                        const std::function<void(double)>& between) {
    PointTimes times;
    if (points.empty()) return times;
    tools.context.run_or_drain([&] {
        targets::OutputMemories memories;
        const auto place = [&] { memories.place(tools.context, *tools.pool, arrays, points.size()); };
        if (tools.programs.body == KernelBody::by_group) {
            place();
            times = query_uploaded(tools, inputs, points, half_width, memories.buffers, between);
            memories.enqueue_handover(tools.queue());
            tools.queue().finish();
            memories.read(tools.context, tools.queue());
            return;
        }
        const Stopwatch watch;
        const UninitializedVector<std::uint32_t> order = order_by_host(*inputs.mesh, points);
        Query query = query_in_order(tools, inputs, points, order, half_width);
        query.find_nearest(between);
        place();
        times.sign = finish_by_host(tools, inputs, query, points, order, memories.buffers);
        memories.enqueue_handover(tools.queue());
        tools.queue().finish();
        memories.read(tools.context, tools.queue());
        times.nearest = watch.seconds() - times.sign;
    });
    return times;
}

PointTimes query_points(const engine::DeviceTools& tools, const PointInputs& inputs, const DeviceBatch& batch,
                        double half_width, const engine::OutputBuffers& outputs,
                        const std::function<void(double)>& between) {
    PointTimes times;
    if (batch.points.count == 0) return times;
    tools.context.run_or_drain([&] {
        const Stopwatch watch;
        Query query(
            tools, inputs,
            order_points(tools, batch.points, batch.usable, batch.cells, inputs.mesh->lattice, batch.first_place),
            batch.points.count, half_width);
        query.find_nearest(between);
        times.sign = finish_on_device(tools, inputs, batch, query, outputs);
        if (batch.has_unusable) leave_unusable(tools, inputs, batch, query, half_width, outputs);
        tools.queue().finish();
        times.nearest = watch.seconds() - times.sign;
    });
    return times;
}

}  // namespace clsdf::points
