// Counts the calls and bytes of W1 on a GPU: the first call of a transform, one of a kept transform, the first call of
// a second transform on the same Device, many patches in one call, a query of points in memory of the device, a run of
// a plan for them, and a step of a body that moves; and the work of the searches for the nearest triangles of points
// (scripts/gpu-counts).
#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>
#include <clsdf/tuning.hpp>

#ifdef CLSDF_TEST_CUBQL
#include "disguise/cubql_search.hpp"
#endif
#include "disguise/disguise.hpp"
#include "disguise/thread_times.hpp"
#include "support/counted_searches.hpp"

#include "device/buffer_pool.hpp"
#include "device/context.hpp"
#include "launch/programs.hpp"
#include "tree/binary_tree.hpp"
#include "tree/wide_tree.hpp"

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <fmt/format.h>
#include <tbb/global_control.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

using namespace clsdf;

namespace {

constexpr std::int64_t resolution = 256;
constexpr double band_of_longest_side = 0.1;
constexpr unsigned compute_units = 132;  // as an H100 has
constexpr std::size_t patch_count = 512;
constexpr std::int64_t patch_side = 20;
constexpr std::size_t point_count = 1'000'000;
constexpr std::size_t searched_count = 4'000;
constexpr double points_within = 0.012;  // of the longest side, on each axis
constexpr double points_around = 0.1;    // of the box of uniform ones
constexpr double megabyte = 1e6;
constexpr int host_rounds = 9;
constexpr double voxels_of_moved_band = 3;
constexpr double moved_by = 1e-6;  // of the longest side

/// The numbers of a call, in the order in which they are shown.
std::vector<std::pair<std::string, std::uint64_t>> numbers_of(const disguise::Counts& counts) {
    const auto list_kernel = counts.kernels.find("coarse_pairs");
    return {{"bytes_up", counts.bytes_up},
            {"bytes_down", counts.bytes_down},
            {"pageable_bytes", counts.pageable_bytes},
            {"transfers_up", counts.transfers_up},
            {"transfers_down", counts.transfers_down},
            {"blocking_waits", counts.blocking_waits},
            {"pinned_reads", counts.pinned_reads},
            {"list_passes", list_kernel == counts.kernels.end() ? 0 : list_kernel->second.runs},
            {"commands", counts.commands},
            {"launches", counts.launches},
            {"fills", counts.fills},
            {"allocations", counts.allocations},
            {"allocated_bytes", counts.allocated_bytes},
            {"calls", counts.all_calls}};
}

/// A point's share of the work of searches.
struct SearchWork {
    double boxes = 0, faces = 0, decisions = 0;
    double kilobytes = 0;  ///< of nodes and of faces in float

    std::array<std::pair<const char*, double>, 4> numbers() const {
        return {{{"boxes_per_point", boxes},
                 {"faces_per_point", faces},
                 {"decisions_per_point", decisions},
                 {"kilobytes_per_point", kilobytes}}};
    }
};

/// The searches of processors, of GPUs and, if it is there, of cuBQL, all without a bound to begin with.
struct SearchWorks {
    SearchWork wide_tree, binary_tree;
    std::optional<SearchWork> cubql;

    std::vector<std::pair<const char*, SearchWork>> all() const {
        std::vector<std::pair<const char*, SearchWork>> works{{"wide_tree", wide_tree}, {"binary_tree", binary_tree}};
        if (cubql) works.emplace_back("cubql", *cubql);
        return works;
    }
};

/// Processor time in nanoseconds, the least of several.
struct HostTime {
    std::uint64_t host = UINT64_MAX;     ///< of the calling thread between calls of OpenCL
    std::uint64_t process = UINT64_MAX;  ///< of the process without the driver's threads
};

struct HostTimes {
    HostTime first_call;     ///< a transform, a plan and its run into memory of the device
    HostTime set_positions;  ///< from an array of the host
    HostTime update;         ///< of a plan with a band of few voxels, and its run
    // The same of arrays in memory of the device.
    HostTime first_call_on_device, set_positions_on_device, update_on_device;
    // Both are 0 if the times of the calling thread are the host's.
    std::uint64_t other_threads = 0;    ///< the most that ran beside the calling one and the driver's
    std::uint64_t event_callbacks = 0;  ///< the most that were asked for

    std::array<std::pair<const char*, HostTime>, 6> steps() const {
        return {{{"first_call", first_call},
                 {"set_positions", set_positions},
                 {"update_and_run", update},
                 {"first_call_from_device", first_call_on_device},
                 {"set_positions_from_device", set_positions_on_device},
                 {"update_and_run_from_device", update_on_device}}};
    }
};

struct Result {
    std::string mesh;
    std::size_t triangles = 0;
    Grid grid;
    Band band;
    disguise::Counts first;
    disguise::Counts kept;
    disguise::Counts second;
    disguise::Counts patches;
    disguise::Counts points;
    disguise::Counts point_plan;
    disguise::Counts point_step;
    SearchWorks near, uniform;
    HostTimes host;

    std::array<std::pair<const char*, const disguise::Counts*>, 7> calls() const {
        return {{{"first_call", &first},
                 {"kept_transform", &kept},
                 {"second_transform", &second},
                 {"patches", &patches},
                 {"points", &points},
                 {"point_plan", &point_plan},
                 {"point_step", &point_step}}};
    }
    std::size_t patch_bytes = 0;
    TransformStatistics statistics;

    double per_band_sample(std::size_t count) const {
        return static_cast<double>(count) / static_cast<double>(statistics.work->band_samples);
    }
};

/// Boxes of 20^3 samples around vertices that are spread over the mesh, as blocks of 16^3 with ghost samples.
std::vector<Grid> patches_of(const Mesh& mesh, const Grid& grid) {
    std::vector<Grid> patches;
    for (std::size_t n = 0; n < patch_count; ++n) {
        const Vec3& vertex = mesh.vertices()[n * mesh.vertices().size() / patch_count];
        std::array<std::int64_t, 3> first{}, size{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto nearest = static_cast<std::int64_t>((vertex[axis] - grid.origin[axis]) / grid.spacing[axis]);
            size[axis] = std::min(patch_side, grid.size[axis]);
            first[axis] = std::clamp<std::int64_t>(nearest - patch_side / 2, 0, grid.size[axis] - size[axis]);
        }
        patches.push_back(grid.part(first, size));
    }
    return patches;
}

/// Beside vertices that are spread over the mesh.
std::vector<Vec3> points_near(const Mesh& mesh) {
    std::mt19937 random(7);
    std::vector<Vec3> points(point_count);
    const double most = points_within * mesh.box().longest_side();
    for (std::size_t n = 0; n < point_count; ++n) {
        points[n] = mesh.vertices()[random() % mesh.vertices().size()];
        for (double& x : points[n]) x += most * (2 * (static_cast<double>(random()) / random.max()) - 1);
    }
    return points;
}

/// In the mesh's box and its surroundings.
std::vector<Vec3> uniform_points(const Mesh& mesh) {
    std::mt19937 random(7);
    std::vector<Vec3> points(point_count);
    const double margin = points_around * mesh.box().longest_side();
    for (Vec3& point : points)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double lower = mesh.box().lower[axis] - margin, upper = mesh.box().upper[axis] + margin;
            point[axis] = lower + (upper - lower) * static_cast<double>(random()) / random.max();
        }
    return points;
}

template <class Value>
const Value* on_host(const device::BufferPool::Lease& lease) {
    return static_cast<const Value*>(lease.on_host());
}

SearchWork work_of(const test::SearchCounts& counts, double bytes_of_box, double bytes_of_face) {
    const double share = 1.0 / searched_count, boxes = static_cast<double>(counts.boxes),
                 faces = static_cast<double>(counts.faces);
    return {share * boxes, share * faces, share * static_cast<double>(counts.decisions),
            share * (boxes * bytes_of_box + faces * bytes_of_face) / 1e3};
}

/// Searches as the kernels do, in the trees that the device has.
SearchWorks search(const Device& device, const Mesh& mesh, const std::vector<Vec3>& points) {
    namespace one_lane = test::one_lane;
    device::Context& context = device::context_of(device);
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    const engine::Programs programs(context, KernelBody::by_group);
    const engine::DeviceTools tools{context, pool, programs};
    const engine::PointMesh faces_of =
        engine::make_point_mesh(tools, mesh, {}, std::make_shared<const engine::MeshTopology>(mesh));
    const auto tree = std::make_shared<const engine::WideTree>(engine::make_wide_tree(faces_of));
    const engine::WideLeaves leaves = engine::make_wide_leaves(tools, faces_of, tree);
    const device::BufferPool::Lease triangles =
        device::uploaded(context, pool, faces_of.topology->faces.triangles, "triangles");
    const device::BufferPool::Lease positions = device::uploaded(context, pool, faces_of.positions, "positions");
    const engine::FittedTree fitted = engine::fitted_tree(tools, faces_of, *positions, *triangles, nullptr);
    const one_lane::PointMesh sources{tree->nodes.data() + tree->shape.count[0], leaves.on_host(),
                                      on_host<Polyhedron>(*faces_of.polyhedra), on_host<PointFace>(*faces_of.faces)};
    const auto* const nodes = on_host<BinaryNode>(fitted.nodes);
    const auto* const faces = on_host<PlacedFace>(fitted.faces);
    SearchWorks works;
    std::vector<Vec3> searched(searched_count);
    for (std::size_t n = 0; n < searched_count; ++n) searched[n] = points[n * points.size() / searched_count];
    const auto for_each_point = [&](const auto& search_for) {
        test::search_counts = {};
        for (const Vec3& point : searched) {
            const auto& [x, y, z] = faces_of.in_units(point);
            search_for(one_lane::double3{x, y, z});
        }
        return test::search_counts;
    };
    constexpr double infinity = std::numeric_limits<double>::infinity();
    works.wide_tree =
        work_of(for_each_point([&](const one_lane::double3& p) {
                    one_lane::nearest_face(tree->shape, sources, p, infinity, CLSDF_NO_FACE);
                }),
                sizeof(PointNode) / double{CLSDF_TREE_WIDTH}, sizeof(PointLeaf) / double{CLSDF_TREE_WIDTH});
    works.binary_tree = work_of(
        for_each_point([&](const one_lane::double3& p) {
            std::array<std::uint32_t, engine::deep_stack_entries> stack;
            std::array<std::uint32_t, CLSDF_LISTED_FACES> places;
            one_lane::ListedFaces found{
                one_lane::tree_point(p), faces, one_lane::bound_of_squared(infinity), static_cast<float>(infinity), 0,
                places.data(),           1};
            one_lane::search_for_list(fitted.divided->tree, nodes, stack.data(), 1, &found);
            test::search_counts.decisions += found.count;
        }),
        sizeof(BinaryNode) / 2.0, sizeof(PlacedFace));
#ifdef CLSDF_TEST_CUBQL
    const test::CubqlWork cubql = test::search_by_cubql(mesh, searched);
    works.cubql = work_of({cubql.boxes, cubql.faces, 0}, test::bytes_of_cubql_box, test::bytes_of_cubql_face);
#endif
    return works;
}

struct ReleaseBuffer {
    void operator()(cl_mem memory) const { clReleaseMemObject(memory); }
};
using DeviceBuffer = std::unique_ptr<std::remove_pointer_t<cl_mem>, ReleaseBuffer>;

DeviceBuffer buffer(const Device& device, std::size_t bytes, const void* values = nullptr) {
    const cl_mem_flags flags = CL_MEM_READ_WRITE | (values != nullptr ? cl_mem_flags{CL_MEM_COPY_HOST_PTR} : 0);
    return DeviceBuffer(clCreateBuffer(device.context(), flags, bytes, const_cast<void*>(values), nullptr));
}

template <class Value>
DeviceBuffer copied(const Device& device, const std::vector<Value>& values) {
    return buffer(device, values.size() * sizeof(Value), values.data());
}

/// The second query of two from buffers to buffers, and the second run of a plan, without the wait for its end; and the
/// third step of a body that moves in memory of the device, with a plan of distances.
void look_up_on_device(const Device& device, DistanceTransform& transform, const Mesh& mesh,
                       const std::vector<Vec3>& points, Result& result) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const DeviceBuffer from = copied(device, points), distance = buffer(device, points.size() * sizeof(float)),
                       gradient = buffer(device, points.size() * 3 * sizeof(float));
    const InputArray positions(from.get(), ElementType::float64, points.size());
    const OutputTargets targets{{Output::distance, OutputArray(distance.get())},
                                {Output::gradient, OutputArray(gradient.get())}};
    transform.query(positions, infinity, targets);
    disguise::restart();
    transform.query(positions, infinity, targets);
    result.points = disguise::counts();
    PointPlan plan = transform.plan_points(points.size(), infinity, Output::gradient);
    cl_event first = nullptr, second = nullptr;
    plan.enqueue(nullptr, positions, targets, {}, &first);
    disguise::restart();
    plan.enqueue(nullptr, positions, targets, std::span(&first, 1), &second);
    result.point_plan = disguise::counts();
    clWaitForEvents(1, &second);
    clReleaseEvent(first);
    clReleaseEvent(second);

    const OutputTargets distances(OutputArray(distance.get()));
    PointPlan moving = transform.plan_points(points.size(), infinity);
    std::vector<Vec3> vertices = mesh.vertices();
    for (int step = 0; step < 3; ++step) {
        for (Vec3& vertex : vertices) vertex[0] += moved_by * mesh.box().longest_side();
        const DeviceBuffer moved = copied(device, vertices);
        disguise::restart();
        transform.set_positions(InputArray(moved.get(), ElementType::float64, vertices.size()));
        moving.update(transform);
        cl_event done = nullptr;
        moving.enqueue(nullptr, positions, distances, {}, &done);
        result.point_step = disguise::counts();
        clWaitForEvents(1, &done);
        clReleaseEvent(done);
    }
}

HostTimes measure_host(const Device& device, const test::Threads& of_driver, const Mesh& mesh, const Grid& grid,
                       const Band& band) {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const Grid moved_grid =
        Grid::around(mesh.box(), {.resolution = resolution, .margin = Length::in_voxels(voxels_of_moved_band)});
    const Band moved_band = Band::symmetric(voxels_of_moved_band * moved_grid.spacing[0]);
    const std::size_t samples = std::max(grid.sample_count(), moved_grid.sample_count());
    const DeviceBuffer target = buffer(device, samples * sizeof(float));
    const DeviceBuffer of_vertices = copied(device, mesh.vertices()), of_triangles = copied(device, mesh.triangles());
    const MeshView mesh_on_device(InputArray(of_vertices.get(), ElementType::float64, mesh.vertices().size()),
                                  InputArray(of_triangles.get(), ElementType::uint32, mesh.triangles().size()));
    HostTimes times;
    const auto timed = [&](HostTime& least, const auto& work) {
        const test::ThreadTimes threads(of_driver);
        disguise::restart();
        disguise::time_host();
        work();
        disguise::end_host_time();
        const disguise::Counts counts = disguise::counts();
        const auto callbacks = counts.calls.find("clSetEventCallback");
        least.host = std::min(least.host, counts.host_ns);
        least.process = std::min(least.process, threads.process_ns());
        times.other_threads = std::max<std::uint64_t>(times.other_threads, threads.other_threads());
        if (callbacks != counts.calls.end()) times.event_callbacks = std::max(times.event_callbacks, callbacks->second);
    };
    for (int round = -1; round < host_rounds; ++round) {
        if (round == 0) times = {};  // threads of oneTBB may have run on in the first round
        std::optional<DistanceTransform> transform;
        std::optional<Plan> plan;
        const auto run = [&] {
            plan->enqueue(device.queue(), target.get());
            clFinish(device.queue());
        };
        for (const bool on_device : {false, true}) {
            timed(on_device ? times.first_call_on_device : times.first_call, [&] {
                if (on_device)
                    transform.emplace(device, mesh_on_device);
                else
                    transform.emplace(device, mesh);
                plan.emplace(transform->plan(grid, band));
                run();
            });
            plan.emplace(transform->plan(moved_grid, moved_band));
            run();
            std::vector<Vec3> positions = mesh.vertices();
            for (int step = 0; step < 2; ++step) {  // the first one keeps the first positions
                for (Vec3& position : positions) position[0] += moved_by * mesh.box().longest_side();
                const DeviceBuffer moved = copied(device, positions);
                const InputArray from =
                    on_device ? InputArray(moved.get(), ElementType::float64, positions.size()) : InputArray(positions);
                timed(on_device ? times.set_positions_on_device : times.set_positions,
                      [&] { transform->set_positions(from); });
                timed(on_device ? times.update_on_device : times.update, [&] {
                    plan->update(*transform);
                    run();
                });
            }
        }
    }
    return times;
}

Result measure(const std::string& path) {
    disguise::set({.gpu = true, .compute_units = compute_units});
    const test::Threads threads_without_driver = test::all_threads();
    const Device device = Device::strongest();
    test::Threads of_driver = test::all_threads();
    for (const pid_t thread : threads_without_driver) of_driver.erase(thread);
    const Mesh mesh = read_mesh(path);
    Result result;
    result.mesh = mesh.name();
    result.triangles = mesh.triangles().size();
    result.band = Band::symmetric(band_of_longest_side * mesh.box().longest_side());
    result.grid = Grid::around(mesh, resolution, result.band);
    std::vector<float> distance(result.grid.sample_count());

    {
        disguise::restart();
        const DistanceTransform first(device, mesh);
        first.compute(result.grid, result.band, distance);
        result.first = disguise::counts();
        disguise::restart();
        first.compute(result.grid, result.band, distance);
        result.kept = disguise::counts();
    }
    if (result.kept.all_calls == 0)
        throw Error(ErrorCode::device_failure, "nothing is counted; preload the library: scripts/gpu-counts does");

    disguise::restart();
    DistanceTransform transform(device, mesh);
    transform.compute(result.grid, result.band, distance);
    result.second = disguise::counts();
    const std::vector<Grid> patches = patches_of(mesh, result.grid);
    std::vector<float> samples(patch_count * patches.front().sample_count());
    std::vector<Request> requests;
    for (std::size_t n = 0; n < patches.size(); ++n)
        requests.push_back({patches[n], result.band, samples.data() + n * patches[n].sample_count()});
    disguise::restart();
    transform.compute(requests);
    result.patches = disguise::counts();
    result.patch_bytes = samples.size() * sizeof(float);
    look_up_on_device(device, transform, mesh, points_near(mesh), result);
    result.near = search(device, mesh, points_near(mesh));
    result.uniform = search(device, mesh, uniform_points(mesh));

    result.host = measure_host(device, of_driver, mesh, result.grid, result.band);
    result.statistics = transform.compute(result.grid, result.band, distance, {.count_work = true});
    return result;
}

void print_json(const Result& result) {
    nlohmann::ordered_json json;
    json["mesh"] = result.mesh;
    json["triangles"] = result.triangles;
    json["size"] = result.grid.size;
    json["half_width"] = result.band.outside;
    json["compute_units"] = compute_units;
    json["patch_bytes"] = result.patch_bytes;
    json["point_count"] = point_count;
    for (const auto& [name, counts] : result.calls()) {
        for (const auto& [number, value] : numbers_of(*counts)) json[name][number] = value;
        for (const auto& [kernel, of_kernel] : counts->kernels)
            json[name]["kernels"][kernel] = {{"launches", of_kernel.launches}, {"work_items", of_kernel.work_items}};
    }
    for (const auto& [name, works] : {std::pair("near", result.near), std::pair("uniform", result.uniform)})
        for (const auto& [tree, work] : works.all())
            for (const auto& [number, value] : work.numbers()) json["search"][name][tree][number] = value;
    for (const auto& [step, time] : result.host.steps()) {
        json["host_ns"][step] = time.host;
        json["process_ns"][step] = time.process;
    }
    json["other_threads"] = result.host.other_threads;
    json["event_callbacks"] = result.host.event_callbacks;
    const TransformStatistics& statistics = result.statistics;
    json["band_samples"] = statistics.work->band_samples;
    json["evaluations_per_band_sample"] = result.per_band_sample(statistics.work->lanes_evaluated);
    json["covered_per_band_sample"] = result.per_band_sample(statistics.work->samples_covered);
    json["coarse_pairs"] = statistics.work->coarse_pairs;
    json["brick_pairs"] = statistics.work->brick_pairs;
    fmt::print("{}\n", json.dump(2));
}

void print_text(const Result& result) {
    fmt::print("{}: {} triangles, {} x {} x {} samples, a band of {:.0f}% of the longest side; {} compute units\n\n",
               result.mesh, result.triangles, result.grid.size[0], result.grid.size[1], result.grid.size[2],
               100 * band_of_longest_side, compute_units);
    fmt::print("{:<16}", "");
    for (const auto& [name, counts] : result.calls()) fmt::print(" {:>16}", name);
    fmt::print("\n");
    const auto rows = numbers_of(result.first);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const bool bytes = rows[i].first.find("bytes") != std::string::npos;
        fmt::print("{:<16}", rows[i].first);
        for (const auto& [name, counts] : result.calls()) {
            const std::uint64_t value = numbers_of(*counts)[i].second;
            fmt::print(" {:>16}", bytes ? fmt::format("{:.2f} MB", static_cast<double>(value) / megabyte)
                                        : fmt::format("{}", value));
        }
        fmt::print("\n");
    }
    fmt::print("\n{:<28} {:.2f}\n{:<28} {:.2f}\n", "evaluations_per_band_sample",
               result.per_band_sample(result.statistics.work->lanes_evaluated), "covered_per_band_sample",
               result.per_band_sample(result.statistics.work->samples_covered));
    fmt::print("\n{:<28}", "");
    for (const auto& [step, time] : result.host.steps()) fmt::print(" {:>16}", step);
    fmt::print("\n{:<28}", "host_ns");
    for (const auto& [step, time] : result.host.steps()) fmt::print(" {:>16}", time.host);
    fmt::print("\n{:<28}", "process_ns");
    for (const auto& [step, time] : result.host.steps()) fmt::print(" {:>16}", time.process);
    fmt::print("\n{:<28} {:>16}\n{:<28} {:>16}\n\n{:<28}", "other_threads", result.host.other_threads,
               "event_callbacks", result.host.event_callbacks, "");
    for (const char* points : {"near", "uniform"})
        for (const auto& [tree, work] : result.near.all()) fmt::print(" {:>20}", fmt::format("{} {}", points, tree));
    fmt::print("\n");
    for (std::size_t row = 0; row < SearchWork().numbers().size(); ++row) {
        fmt::print("{:<28}", SearchWork().numbers()[row].first);
        for (const SearchWorks& works : {result.near, result.uniform})
            for (const auto& [tree, work] : works.all()) fmt::print(" {:>20.1f}", work.numbers()[row].second);
        fmt::print("\n");
    }
}

}  // namespace

int main(int argument_count, char** arguments) {
    tuning::read_environment();
    const std::vector<std::string_view> words(arguments + 1, arguments + argument_count);
    const bool as_json = words.size() == 2 && words[1] == "--json";
    if (words.empty() || words.size() > 2 || (words.size() == 2 && !as_json)) {
        fmt::print(stderr, "usage: gpu_counts MESH [--json]\n");
        return 2;
    }
    try {
        const Result result = measure(std::string(words[0]));
        as_json ? print_json(result) : print_text(result);
        return 0;
    } catch (const std::exception& error) {
        fmt::print(stderr, "gpu_counts: {}\n", error.what());
        return 4;
    }
}
