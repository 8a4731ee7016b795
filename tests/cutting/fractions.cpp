// Fractions of cells: boxes against closed forms, sums against the mesh, cells against their parts.

#include "core/vectors.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/throws.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/fractions.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <vector>

namespace clsdf {

using namespace test;

namespace {

/// The fraction of each cell, by its indices on the lattice.
std::map<Index3, double> volumes(const Fractions& found) {
    std::map<Index3, double> all;
    const auto [nx, ny, nz] = found.counts();
    for (std::size_t k = 0; k < nz; ++k)
        for (std::size_t j = 0; j < ny; ++j)
            for (std::size_t i = 0; i < nx; ++i)
                all[{found.grid.first[0] + std::int64_t(i), found.grid.first[1] + std::int64_t(j),
                     found.grid.first[2] + std::int64_t(k)}] = found.is_full(i, j, k) ? 1 : 0;
    for (const CellFraction& cell : found.cells) all[{cell.cell[0], cell.cell[1], cell.cell[2]}] = cell.volume;
    return all;
}

double cell_volume(const Grid& grid) {
    return grid.spacing[0] * grid.spacing[1] * grid.spacing[2];
}

/// The part of a cell's side that a range covers.
double covered(double low, double high, double from, double to) {
    return std::max(0.0, std::min(high, to) - std::max(low, from)) / (high - low);
}

void check_sums(const Mesh& mesh, const Grid& grid, const OuterSurface& surface) {
    const Fractions found = fractions(mesh, grid);
    double volume = 0, area = 0;
    Vec3 vector_area{};
    for (const auto& [cell, fraction] : volumes(found)) volume += fraction * cell_volume(grid);
    for (const CellFraction& cell : found.cells) {
        area += cell.area;
        BOOST_TEST(cell.volume >= -1e-12);
        BOOST_TEST(cell.volume <= 1 + 1e-12);
        BOOST_TEST(cell.pieces >= 1U);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            vector_area[axis] += cell.vector_area[axis];
            const double side = grid.spacing[(axis + 1) % 3] * grid.spacing[(axis + 2) % 3];
            const double between = cell.face_fractions[2 * axis + 1] - cell.face_fractions[2 * axis];
            BOOST_TEST(std::abs(between + cell.vector_area[axis] / side) < 1e-12);
            BOOST_TEST(std::abs(cell.centroid[axis]) <= 0.5);
        }
    }
    BOOST_TEST(std::abs(volume - surface.volume) <= 1e-12 * surface.volume, mesh.name());
    BOOST_TEST(std::abs(area - surface.area) <= 1e-12 * surface.area, mesh.name());
    for (const double sum : vector_area) BOOST_TEST(std::abs(sum) <= 1e-12 * surface.area);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_box_has_closed_forms) {
    constexpr std::uint64_t seed = 11;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    for (int trial = 0; trial < 40; ++trial) {
        Grid grid{random.point(-1, 0),
                  {random.uniform(0.1, 0.4), random.uniform(0.1, 0.4), random.uniform(0.1, 0.4)},
                  {9, 8, 7}};
        grid.first = {random.index(3), -1, 2};
        Box box;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double start = grid.origin[axis] + grid.spacing[axis] * static_cast<double>(grid.first[axis]);
            // Also beyond the grid.
            const double a = start + grid.spacing[axis] * random.uniform(-2, 9),
                         b = start + grid.spacing[axis] * random.uniform(-2, 9);
            box.lower[axis] = std::min(a, b);
            box.upper[axis] = std::max(a, b);
        }
        const Fractions found = fractions(test::box(box.lower, box.upper), grid);
        const auto side = [&](std::int64_t cell, std::size_t axis) {
            const double low = grid.origin[axis] + grid.spacing[axis] * static_cast<double>(cell);
            return covered(low, low + grid.spacing[axis], box.lower[axis], box.upper[axis]);
        };
        for (const auto& [cell, fraction] : volumes(found))
            BOOST_TEST(std::abs(fraction - side(cell[0], 0) * side(cell[1], 1) * side(cell[2], 2)) < 1e-13);
        for (const CellFraction& cell : found.cells)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double low = grid.origin[axis] + grid.spacing[axis] * cell.cell[axis],
                             high = low + grid.spacing[axis];
                const double from = std::max(low, box.lower[axis]), to = std::min(high, box.upper[axis]);
                if (cell.volume < 1e-3) continue;
                BOOST_TEST(std::abs(cell.centroid[axis] - ((from + to) / 2 - (low + high) / 2) / grid.spacing[axis]) <
                           1e-10);
                const double section =
                    side(cell.cell[(axis + 1) % 3], (axis + 1) % 3) * side(cell.cell[(axis + 2) % 3], (axis + 2) % 3);
                const auto is_in = [&](double x) { return x > box.lower[axis] && x < box.upper[axis]; };
                BOOST_TEST(std::abs(cell.face_fractions[2 * axis] - (is_in(low) ? section : 0)) < 1e-12);
                BOOST_TEST(std::abs(cell.face_fractions[2 * axis + 1] - (is_in(high) ? section : 0)) < 1e-12);
                for (const std::size_t face : {2 * axis, 2 * axis + 1}) {
                    if (cell.face_fractions[face] < 1e-3) continue;
                    const std::array<std::size_t, 2> others{axis == 0 ? std::size_t{1} : 0,
                                                            axis == 2 ? std::size_t{1} : 2};
                    for (std::size_t n = 0; n < 2; ++n)
                        BOOST_TEST(std::abs(cell.face_centroids[face][n] - cell.centroid[others[n]]) < 1e-9);
                }
            }
    }
}

BOOST_AUTO_TEST_CASE(a_box_in_the_planes_between_cells) {
    const Grid grid{{0, 0, 0}, {1, 1, 1}, {5, 5, 5}};
    const Fractions found = fractions(test::box({1, 1, 1}, {2, 2, 2}), grid);
    for (const auto& [cell, fraction] : volumes(found)) BOOST_TEST(fraction == (cell == Index3{1, 1, 1} ? 1 : 0));
    // Each piece of the surface belongs to the cell above it.
    double area = 0;
    for (const CellFraction& cell : found.cells) {
        area += cell.area;
        if (cell.cell == std::array{1, 1, 1}) BOOST_TEST(cell.area == 3);
    }
    BOOST_TEST(area == 6);
}

BOOST_AUTO_TEST_CASE(sums_are_those_of_the_mesh) {
    for (const char* const name : {"sphere3", "knot", "stairs"}) {
        const Mesh mesh = make_shape(name);
        check_sums(mesh, Grid::around(mesh.box(), {.resolution = 24}), outer(mesh));
    }
    // Unequal spacings; parts that overlap, so that no cell has more than 1.
    const Mesh two =
        together({test::box({0, 0, 0}, {1, 1, 1}), test::box({0.3, 0.4, 0.5}, {1.5, 1.6, 1.7})}, "two boxes");
    check_sums(two, Grid{{-0.1, -0.2, -0.03}, {0.1, 0.7, 0.011}, {19, 5, 180}}, outer(two));
}

BOOST_AUTO_TEST_CASE(tetrahedra_with_whole_coordinates) {
    constexpr std::uint64_t seed = 5;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    const Grid grid{{0, 0, 0}, {1, 1, 1}, {9, 9, 9}};
    for (int trial = 0; trial < 500; ++trial) {
        std::vector<Vec3> vertices(4);
        for (Vec3& vertex : vertices)
            for (double& x : vertex) x = random.index(9);
        const Vec3 a = difference(vertices[1], vertices[0]), b = difference(vertices[2], vertices[0]),
                   c = difference(vertices[3], vertices[0]);
        const double volume = dot(cross(a, b), c) / 6;
        if (volume == 0) continue;
        std::vector<Triangle> faces{{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}};
        if (volume < 0)
            for (Triangle& face : faces) std::swap(face[0], face[1]);
        const Mesh mesh(vertices, faces);
        const Fractions found = fractions(mesh, grid);
        double sum = 0;
        for (const auto& [cell, fraction] : volumes(found)) {
            BOOST_TEST(fraction > -1e-13);
            BOOST_TEST(fraction < 1 + 1e-13);
            sum += fraction;
        }
        BOOST_TEST(std::abs(sum - std::abs(volume)) < 1e-12);
        // Eight halves of a cell are the cell.
        if (trial % 10 != 0) continue;
        const std::map<Index3, double> whole = volumes(found), halves = volumes(fractions(mesh, grid.refined(2)));
        for (const auto& [cell, fraction] : whole) {
            double of_halves = 0;
            for (int n = 0; n < 8; ++n)
                of_halves += halves.at({2 * cell[0] + (n & 1), 2 * cell[1] + (n >> 1 & 1), 2 * cell[2] + (n >> 2)}) / 8;
            BOOST_TEST(std::abs(of_halves - fraction) < 1e-12);
        }
    }
}

BOOST_AUTO_TEST_CASE(parts_of_a_grid_have_the_bytes_of_the_whole) {
    const Mesh mesh = make_shape("knot");
    const Grid grid = Grid::around(mesh.box(), {.resolution = 30});
    const Fractions whole = fractions(mesh, grid);
    const Grid part = grid.part({7, 5, 2}, {12, 15, 8});
    const Fractions found = fractions(mesh, part);
    std::size_t next = 0;
    for (const CellFraction& cell : whole.cells) {
        bool is_in = true;
        for (std::size_t axis = 0; axis < 3; ++axis)
            is_in = is_in && cell.cell[axis] >= part.first[axis] &&
                    cell.cell[axis] < part.first[axis] + part.size[axis] - 1;
        if (!is_in) continue;
        BOOST_REQUIRE(next < found.cells.size());
        const CellFraction& other = found.cells[next++];
        BOOST_TEST((cell.cell == other.cell && cell.pieces == other.pieces && cell.volume == other.volume &&
                    cell.centroid == other.centroid && cell.area == other.area &&
                    cell.vector_area == other.vector_area && cell.surface_centroid == other.surface_centroid &&
                    cell.face_fractions == other.face_fractions && cell.face_centroids == other.face_centroids));
    }
    BOOST_TEST(next == found.cells.size());
    const auto [nx, ny, nz] = found.counts();
    for (std::size_t k = 0; k < nz; ++k)
        for (std::size_t j = 0; j < ny; ++j)
            for (std::size_t i = 0; i < nx; ++i)
                BOOST_TEST(found.is_full(i, j, k) == whole.is_full(i + 7, j + 5, k + 2));
}

BOOST_AUTO_TEST_CASE(two_walls_of_a_wedge_are_two_pieces) {
    // Its ridge is far beyond the middle cell, which both sides cross.
    const Mesh wedge({{-4, -0.2, -1}, {-4, 0.2, -1}, {4, 0, -1}, {-4, -0.2, 2}, {-4, 0.2, 2}, {4, 0, 2}},
                     {{0, 1, 2}, {3, 5, 4}, {0, 2, 5}, {0, 5, 3}, {2, 1, 4}, {2, 4, 5}, {1, 0, 3}, {1, 3, 4}}, "wedge");
    const Fractions found = fractions(wedge, Grid{{-0.5, -0.5, 0}, {1, 1, 1}, {2, 2, 2}});
    BOOST_REQUIRE(found.cells.size() == 1U);
    BOOST_TEST(found.cells[0].pieces == 2U);
    BOOST_TEST(std::abs(found.cells[0].volume - 0.2) < 1e-12);
}

BOOST_AUTO_TEST_CASE(a_grid_without_cells_is_refused) {
    const Mesh box = test::box({0, 0, 0}, {1, 1, 1});
    check_throws(ErrorCode::invalid_argument, {"1 sample along y"}, [&] {
        fractions(box, Grid{{0, 0, 0}, {1, 1, 1}, {3, 1, 3}});
    });
    const Mesh open(box.vertices(), {{0, 2, 3}}, "open");
    check_throws(ErrorCode::unsupported, {"outer surface"}, [&] {
        fractions(open, Grid{{0, 0, 0}, {1, 1, 1}, {3, 3, 3}});
    });
}

}  // namespace clsdf
