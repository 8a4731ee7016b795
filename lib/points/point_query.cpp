#include "points/point_query.hpp"

#include "core/large_memory.hpp"
#include "core/parallel.hpp"
#include "core/stopwatch.hpp"
#include "device/buffer_pool.hpp"
#include "launch/commands.hpp"
#include "launch/short_launches.hpp"
#include "points/curve_order.hpp"
#include "points/point_signs.hpp"
#include "tree/point_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

namespace clsdf::points {

namespace {

// Fewer points are taken as they come.
constexpr std::size_t fewest_sorted = 128;
// Points of a work-item on a processor, which share their way through the tree.
constexpr std::size_t most_run = 64;
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

/// The computation of some points, which lie on the device in the order of a curve.
class Query {
public:
    Query(const engine::DeviceTools& tools, const PointInputs& inputs, std::span<const Vec3> points, double half_width)
        : tools_(tools),
          queue_(tools.queue()),
          program_(tools.programs.points),
          inputs_(inputs),
          callers_(points),
          half_width_(half_width),
          device_faces_(*tools_.pool, points.size(), "nearest faces of points"),
          device_squared_(*tools_.pool, points.size(), "squared distances of points") {
        order();
        device::HostFilling filling(tools_.context, tools_.pool, count() * sizeof(Vec3), "points");
        const std::span<Vec3> in_units(static_cast<Vec3*>(filling.memory()), count());
        for_each_index(count(), [&](std::size_t i) { in_units[i] = inputs_.mesh->in_units(callers_[order_[i]]); });
        if (inputs_.scanned) groups_.emplace(group_points(in_units));
        device_points_ = filling.finish();
    }

    void find_nearest(const std::function<void(double)>& between) {
        if (inputs_.scanned)
            scan_points({tools_, *inputs_.mesh, *inputs_.scanned, *groups_, count(), *device_points_, most()},
                        *device_faces_, *device_squared_, between);
        else
            search_tree(between);
    }

    void search_tree(const std::function<void(double)>& between) {
        const engine::PointMesh& mesh = *inputs_.mesh;
        cl::Kernel kernel(program_, "nearest_of_points");
        // How long a search takes depends on the mesh and the point.
        engine::measured_launches(
            tools_.context, count(), seconds_per_search, most_run * engine::cores_of(tools_.context.capabilities()),
            between, [&](std::size_t begin, std::size_t end) {
                engine::launch(queue_, kernel, {chunk_count(end - begin, run()), tools_.programs.part_group()},
                               mesh.tree, *mesh.device_nodes, *mesh.leaves, *mesh.polyhedra, *mesh.faces,
                               *device_points_, static_cast<cl_uint>(begin), static_cast<cl_uint>(end),
                               static_cast<cl_uint>(run()), cl_double{most()}, *device_faces_, *device_squared_);
            });
    }

    /// Signs and outputs. Returns the seconds spent on signs that the sides of faces do not tell.
    double finish(const targets::HostArrays& arrays) {
        const auto places = device::uploaded(tools_.context, tools_.pool, order_, "order of points");
        PointBuffer<std::uint8_t> signs(*tools_.pool, count(), "signs of points");
        targets::OutputMemories memories;
        memories.place(tools_.context, *tools_.pool, arrays, count());
        const engine::OutputBuffers& outputs = memories.buffers;
        const engine::Finishing finishing(inputs_.mesh->lattice, inputs_.sites, inputs_.is_inside_out);
        cl::Kernel kernel(program_, "finish_points");
        const auto launch = [&](cl_uint by_sides) {
            const cl_uint last =
                engine::set_arguments(kernel, 0, *device_points_, *places, *device_faces_,
                                      inputs_.sides ? *inputs_.sides->sides : *places,  // or unused
                                      by_sides, *signs, cl_uint{0}, static_cast<cl_uint>(count()),
                                      cl_double{half_width_}, *inputs_.mesh->polyhedra, outputs[Output::distance]);
            finishing.set_arguments(kernel, last, outputs);
            engine::launch(queue_, kernel, {count()});
        };
        signs_.assign(count(), std::uint8_t{CLSDF_POINT_UNDECIDED});
        if (inputs_.sides) {
            launch(1);
            signs.read(queue_, signs_);
        }
        const Stopwatch watch;
        if (std::find(signs_.begin(), signs_.end(), CLSDF_POINT_UNDECIDED) != signs_.end()) {
            UninitializedVector<double> squared(count());
            device_squared_.read(queue_, squared);
            find_signs(*inputs_.mesh, inputs_.sign, {callers_, order_, squared}, signs_);
            signs.write(queue_, signs_);
            launch(0);
        }
        const double seconds = watch.seconds();
        memories.enqueue_handover(queue_);
        queue_.finish();
        memories.read(tools_.context, queue_);
        return seconds;
    }

private:
    std::size_t count() const { return callers_.size(); }

    void order() {
        if (count() < fewest_sorted) {
            order_.resize(count());
            std::iota(order_.begin(), order_.end(), 0U);
        } else {
            Box box = inputs_.mesh->box;  // enlarged: neighbours outside stay neighbours
            const double margin = box.longest_side() / 8;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                box.lower[axis] -= margin;
                box.upper[axis] += margin;
            }
            order_ = curve_order(callers_, box);
        }
    }

    double most() const { return search_limit(*inputs_.mesh, half_width_); }

    std::size_t run() const {
        if (tools_.programs.body == KernelBody::by_group) return 1;
        return std::clamp<std::size_t>(count() / (8 * tools_.context.capabilities().compute_units), 1, most_run);
    }

    engine::DeviceTools tools_;
    cl::CommandQueue queue_;
    cl::Program program_;
    const PointInputs& inputs_;
    std::span<const Vec3> callers_;
    double half_width_;
    UninitializedVector<std::uint32_t> order_;
    std::vector<std::uint8_t> signs_;
    std::optional<PointGroups> groups_;
    device::BufferPool::Lease device_points_;
    PointBuffer<std::uint32_t> device_faces_;
    PointBuffer<double> device_squared_;
};

}  // namespace

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
        const Stopwatch watch;
        Query query(tools, inputs, points, half_width);
        query.find_nearest(between);
        times.sign = query.finish(arrays);
        times.nearest = watch.seconds() - times.sign;
    });
    return times;
}

}  // namespace clsdf::points
