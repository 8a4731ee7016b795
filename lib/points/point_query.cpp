#include "points/point_query.hpp"

#include "core/large_memory.hpp"
#include "core/parallel.hpp"
#include "core/stopwatch.hpp"
#include "device/buffer_pool.hpp"
#include "device/read_back.hpp"
#include "launch/commands.hpp"
#include "launch/short_launches.hpp"
#include "points/curve_order.hpp"
#include "points/signs_by_host.hpp"
#include "tree/point_mesh.hpp"
#include "tree/wide_tree.hpp"

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
/// A buffer for a value of each point.
template <typename Value>
class PointBuffer {
public:
    PointBuffer(device::BufferPool& pool, std::size_t count, const char* purpose)
        : lease_(pool.lease(count * sizeof(Value), purpose)) {}

    const cl::Buffer& operator*() const { return *lease_; }

private:
    device::BufferPool::Lease lease_;
};

/// Points of the host on the device, in the order of a curve, and their nearest faces.
class Query {
public:
    /// in_units, places: a Vec3 of each point, and a cl_uint that says where its results go. groups: of the points if
    /// they are scanned; null: they are looked up one by one.
    Query(const engine::DeviceTools& tools, const PointInputs& inputs, device::BufferPool::Lease in_units,
          device::BufferPool::Lease places, std::size_t count, double half_width,
          std::unique_ptr<const PointGroups> groups)
        : tools_(tools),
          launches_(tools.queue(), tools.context.kernels()),
          inputs_(inputs),
          finishing_(inputs.mesh->lattice, inputs.sites, inputs.is_inside_out),
          half_width_(half_width),
          count_(count),
          groups_(std::move(groups)),
          in_units_(std::move(in_units)),
          places_(std::move(places)),
          faces_(*tools_.pool, count, "nearest faces of points"),
          squared_(*tools_.pool, count, "squared distances of points") {}

    void find_nearest(const std::function<void(double)>& between) {
        const double most = search_limit(*inputs_.mesh, half_width_);
        if (groups_) {
            scan_points({tools_, *inputs_.mesh, *inputs_.scanned, *groups_, count_, *in_units_, most}, *faces_,
                        *squared_, between);
            return;
        }
        // How long a search takes depends on the mesh and the point.
        const std::size_t run = points_in_run(tools_.context, count_);
        engine::measured_launches(
            tools_.context, count_, seconds_per_search, most_in_run * engine::cores_of(tools_.context.capabilities()),
            between, [&](std::size_t begin, std::size_t end) {
                enqueue_tree_search(launches_, tools_, inputs_, *in_units_, begin, end, run, most, *faces_, *squared_);
            });
    }

    const PointBuffer<double>& squared() const { return squared_; }

    /// Enqueues the outputs of the points that have a sign. by_sides: that of the side of their nearest face.
    void finish(bool by_sides, const cl::Buffer& signs, const engine::OutputBuffers& outputs) {
        enqueue_outputs(launches_, tools_, inputs_, finishing_, {count_, *in_units_, *places_, *faces_}, by_sides,
                        signs, half_width_, outputs);
    }

private:
    engine::DeviceTools tools_;
    engine::Launches launches_;
    const PointInputs& inputs_;
    engine::Finishing finishing_;
    double half_width_;
    std::size_t count_;
    std::unique_ptr<const PointGroups> groups_;
    device::BufferPool::Lease in_units_, places_;
    PointBuffer<std::uint32_t> faces_;
    PointBuffer<double> squared_;
};

// By the host: the order of the points and, where the sides of faces do not tell them, their signs.
// --------------------

UninitializedVector<std::uint32_t> order_by_host(const engine::PointFaces& mesh, std::span<const Vec3> points) {
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
    return {tools, inputs, filling.finish(), std::move(places), points.size(), half_width, std::move(groups)};
}

/// Returns the seconds spent on signs that the sides of faces do not tell.
double finish_by_host(const engine::DeviceTools& tools, const PointInputs& inputs, Query& query,
                      std::span<const Vec3> points, std::span<const std::uint32_t> order,
                      const engine::OutputBuffers& outputs) {
    const PointBuffer<std::uint8_t> device_signs(*tools.pool, points.size(), "signs of points");
    std::vector<std::uint8_t> signs(points.size(), std::uint8_t{CLSDF_POINT_UNDECIDED});
    if (inputs.sides) {
        query.finish(true, *device_signs, outputs);
        device::read_values(tools.context, *device_signs, signs);
    }
    const Stopwatch watch;
    if (std::find(signs.begin(), signs.end(), CLSDF_POINT_UNDECIDED) != signs.end()) {
        UninitializedVector<double> squared(points.size());
        device::read_values(tools.context, *query.squared(), squared);
        find_signs({*inputs.host_mesh(), *inputs.host_tree()}, inputs.sign, {points, order, squared}, signs);
        device::write_values(tools.context, signs, *device_signs);
        query.finish(false, *device_signs, outputs);
    }
    return watch.seconds();
}

// By the device.
// -------------------------------------------------------------------------------------------------------

/// Decides the signs of `total` points that kernels have left open by the host, and enqueues their outputs.
void finish_left(const engine::Launches& launches, const engine::DeviceTools& tools, const PointInputs& inputs,
                 const PointRun& run, const DevicePoints& points, std::size_t total, double half_width,
                 const engine::OutputBuffers& outputs) {
    const char* const purpose = "points whose crossings are counted";
    const PointBuffer<OpenPoint> listed(*tools.pool, total, purpose);
    const PointBuffer<Vec3> in_units(*tools.pool, total, purpose);
    const PointBuffer<cl_uint> places(*tools.pool, total, purpose), faces(*tools.pool, total, purpose);
    launches.launch(tools.programs.point_order, "gather_open_points", {total}, points.source,
                    static_cast<cl_uint>(total), points.memory, run.left(), run.in_units(), run.places(), run.faces(),
                    run.squared(), *listed, *in_units, *places, *faces);
    UninitializedVector<OpenPoint> open(total);
    device::read_values(tools.context, *listed, open);
    std::vector<Vec3> positions(total);
    std::vector<double> squared(total);
    for (std::size_t i = 0; i < total; ++i) {
        std::copy(std::begin(open[i].position), std::end(open[i].position), positions[i].begin());
        squared[i] = open[i].squared;
    }
    // Neighbours in the order share crossings.
    const UninitializedVector<std::uint32_t> order = order_by_host(*inputs.mesh, positions);
    std::vector<double> ordered_squared(total);
    for (std::size_t i = 0; i < total; ++i) ordered_squared[i] = squared[order[i]];
    std::vector<std::uint8_t> ordered_signs(total, std::uint8_t{CLSDF_POINT_UNDECIDED}), signs(total);
    find_signs({*inputs.host_mesh(), *inputs.host_tree()}, inputs.sign, {positions, order, ordered_squared},
               ordered_signs);
    for (std::size_t i = 0; i < total; ++i) signs[order[i]] = ordered_signs[i];
    const PointBuffer<std::uint8_t> device_signs(*tools.pool, total, purpose);
    device::write_values(tools.context, signs, *device_signs);
    enqueue_outputs(launches, tools, inputs,
                    engine::Finishing(inputs.mesh->lattice, inputs.sites, inputs.is_inside_out),
                    {total, *in_units, *places, *faces}, false, *device_signs, half_width, outputs);
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
    PointRun run(tools, points.size());
    PointCells found{};
    return query_points(tools, inputs, run, {on_device, everywhere, &on_device}, half_width, outputs, {}, found,
                        between);
}

}  // namespace

PointTimes query_points(const engine::DeviceTools& tools, const PointInputs& inputs, std::span<const Vec3> points,
                        double half_width, const targets::HostArrays& arrays,
                        const std::function<void(double)>& between) {
    PointTimes times;
    if (points.empty()) return times;
    tools.context.run_or_drain([&] {
        targets::OutputMemories memories;
        const auto place = [&] { memories.place(tools.context, *tools.pool, arrays, points.size()); };
        if (inputs.sign_faces) {
            place();
            times = query_uploaded(tools, inputs, points, half_width, memories.buffers, between);
            memories.enqueue_handover(tools.queue());
            tools.context.finish();
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
        tools.context.finish();
        memories.read(tools.context, tools.queue());
        times.nearest = watch.seconds() - times.sign;
    });
    return times;
}

PointCells measured_points(const engine::DeviceTools& tools, PointRun& run, const DevicePoints& all,
                           const PointLimits& usable, const engine::PointFaces& mesh) {
    PointCells found{};
    tools.context.run_or_drain([&] {
        run.enqueue_measure(engine::Launches(tools.queue(), tools.context.kernels()), tools, all, usable, mesh);
        found = device::read_value<PointCells>(tools.context, run.cells());
    });
    return found;
}

PointTimes query_points(const engine::DeviceTools& tools, const PointInputs& inputs, PointRun& run,
                        const DeviceBatch& batch, double half_width, const engine::OutputBuffers& outputs,
                        const std::function<void(const engine::Launches&)>& copy, PointCells& found,
                        const std::function<void(double)>& between) {
    PointTimes times;
    if (batch.points.count == 0) return times;
    tools.context.run_or_drain([&] {
        const Stopwatch watch;
        const engine::Launches launches(tools.queue(), tools.context.kernels());
        if (batch.all != nullptr) run.enqueue_measure(launches, tools, *batch.all, batch.usable, *inputs.mesh);
        run.enqueue(launches, tools, inputs, {batch.points, batch.usable, half_width, outputs}, between);
        if (copy) copy(launches);
        found = device::read_value<PointCells>(tools.context, run.cells());
        const Stopwatch sign_watch;
        if (found.left > 0) {
            finish_left(launches, tools, inputs, run, batch.points, found.left, half_width, outputs);
            if (copy) copy(launches);
            tools.context.finish();
        }
        times.sign = sign_watch.seconds();
        times.nearest = watch.seconds() - times.sign;
    });
    return times;
}

}  // namespace clsdf::points
