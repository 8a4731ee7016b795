#include "apps/process.hpp"
#include "apps/scratch_folder.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/mesh_files.hpp>
#include <clsdf/part_files.hpp>

#include <boost/test/unit_test.hpp>

#include <nlohmann/json.hpp>

#include <sys/resource.h>
#include <algorithm>
#include <csignal>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

Index3 triple_of(const nlohmann::json& numbers) {
    return {numbers.at(0), numbers.at(1), numbers.at(2)};
}

/// The samples from `begin` to `end` of a grid, and one around them.
Grid with_ghosts(const Grid& grid, const Index3& begin, const Index3& end) {
    Grid block = grid;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        block.first[axis] = grid.first[axis] + begin[axis] - 1;
        block.size[axis] = end[axis] - begin[axis] + 2;
    }
    return block;
}

}  // namespace

// What a rank computes of its part is what it would compute of the mesh.
BOOST_AUTO_TEST_CASE(each_part_gives_the_bytes_of_its_block) {
    const TemporaryFolder folder;
    const std::string path = folder.file("knot.ply"), parts = folder.file("parts.h5");
    const Mesh mesh = make_shape("knot");
    write_mesh(mesh, path);
    const Outcome outcome = run_command({"part", path, "-o", parts, "--cuts", "2,1,3", "--resolution", "40", "--band",
                                         "3v", "--ghosts", "1", "--json"});
    BOOST_REQUIRE_MESSAGE(outcome.status == 0, outcome.error);
    const nlohmann::json report = nlohmann::json::parse(outcome.out);
    BOOST_REQUIRE(count_parts(parts) == 6U);
    BOOST_REQUIRE(report.at("parts").size() == 6U);

    const Device device = Device::automatic();
    const DistanceTransform whole(device, mesh);
    GridOptions options;
    options.resolution = 40;
    options.margin = Length::in_voxels(3);
    const Grid grid = Grid::around(mesh.box(), options);
    const Band band = Band::symmetric(3 * grid.voxel());
    const Grid all = with_ghosts(grid, {0, 0, 0}, grid.size);
    const Field expected = whole.compute(all, band);
    std::vector<int> times(grid.sample_count());
    for (std::int64_t z = 0; z < 3; ++z)
        for (std::int64_t x = 0; x < 2; ++x) {
            const auto number = static_cast<std::size_t>(x + 2 * z);
            const Index3 begin{grid.size[0] * x / 2, 0, grid.size[2] * z / 3},
                end{grid.size[0] * (x + 1) / 2, grid.size[1], grid.size[2] * (z + 1) / 3};
            const Grid block = with_ghosts(grid, begin, end);
            BOOST_TEST((triple_of(report["parts"][number]["grid"]["size"]) == block.size));
            const Field found = DistanceTransform::from_part(device, read_part(parts, number)).compute(block, band);
            for (std::int64_t k = 0; k < block.size[2]; ++k)
                for (std::int64_t j = 0; j < block.size[1]; ++j) {
                    const auto of_block = found.distance().subspan(block.offset(0, j, k),
                                                                   static_cast<std::size_t>(block.size[0])),
                               of_all = expected.distance().subspan(all.offset(begin[0], begin[1] + j, begin[2] + k),
                                                                    static_cast<std::size_t>(block.size[0]));
                    BOOST_REQUIRE(std::ranges::equal(of_block, of_all));
                }
            for (std::int64_t k = begin[2]; k < end[2]; ++k)
                for (std::int64_t j = begin[1]; j < end[1]; ++j)
                    for (std::int64_t i = begin[0]; i < end[0]; ++i) ++times[grid.offset(i, j, k)];
        }
    BOOST_TEST(std::ranges::count(times, 1) == static_cast<std::ptrdiff_t>(times.size()));
}

BOOST_AUTO_TEST_CASE(parts_that_cannot_be_made_are_refused_without_a_file) {
    const TemporaryFolder folder;
    const std::string path = folder.file("cube.off"), parts = folder.file("parts.h5");
    write_mesh(make_shape("cube"), path);
    const auto fails = [&](const std::vector<std::string>& more, const std::string& words) {
        std::vector<std::string> arguments{"part", path, "-o", parts};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Outcome outcome = run_command(arguments);
        BOOST_TEST(outcome.status == 2);
        BOOST_TEST(outcome.error.find(words) != std::string::npos, outcome.error);
        BOOST_TEST(!std::filesystem::exists(parts));
    };
    fails({"--cuts", "0,1,1"}, "--cuts: 0 blocks along x");
    fails({"--cuts", "1,1,99", "--resolution", "32"}, "--cuts: 99 blocks along z");
    fails({"--cuts", "2", "--band", "full"}, "--band");
    fails({"--cuts", "two"}, "--cuts");
}

BOOST_AUTO_TEST_CASE(parts_of_a_mesh_that_moves_take_positions) {
    const TemporaryFolder folder;
    const std::string path = folder.file("knot.ply"), parts = folder.file("parts.h5");
    const Mesh mesh = make_shape("knot");
    write_mesh(mesh, path);
    const Outcome outcome = run_command(
        {"part", path, "-o", parts, "--cuts", "2", "--resolution", "40", "--band", "3v", "--moves", "1v", "--json"});
    BOOST_REQUIRE_MESSAGE(outcome.status == 0, outcome.error);
    const nlohmann::json report = nlohmann::json::parse(outcome.out);
    const double margin = report.at("margin");
    BOOST_TEST(margin > 0);
    DistanceTransform part = DistanceTransform::from_part(Device::automatic(), read_part(parts, 1));
    std::vector<Vec3> positions;
    for (const std::uint32_t vertex : part.part_vertices()) {
        positions.push_back(mesh.vertices()[vertex]);
        positions.back()[2] += 0.99 * margin;
    }
    part.set_positions(positions);
    BOOST_TEST(part.box().upper[2] == mesh.box().upper[2] + 0.99 * margin);
}

BOOST_AUTO_TEST_CASE(parts_made_with_little_memory_have_the_same_bytes_and_leave_no_scratch) {
    const TemporaryFolder folder;
    const ScratchFolder scratch("scratch-of-parts");
    const std::string path = folder.file("sphere.stl"), parts = folder.file("parts.h5"),
                      others = folder.file("others.h5");
    write_mesh(make_shape("sphere7"), path);
    const auto make = [&](const std::string& output, const std::vector<std::string>& more) {
        std::vector<std::string> arguments{"part",  path,           "-o",  output,   "--cuts",
                                           "1,2,2", "--resolution", "128", "--band", "3v"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return arguments;
    };
    const Outcome whole = run_command(make(parts, {}));
    BOOST_REQUIRE_MESSAGE(whole.status == 0, whole.error);
    const std::vector<std::string> little{"--memory", "400MB", "--scratch", scratch.path};
    std::vector<std::string> with_report = make(others, little);
    with_report.emplace_back("--json");
    const Outcome outcome = run_command(with_report);
    BOOST_REQUIRE_MESSAGE(outcome.status == 0, outcome.error);
    BOOST_TEST((content_of(parts) == content_of(others)));
    BOOST_TEST(scratch.is_empty());
    const nlohmann::json memory = nlohmann::json::parse(outcome.out).at("memory");
    if (has_scratch) {
        BOOST_TEST(memory.at("resident_bytes").get<double>() < 420e6);
        BOOST_TEST(memory.at("scratch_bytes").get<double>() > 10e6);
    }

    std::filesystem::remove(others);
    for (const int signal : {SIGINT, SIGKILL}) {
        Process process(make(others, little), {}, {}, [] { std::signal(SIGINT, SIG_DFL); });
        process.wait_until([&] { return process.cpu_seconds_so_far() > 0.2; });
        BOOST_TEST(scratch.is_empty());  // its files have no names
        process.send(signal);
        BOOST_TEST(process.wait().status == (signal == SIGKILL ? -SIGKILL : 6));
        BOOST_TEST(scratch.is_empty());
        BOOST_TEST(!std::filesystem::exists(others));
    }

    const auto limited = [] {
        std::signal(SIGXFSZ, SIG_DFL);
        const rlimit limit{1 << 20, 1 << 20};
        ::setrlimit(RLIMIT_FSIZE, &limit);
    };
    Process full(make(others, little), {}, {}, limited);
    if (has_scratch)
        check_refused(full.wait(), 5, {scratch.path, "has no room for", "--scratch"});
    else
        full.wait();
    BOOST_TEST(scratch.is_empty());
    check_refused(run_command(make(others, {"--memory", "64M"})), 2, {"--memory: 64M is too little", "give"});
    check_refused(run_command(make(others, {"--memory", "2Gb"})), 2, {"--memory", "2GiB, not '2Gb'"});
    check_refused(run_command(make(others, {"--memory", "1G", "--scratch", "/nonexistent"})), 2,
                  {"'/nonexistent'", "No such file", "--scratch"});
    check_refused(run_command(make(others, {"--scratch", scratch.path})), 2, {"--memory"});
}

BOOST_AUTO_TEST_CASE(boxes_of_a_file_are_those_of_the_parts) {
    const TemporaryFolder folder;
    const std::string path = folder.file("knot.ply"), parts = folder.file("parts.h5");
    write_mesh(make_shape("knot"), path);
    const auto boxes = [&](const std::string& text) {
        return run_command({"part", path, "-o", parts, "--boxes", folder.file("boxes.txt", text), "--spacing", "0.1",
                            "--band", "0.3"});
    };
    const Outcome outcome = boxes("# two ranks\n-3,-3,-1, 0,3,1\n\n  0 -3 -1\t3 3 1\r\n");
    BOOST_REQUIRE_MESSAGE(outcome.status == 0, outcome.error);
    const DistanceTransform whole(Device::automatic(), read_mesh(path));
    BOOST_REQUIRE(count_parts(parts) == 2U);
    for (const std::size_t part : {0U, 1U}) {
        const double x = part == 0 ? -3 : 0;
        BOOST_TEST(
            (read_part(parts, part) == whole.restrict_to({{{x, -3, -1}, {x + 3, 3, 1}}, 0.3, 0.1}).part_bytes()));
    }
    check_refused(boxes("0 0 0 1 1 1\n0 0 0 1 1\n"), 3, {"boxes.txt:2", "six numbers"});
    check_refused(boxes("# none\n"), 3, {"boxes.txt", "there is no box"});
    check_refused(run_command({"part", path, "-o", parts}), 2, {"--cuts", "--boxes"});
}
