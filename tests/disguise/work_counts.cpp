// What jobs ask of a device, and the memory that they take, are the numbers of work_counts.tsv, so that none of them
// grows unseen: on a GPU in disguise, and on a processor.
#include "disguise/disguise.hpp"
#include "disguise/host_memory.hpp"
#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/source_file.hpp"
#include "support/supposes.hpp"

#include <clsdf/fraction_plan.hpp>
#include <clsdf/fractions.hpp>
#include <clsdf/link_plan.hpp>
#include <clsdf/outer.hpp>
#include <clsdf/point_plan.hpp>
#include <clsdf/scene.hpp>

#include "device/context.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

bool is_gpu() {
    const char* const device = std::getenv("CLSDF_DISGUISE");
    return device != nullptr && std::string_view(device) == "gpu";
}

/// A device of as many compute units on every machine.
struct KnownDevice {
    KnownDevice() {
        constexpr unsigned units_of_gpu = 132;  // as an H100 has
        constexpr unsigned units_of_processor = 8;
        if (is_gpu())
            disguise::set({.gpu = true, .compute_units = units_of_gpu, .ends_late = true});
        else
            disguise::set(
                {.devices = {{.numbers = {{CL_DEVICE_MAX_COMPUTE_UNITS, units_of_processor}}}}, .ends_late = true});
    }
};
BOOST_TEST_GLOBAL_FIXTURE(KnownDevice);

// From `commands` to `device_peak` they are those of disguise::Counts: `waits` with those for pinned reads, and with
// all that Settings::ends_late makes; device_peak in bytes. device_bytes: what the call says that it used; 0 if it says
// nothing. host_arrays and host_peak: those of HostMemory, without the caller's arrays.
constexpr std::array quantities{"commands",     "launches",    "bytes_up",        "bytes_down",
                                "waits",        "allocations", "allocated_bytes", "device_peak",
                                "device_bytes", "host_arrays", "host_peak"};
using Numbers = std::array<std::uint64_t, quantities.size()>;

struct Row {
    std::string step;
    Numbers numbers{};
};

/// Counts the steps of a job.
class Job {
public:
    /// step() returns TransformStatistics::device_bytes, or nothing. What the device does when it has returned does not
    /// count.
    template <class Step>
    void count(const std::string& name, const Step& step) {
        const cl::CommandQueue& queue = device::context_of(test_device()).queue();
        queue.finish();
        disguise::restart();
        count_host_memory();
        std::size_t device_bytes = 0;
        if constexpr (std::is_void_v<decltype(step())>)
            step();
        else
            device_bytes = step();
        const HostMemory host = end_counting_memory();
        const disguise::Counts counts = disguise::counts();
        queue.finish();
        programs_built_ += counts.programs_built;
        rows_.push_back({name,
                         {counts.commands, counts.launches, counts.bytes_up, counts.bytes_down,
                          counts.blocking_waits + counts.pinned_reads, counts.allocations, counts.allocated_bytes,
                          counts.peak_bytes, device_bytes, host.arrays, host.peak_bytes}});
    }

    bool has_built_programs() const { return programs_built_ > 0; }
    const std::vector<Row>& rows() const { return rows_; }

private:
    std::vector<Row> rows_;
    std::uint64_t programs_built_ = 0;
};

constexpr double infinity = std::numeric_limits<double>::infinity();

template <class Value>
cl::Buffer on_device(const std::vector<Value>& values) {
    return {cl::Context(test_device().context(), true), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR,
            values.size() * sizeof(Value), const_cast<Value*>(values.data())};  // which is only read
}

/// The grid and the band of a job of docs/benchmarks.md.
void compute_field(Job& job, const std::string& name, const Mesh& mesh, std::int64_t resolution,
                   const Length& half_width) {
    test_device().release_memory();
    const Length margin = half_width.is_infinite() ? Length::of_extent(0.05) : half_width;
    const Grid grid = Grid::around(mesh.box(), {.resolution = resolution, .margin = margin, .cubic = true});
    const Band band = Band::symmetric(half_width.resolve(grid.voxel(), mesh.box().longest_side()));
    std::vector<float> distance(grid.sample_count());
    std::optional<DistanceTransform> transform;
    job.count(name + ", first", [&] {
        transform.emplace(test_device(), mesh);
        return transform->compute(grid, band, distance).device_bytes;
    });
    job.count(name + ", again", [&] { return transform->compute(grid, band, distance).device_bytes; });
}

/// Beside vertices of the mesh.
std::vector<Vec3> points_near(const Mesh& mesh, std::size_t count) {
    std::mt19937 random(7);
    std::vector<Vec3> points(count);
    const double most = 0.012 * mesh.box().longest_side();
    for (Vec3& point : points) {
        point = mesh.vertices()[random() % mesh.vertices().size()];
        for (double& x : point) x += most * (2 * (static_cast<double>(random()) / std::mt19937::max()) - 1);
    }
    return points;
}

void look_up_points(Job& job, const Mesh& mesh, std::size_t count) {
    test_device().release_memory();
    const std::vector<Vec3> points = points_near(mesh, count);
    std::vector<float> distance(count);
    std::optional<DistanceTransform> transform;
    job.count("points, first", [&] {
        transform.emplace(test_device(), mesh);
        return transform->query(points, infinity, distance).device_bytes;
    });
    job.count("points, again", [&] { return transform->query(points, infinity, distance).device_bytes; });
    std::optional<PointPlan> plan;
    job.count("points, plan", [&] {
        plan.emplace(transform->plan_points(count, infinity));
        return plan->statistics().device_bytes;
    });
    const cl::Buffer from = on_device(points), to = on_device(distance);
    job.count("points, a run of the plan", [&] {
        plan->enqueue(nullptr, InputArray(from(), ElementType::float64, count), OutputTargets(OutputArray(to())));
    });
}

void find_links(Job& job, const Mesh& mesh, std::int64_t resolution) {
    test_device().release_memory();
    const Grid grid = Grid::around(mesh.box(), {.resolution = resolution});
    const std::vector<LinkDirection> directions = stencil("D3Q19");
    std::optional<DistanceTransform> transform;
    Links links;
    job.count("links, first", [&] {
        transform.emplace(test_device(), mesh);
        links = transform->links(grid, directions);
    });
    job.count("links, again", [&] { links = transform->links(grid, directions); });
    std::optional<LinkPlan> plan;
    job.count("links, plan", [&] {
        plan.emplace(transform->plan_links(grid, directions, links.size()));
        return plan->statistics().device_bytes;
    });
    const cl::Buffer q = on_device(links.q);
    LinkTargets targets;
    targets.room = links.size();
    targets.q = OutputArray(q());
    targets.q.type = ElementType::float64;
    job.count("links, a run of the plan", [&] { plan->enqueue(nullptr, targets, {}); });
}

/// In cells of a cubic lattice, turned about z.
std::vector<Pose> poses_of(std::int64_t cells, std::mt19937::result_type seed) {
    std::mt19937 random(seed);
    const auto part = [&] { return static_cast<double>(random()) / std::mt19937::max(); };
    std::vector<Pose> poses;
    for (std::int64_t z = 0; z < cells; ++z)
        for (std::int64_t y = 0; y < cells; ++y)
            for (std::int64_t x = 0; x < cells; ++x) {
                const double s = part(), c = std::sqrt(1 - s * s);
                poses.push_back(
                    {.rotation = {{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}},
                     .translation = {static_cast<double>(x) + 0.04 * part(), static_cast<double>(y) + 0.04 * part(),
                                     static_cast<double>(z) + 0.04 * part()}});
            }
    return poses;
}

void compute_scene(Job& job, std::int64_t cells, std::int64_t resolution) {
    test_device().release_memory();
    const Mesh mesh = scaled(make_shape("sphere3"), 0.35);
    const std::vector<Pose> poses = poses_of(cells, 0), moved = poses_of(cells, 1);
    const double spacing = static_cast<double>(cells) / static_cast<double>(resolution);
    const Grid grid{{-0.5, -0.5, -0.5}, {spacing, spacing, spacing}, {resolution, resolution, resolution}, {}};
    const Band band = Band::symmetric(3 * spacing);
    std::vector<float> distance(grid.sample_count());
    std::optional<Scene> scene;
    job.count("scene, made", [&] {
        scene.emplace(test_device());
        scene->add(mesh, poses[0]);
        for (std::size_t body = 1; body < poses.size(); ++body) scene->add_instance(0, poses[body]);
    });
    job.count("scene, a field of new poses", [&] {
        scene->set_poses(moved);
        return scene->compute(grid, band, distance).device_bytes;
    });
    std::vector<Vec3> points;
    for (const Pose& pose : moved)
        for (const double aside : {0.1, 0.4})
            points.push_back({pose.translation[0] + aside, pose.translation[1], pose.translation[2]});
    std::vector<float> at_points(points.size());
    job.count("scene, points", [&] { return scene->query(points, infinity, {.outputs = at_points}).device_bytes; });
}

void cut_cells(Job& job, const Mesh& mesh, std::int64_t cells) {
    test_device().release_memory();
    const Grid grid = Grid::around(mesh.box(), {.resolution = cells + 1});
    Fractions found;
    job.count("fractions", [&] { found = fractions(mesh, grid); });
    const OuterSurface surface = outer(mesh);
    std::optional<FractionPlan> plan;
    job.count("fractions, plan", [&] {
        plan.emplace(test_device(), surface, grid, found.cells.size());
        return plan->statistics().device_bytes;
    });
    const cl::Buffer volume = on_device(std::vector<double>(found.cells.size()));
    FractionRows rows;
    rows.room = found.cells.size();
    rows.volume = {volume(), ElementType::float64};
    job.count("fractions, a run of the plan", [&] { plan->enqueue(nullptr, rows, {}); });
}

/// W2 to W4 have a half or a quarter of the samples a side of docs/benchmarks.md, and W4 has the sphere split once: a
/// GPU in disguise is slow.
Job all_jobs(bool is_small) {
    const Mesh mesh = make_shape("sphere6");
    const auto side = [&](std::int64_t samples) { return is_small ? 16 : samples; };
    Job job;
    compute_field(job, "W1", mesh, side(256), Length::of_extent(0.1));
    compute_field(job, "W2 of 256^3", mesh, side(256), Length::in_voxels(3));
    compute_field(job, "W3 of 64^3", mesh, side(64), Length::infinite());
    compute_field(job, "W4 of 32^3", is_small ? mesh : make_shape("sphere7"), side(32), Length::infinite());
    look_up_points(job, mesh, is_small ? mesh.triangles().size() : 1'000'000);
    find_links(job, mesh, side(128));
    compute_scene(job, is_small ? 1 : 10, side(100));
    cut_cells(job, mesh, side(128));
    return job;
}

/// They would take minutes, and the counts are the same.
boost::test_tools::assertion_result without_sanitizers(boost::unit_test::test_unit_id) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    constexpr bool is_quick = false;
#else
    constexpr bool is_quick = true;
#endif
    return supposed(is_quick, "a program without sanitizers");
}

/// The last numbers, of both devices.
class Table {
public:
    explicit Table(std::string path) : path_(std::move(path)) {
        std::ifstream file(path_);
        std::string line;
        std::getline(file, line);
        while (std::getline(file, line)) {
            std::istringstream fields(line);
            Row row;
            std::string device;
            std::getline(fields, device, '\t');
            std::getline(fields, row.step, '\t');
            for (std::uint64_t& number : row.numbers) fields >> number;
            rows_[device].push_back(std::move(row));
        }
    }

    const std::vector<Row>& rows(const std::string& device) { return rows_[device]; }

    void write(const std::string& device, const std::vector<Row>& rows) {
        rows_[device] = rows;
        std::string text = "device\tstep";
        for (const char* quantity : quantities) text += fmt::format("\t{}", quantity);
        for (const auto& [name, all] : rows_)
            for (const Row& row : all) {
                text += fmt::format("\n{}\t{}", name, row.step);
                for (const std::uint64_t number : row.numbers) text += fmt::format("\t{}", number);
            }
        std::ofstream(path_) << text << '\n';
    }

private:
    std::string path_;
    std::map<std::string, std::vector<Row>> rows_;
};

/// The standard library's small blocks differ between its versions, by less than this.
bool is_same_host_memory(std::uint64_t last, std::uint64_t now) {
    constexpr std::uint64_t least = 4096;
    return std::max(last, now) - std::min(last, now) <= std::max(least, last / 200);
}

/// What differs, in words.
std::vector<std::string> differences(const std::vector<Row>& last, const std::vector<Row>& now) {
    std::vector<std::string> found;
    for (const Row& row : now) {
        const auto before = std::ranges::find(last, row.step, &Row::step);
        if (before == last.end()) {
            found.push_back(fmt::format("{}: a new step", row.step));
            continue;
        }
        for (std::size_t n = 0; n < quantities.size(); ++n) {
            const std::uint64_t old = before->numbers[n], number = row.numbers[n];
            const bool is_host_memory = std::string_view(quantities[n]) == "host_peak";
            if (is_host_memory ? is_same_host_memory(old, number) : old == number) continue;
            found.push_back(fmt::format("{}: {} {} from {} to {}", row.step, quantities[n],
                                        number > old ? "grew" : "fell", old, number));
        }
    }
    for (const Row& row : last)
        if (std::ranges::find(now, row.step, &Row::step) == now.end())
            found.push_back(fmt::format("{}: no step any more", row.step));
    return found;
}

}  // namespace

BOOST_AUTO_TEST_CASE(no_number_grows_unseen, *boost::unit_test::precondition(without_sanitizers)) {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    all_jobs(true);  // programs are compiled
    const Job job = all_jobs(false);
    BOOST_REQUIRE(disguise::counts().all_calls > 0U);  // else the library is not between this program and the loader
    BOOST_TEST(!job.has_built_programs());

    const std::string device = is_gpu() ? "gpu" : "processor";
    Table table(source_file("tests/disguise/work_counts.tsv"));
    if (std::getenv("CLSDF_WRITE_COUNTS") != nullptr) return table.write(device, job.rows());
    const std::vector<std::string> found = differences(table.rows(device), job.rows());
    BOOST_TEST(
        found.empty(),
        fmt::format("{}: these are not the last numbers, those of tests/disguise/work_counts.tsv:\n    {}\nIf they "
                    "may grow, or have fallen, write them: CLSDF_WRITE_COUNTS=1 ctest --preset release -R "
                    "'^disguise_work_counts'",
                    device, fmt::join(found, "\n    ")));
}
