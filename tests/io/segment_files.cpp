// Files of links and crossings that would contradict themselves. Those of the command: tests/apps/links.cpp.
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/io.hpp>
#include <clsdf/segments.hpp>

#include <boost/test/unit_test.hpp>

#include <array>
#include <filesystem>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

const Grid grid{.origin = {}, .spacing = {1, 1, 1}, .size = {3, 4, 5}, .first = {-1, 0, 2}};
const std::vector<LinkDirection> two_directions{{1, 0, 0}, {0, 1, 1}};

/// Two links of the grid.
Links two_links() {
    Links links;
    links.samples = {{-1, 0, 2}, {1, 3, 6}};
    links.directions = {0, 1};
    links.q = {0.25, 1};
    links.triangles = {7, 8};
    links.counts = {1, 2};
    links.flags.resize(2);
    links.inside = {grid.size, std::vector<std::uint8_t>(8)};
    return links;
}

Crossings no_crossings() {
    Crossings crossings;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        EdgeCrossings& edges = crossings.axes[axis];
        edges.size = grid.size;
        --edges.size[axis];
        const auto count = static_cast<std::size_t>(edges.size[0] * edges.size[1] * edges.size[2]);
        edges.coordinates.resize(count);
        edges.triangles.resize(count);
    }
    crossings.inside = {grid.size, std::vector<std::uint8_t>(8)};
    return crossings;
}

}  // namespace

BOOST_AUTO_TEST_CASE(links_of_another_grid_or_stencil_are_not_written) {
    const TemporaryFolder folder;
    for (const std::string ending : {".npz", ".npy", ".h5"}) {
        const std::string path = folder.file("links" + ending);
        const auto refused = [&](const Links& links, const Grid& of, const std::vector<LinkDirection>& directions,
                                 const std::string& reason) {
            check_throws(ErrorCode::invalid_argument, {path, reason},
                         [&] { write_links(links, of, directions, path); });
            BOOST_CHECK(!std::filesystem::exists(path));
        };
        refused(two_links(), grid, {two_directions[0]}, "link 1 has direction 1, and the stencil 1 directions");
        Grid moved = grid;
        moved.first[2] = 3;
        refused(two_links(), moved, two_directions, "link 0 begins at sample (-1, 0, 2), which is not in the grid");
        Grid larger = grid;
        larger.size[0] = 4;
        refused(two_links(), larger, two_directions, "`inside` has 3 x 4 x 5 samples and the grid 4 x 4 x 5");
        Links short_of_rows = two_links();
        short_of_rows.flags.pop_back();
        refused(short_of_rows, grid, two_directions, "`flags` has 1 rows and `q` 2");
        Links short_of_bits = two_links();
        short_of_bits.inside.bits.pop_back();
        refused(short_of_bits, grid, two_directions, "`inside` has 7 bytes of bits; 8 are needed");

        write_links(two_links(), grid, two_directions, path);
        BOOST_CHECK(std::filesystem::exists(path));
    }
}

BOOST_AUTO_TEST_CASE(crossings_of_another_grid_are_not_written) {
    const TemporaryFolder folder;
    for (const std::string ending : {".npz", ".h5"}) {
        const std::string path = folder.file("crossings" + ending);
        const auto refused = [&](const Crossings& crossings, const std::string& reason) {
            check_throws(ErrorCode::invalid_argument, {path, reason}, [&] { write_crossings(crossings, grid, path); });
            BOOST_CHECK(!std::filesystem::exists(path));
        };
        Crossings of_another = no_crossings();
        of_another.axes[1].size = grid.size;
        refused(of_another, "there are 3 x 4 x 5 edges along y, and the grid has 3 x 3 x 5");
        Crossings short_of_counts = no_crossings();
        short_of_counts.axes[2].counts.resize(3);
        refused(short_of_counts, "the arrays along z have 48, 48 and 3 items; each needs one for each of 48 edges");

        write_crossings(no_crossings(), grid, path);
        BOOST_CHECK(std::filesystem::exists(path));
    }
}
