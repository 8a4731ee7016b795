#include "apps/process.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/mesh_files.hpp>
#include <clsdf/part_files.hpp>

#include <boost/test/unit_test.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
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
