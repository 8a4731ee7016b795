#include "benchmarks/call_job.hpp"
#include "benchmarks/points.hpp"

#include "device/opencl.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace clsdf::bench {

namespace {

std::vector<Vec3> twisted(const Mesh& mesh) {
    std::vector<Vec3> positions = mesh.vertices();
    const double per_length = 0.2 / mesh.box().longest_side();
    for (Vec3& p : positions) {
        const double turn = per_length * p[0];
        p = {p[0], std::cos(turn) * p[1] - std::sin(turn) * p[2], std::sin(turn) * p[1] + std::cos(turn) * p[2]};
    }
    return positions;
}

/// A mesh in memory of the device, and a field's distances there.
class DeviceArrays {
public:
    DeviceArrays(const Device& device, const Mesh& mesh, std::size_t samples)
        : context_(device.context(), true),
          queue_(device.queue(), true),
          vertices_(mesh.vertices().size()),
          faces_(mesh.triangles().size()),
          positions_(copied(mesh.vertices())),
          triangles_(copied(mesh.triangles())),
          distance_(context_, CL_MEM_READ_WRITE, samples * sizeof(float)) {}

    InputArray positions() const { return {positions_(), ElementType::float64, vertices_}; }
    MeshView mesh() const { return {positions(), InputArray(triangles_(), ElementType::uint32, faces_)}; }
    OutputArray distance() const { return OutputArray(distance_()); }
    void run(Plan& plan) const {
        cl_event done = nullptr;
        plan.enqueue(queue_(), distance_(), {}, &done);
        cl::Event(done).wait();
    }
    void read(Field& field) const {
        queue_.enqueueReadBuffer(distance_, CL_TRUE, 0, field.distance().size() * sizeof(float),
                                 field.distance().data());
    }
    void wait() const { queue_.finish(); }

private:
    template <typename Item>
    cl::Buffer copied(const std::vector<Item>& items) const {
        const cl::Buffer buffer(context_, CL_MEM_READ_WRITE, items.size() * sizeof(Item));
        queue_.enqueueWriteBuffer(buffer, CL_TRUE, 0, items.size() * sizeof(Item), items.data());
        return buffer;
    }

    cl::Context context_;
    cl::CommandQueue queue_;
    std::size_t vertices_, faces_;
    cl::Buffer positions_, triangles_, distance_;
};

}  // namespace

CallCost measure_moved(const CallJob& job, const char* name, std::int64_t resolution) {
    CallCost cost{name, fmt::format("vertices move, and a field of {0} samples on the longest side / a transform is "
                                    "made, and its first field",
                                    resolution)};
    cost.limit = 0.5;
    const Mesh moved(twisted(job.mesh), job.mesh.triangles(), job.mesh.name());
    const Grid grid = job.grid(resolution);
    const Band band = CallJob::band(grid);
    Field field = job.transform().compute(grid, band);
    DistanceTransform transform = job.transform();
    job.measure(
        cost,
        [&] {
            transform.set_positions(job.mesh.vertices());
            transform.compute(grid, band, field.distance());
            return seconds_of([&] {
                transform.set_positions(moved.vertices());
                transform.compute(grid, band, field.distance());
            });
        },
        [&] {
            return seconds_of([&] { DistanceTransform(job.device, moved).compute(grid, band, field.distance()); });
        });
    CallJudge(moved, job.options.seed).look_at(transform.compute(grid, band), job.options.samples_judged, cost);
    return cost;
}

CallCost measure_moved_points(const CallJob& job) {
    CallCost cost{"moved_points", "vertices move, and a query of a million points / the same query without a move"};
    const Mesh moved(twisted(job.mesh), job.mesh.triangles(), job.mesh.name());
    const std::vector<Vec3> points = points_around(moved, job.is_quick ? 20'000 : 1'000'000, job.options.seed);
    std::vector<float> distance(points.size());
    const auto query = [&](const DistanceTransform& transform) {
        transform.query(points, std::numeric_limits<double>::infinity(), distance);
    };
    DistanceTransform transform = job.transform();
    const DistanceTransform kept(job.device, moved);
    // The first queries prepare the mesh: the tree, then the sides of faces.
    query(kept);
    query(kept);
    job.measure(
        cost,
        [&] {
            transform.set_positions(job.mesh.vertices());
            query(transform);
            return seconds_of([&] {
                transform.set_positions(moved.vertices());
                query(transform);
            });
        },
        [&] { return seconds_of([&] { query(kept); }); });
    // The results of the last call, after a move.
    CallJudge(moved, job.options.seed)
        .look_at(points, distance, moved.box().longest_side() / 256, job.options.samples_judged, cost);
    return cost;
}

CallCost measure_device_first(const CallJob& job, CallJudge& judge) {
    CallCost cost{
        "device_first",
        "a transform is made of a mesh in memory of the device, and its first field goes there; a band of 10% "
        "on 256 samples on the longest side / the same from and to memory of the host"};
    const Band wide = Band::symmetric(0.1 * job.mesh.box().longest_side());
    const Grid grid = Grid::around(job.mesh, job.scaled(256), wide);
    Field field = job.transform().compute(grid, wide);
    const DeviceArrays arrays(job.device, job.mesh, field.distance().size());
    job.measure(
        cost,
        [&] {
            return seconds_of([&] {
                DistanceTransform(job.device, arrays.mesh()).compute(grid, wide, arrays.distance());
                arrays.wait();
            });
        },
        [&] { return seconds_of([&] { job.transform().compute(grid, wide, field.distance()); }); });
    arrays.read(field);
    judge.look_at(field, job.options.samples_judged, cost);
    return cost;
}

CallCost measure_step(const CallJob& job, bool from_device) {
    CallCost cost{
        from_device ? "device_step" : "plan_update",
        fmt::format("vertices{} and a plan move, and a run of the plan, a field of 256 samples on the longest "
                    "side in device memory / vertices of the host move, and the field in host memory",
                    from_device ? " in device memory" : "")};
    const Mesh moved(twisted(job.mesh), job.mesh.triangles(), job.mesh.name());
    const Grid grid = job.grid(256);
    const Band band = CallJob::band(grid);
    Field field = job.transform().compute(grid, band);
    const DeviceArrays before(job.device, job.mesh, 1), after(job.device, moved, field.distance().size());
    DistanceTransform transform = from_device ? DistanceTransform(job.device, before.mesh()) : job.transform();
    DistanceTransform on_host = job.transform();
    Plan plan = transform.plan(grid, band);
    const auto run = [&](const Mesh& mesh, const DeviceArrays& arrays) {
        if (from_device)
            transform.set_positions(arrays.positions());
        else
            transform.set_positions(mesh.vertices());
        plan.update(transform);
        after.run(plan);
    };
    const auto compute = [&](const Mesh& mesh) {
        on_host.set_positions(mesh.vertices());
        on_host.compute(grid, band, field.distance());
    };
    job.measure(
        cost,
        [&] {
            run(job.mesh, before);
            return seconds_of([&] { run(moved, after); });
        },
        [&] {
            compute(job.mesh);
            return seconds_of([&] { compute(moved); });
        });
    after.read(field);
    CallJudge(moved, job.options.seed).look_at(field, job.options.samples_judged, cost);
    return cost;
}

}  // namespace clsdf::bench
