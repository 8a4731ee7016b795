// Fractions of cells: boxes against closed forms, sums against the mesh, cells against their parts.

#include "core/vectors.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/supposes.hpp"
#include "support/throws.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/fractions.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <span>
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

/// The same cells, but for their numbers.
void check_same_cells(const Fractions& known, const Fractions& found) {
    BOOST_TEST(!known.cells.empty());
    BOOST_TEST((found.full == known.full));
    BOOST_REQUIRE(found.cells.size() == known.cells.size());
    std::size_t wrong = 0;
    for (std::size_t n = 0; n < known.cells.size(); ++n) {
        CellFraction cell = found.cells[n];
        for (std::size_t axis = 0; axis < 3; ++axis)
            cell.cell[axis] += static_cast<std::int32_t>(known.grid.first[axis] - found.grid.first[axis]);
        wrong += std::memcmp(&cell, &known.cells[n], sizeof cell) != 0 ? 1U : 0U;
    }
    BOOST_TEST(wrong == 0U);
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

BOOST_AUTO_TEST_CASE(a_box_in_the_planes_between_cells_by_convention) {
    const Mesh box = test::box({1, 2, 3}, {2, 3, 4});
    const Grid grid{{0, 0, 0}, {1, 1, 1}, {6, 6, 6}};
    const Index3 own{1, 2, 3};
    const auto by_cell = [](const Fractions& found) {
        std::map<Index3, CellFraction> all;
        for (const CellFraction& cell : found.cells) all[{cell.cell[0], cell.cell[1], cell.cell[2]}] = cell;
        return all;
    };
    const auto expect_faces = [](const CellFraction& cell, const std::array<double, 6>& expected) {
        BOOST_TEST((cell.face_fractions == expected));
        for (std::size_t d = 0; d < 3; ++d) BOOST_TEST(cell.vector_area[d] == expected[2 * d] - expected[2 * d + 1]);
    };

    // The low walls in the box's own cell, the high ones beyond it.
    const std::map<Index3, CellFraction> plain = by_cell(fractions(box, grid));
    BOOST_TEST(plain.size() == 4U);
    BOOST_TEST(plain.at(own).volume == 1);
    BOOST_TEST(plain.at(own).area == 3);
    expect_faces(plain.at(own), {0, 1, 0, 1, 0, 1});

    // All walls in the box's own cell, and no solid in its faces.
    const std::map<Index3, CellFraction> of_solid = by_cell(fractions(box, grid, {.walls = WallCell::solid}));
    BOOST_TEST(of_solid.size() == 1U);
    BOOST_TEST(of_solid.at(own).volume == 1);
    BOOST_TEST(of_solid.at(own).area == 6);
    expect_faces(of_solid.at(own), {});

    // Each wall in the cell beyond it; the box's own cell has no surface, and is full.
    const Fractions of_fluid = fractions(box, grid, {.walls = WallCell::fluid});
    const std::map<Index3, CellFraction> beyond = by_cell(of_fluid);
    BOOST_TEST(beyond.size() == 6U);
    BOOST_TEST(of_fluid.is_full(1, 2, 3));
    for (std::size_t face = 0; face < 6; ++face) {
        Index3 cell = own;
        cell[face / 2] += face % 2 == 0 ? -1 : 1;
        const CellFraction& found = beyond.at(cell);
        BOOST_TEST(found.volume == 0);
        BOOST_TEST(found.area == 1);
        std::array<double, 6> faces{};
        faces[face ^ 1U] = 1;
        expect_faces(found, faces);
        BOOST_TEST(found.surface_centroid[face / 2] == (face % 2 == 0 ? 0.5 : -0.5));
        BOOST_TEST((found.face_centroids[face ^ 1U] == std::array{0.0, 0.0}));
    }

    // AMReX: whole cells of fluid with one closed face, the normal towards it.
    const Fractions amrex = fractions(box, grid, FractionOptions::of("amrex"));
    BOOST_TEST(amrex.cells.size() == 6U);
    BOOST_TEST(!amrex.is_full(1, 2, 3));
    BOOST_TEST(amrex.is_full(0, 0, 0));
    for (const auto& [cell, found] : by_cell(amrex)) {
        BOOST_TEST(found.volume == 1);
        BOOST_TEST(found.area == 1);
        for (std::size_t d = 0; d < 3; ++d) {
            BOOST_TEST(found.vector_area[d] == static_cast<double>(own[d] - cell[d]));
            BOOST_TEST(found.vector_area[d] == found.face_fractions[2 * d] - found.face_fractions[2 * d + 1]);
        }
    }
    const Fractions chombo = fractions(box, grid, FractionOptions::of("chombo"));
    for (std::size_t n = 0; n < 6; ++n)
        for (std::size_t d = 0; d < 3; ++d)
            BOOST_TEST(chombo.cells.at(n).vector_area[d] == -amrex.cells[n].vector_area[d]);

    // A flow within the box: its one cell, closed on all sides.
    for (const char* const convention : {"amrex", "chombo"}) {
        const FractionOptions options = FractionOptions::of(convention, CellPart::solid);
        BOOST_TEST((options.normals_into_solid != FractionOptions::of(convention).normals_into_solid));
        BOOST_TEST((FractionOptions::of(convention, CellPart::fluid) == FractionOptions::of(convention)));
        const Fractions within = fractions(box, grid, options);
        BOOST_REQUIRE(within.cells.size() == 1U);
        BOOST_TEST((within.cells[0].cell == std::array<std::int32_t, 3>{1, 2, 3}));
        BOOST_TEST(within.cells[0].volume == 1);
        expect_faces(within.cells[0], {});
        BOOST_TEST(std::ranges::count(within.full, 0) == static_cast<std::ptrdiff_t>(within.full.size()));
    }
    // Others have the part alone.
    const FractionOptions fluid = FractionOptions::of("plain", CellPart::fluid);
    BOOST_TEST((fluid == FractionOptions{.part = CellPart::fluid}));

    // A part of the grid whose ends are in the walls has the cells of the whole.
    for (const WallCell walls : {WallCell::solid, WallCell::fluid}) {
        const std::map<Index3, CellFraction> whole = by_cell(fractions(box, grid, {.walls = walls}));
        for (const Grid& part : {grid.block({1, 2, 3}, {2, 2, 2}), grid.block({0, 2, 3}, {2, 2, 2}),
                                 grid.block({1, 2, 2}, {2, 2, 2}), grid.block({1, 3, 3}, {3, 2, 2})}) {
            const Fractions found = fractions(box, part, {.walls = walls});
            for (const auto& [cell, known] : whole) {
                bool is_in = true;
                for (std::size_t d = 0; d < 3; ++d)
                    is_in = is_in && cell[d] >= part.first[d] && cell[d] < part.first[d] + part.size[d] - 1;
                const std::map<Index3, CellFraction> own_cells = by_cell(found);
                BOOST_REQUIRE(own_cells.contains(cell) == is_in);
                if (is_in) BOOST_TEST((own_cells.at(cell).face_fractions == known.face_fractions));
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(walls_of_unequal_steps_belong_to_one_side) {
    // A staircase of boxes in cell planes: every wall is in a face between cells.
    const Mesh stairs = together({test::box({1, 1, 1}, {5, 3, 2}), test::box({1, 1, 2}, {3, 3, 3})}, "stairs");
    const Grid grid{{0, 0, 0}, {1, 1, 1}, {8, 7, 7}};
    const OuterSurface surface = outer(stairs);
    for (const WallCell walls : {WallCell::above, WallCell::solid, WallCell::fluid}) {
        const Fractions found = fractions(surface, grid, {.walls = walls});
        double area = 0;
        for (const CellFraction& cell : found.cells) {
            area += cell.area;
            BOOST_TEST((cell.volume == 0 || cell.volume == 1));
            if (walls != WallCell::above) BOOST_TEST(cell.volume == (walls == WallCell::solid ? 1 : 0));
            for (std::size_t d = 0; d < 3; ++d)
                BOOST_TEST(cell.face_fractions[2 * d + 1] - cell.face_fractions[2 * d] == -cell.vector_area[d]);
        }
        BOOST_TEST(area == surface.area);
        double volume = 0;
        for (const auto& [cell, fraction] : volumes(found)) volume += fraction;
        BOOST_TEST(volume == surface.volume);
    }
}

BOOST_AUTO_TEST_CASE(solid_and_fluid_are_the_cell) {
    const Mesh mesh = make_shape("knot");
    const Grid grid = Grid::around(mesh.box(), {.resolution = 25});
    const OuterSurface surface = outer(mesh);
    const Fractions solid = fractions(surface, grid), fluid = fractions(surface, grid, {.part = CellPart::fluid});
    BOOST_REQUIRE(solid.cells.size() == fluid.cells.size());
    for (std::size_t n = 0; n < solid.cells.size(); ++n) {
        const CellFraction &of_solid = solid.cells[n], &of_fluid = fluid.cells[n];
        BOOST_TEST(std::abs(of_solid.volume + of_fluid.volume - 1) < 1e-15);
        for (std::size_t d = 0; d < 3; ++d) {
            BOOST_TEST(std::abs(of_solid.volume * of_solid.centroid[d] + of_fluid.volume * of_fluid.centroid[d]) <
                       1e-13);
            BOOST_TEST(of_solid.vector_area[d] == of_fluid.vector_area[d]);
        }
        for (std::size_t face = 0; face < 6; ++face)
            BOOST_TEST(std::abs(of_solid.face_fractions[face] + of_fluid.face_fractions[face] - 1) < 1e-15);
    }
    const auto [nx, ny, nz] = solid.counts();
    std::size_t full = 0;
    for (std::size_t k = 0; k < nz; ++k)
        for (std::size_t j = 0; j < ny; ++j)
            for (std::size_t i = 0; i < nx; ++i) {
                full += solid.is_full(i, j, k) ? 1U : 0U;
                full += fluid.is_full(i, j, k) ? 1U : 0U;
            }
    BOOST_TEST(full + solid.cells.size() == nx * ny * nz);
}

BOOST_AUTO_TEST_CASE(three_directions_give_one_volume) {
    constexpr std::uint64_t seed = 23;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    // Shells within each other; vertices on planes between cells; thin triangles; a body far from the origin.
    std::vector<Mesh> meshes{make_shape("stairs"), make_shape("knot")};
    const Vec3 far{1e6, -1e6, 1e6};
    const auto inside_out = [](Mesh mesh) {
        std::vector<Triangle> faces = mesh.triangles();
        for (Triangle& face : faces) std::swap(face[0], face[1]);
        return Mesh(mesh.vertices(), faces);
    };
    meshes.push_back(together({test::box({0, 0, 0}, {4, 4, 4}), inside_out(test::box({1, 1, 1}, {3.5, 3, 3})),
                               test::box({1.5, 1.5, 2}, {2, 2.5, 2.5})},
                              "shells"));
    meshes.push_back(test::box(far, {far[0] + 1.25, far[1] + 1.5, far[2] + 1.75}));
    std::vector<Vec3> needle(4);
    for (Vec3& vertex : needle) vertex = {random.uniform(0, 5), random.uniform(0, 1e-7), random.uniform(0, 1e-3)};
    if (dot(cross(difference(needle[1], needle[0]), difference(needle[2], needle[0])),
            difference(needle[3], needle[0])) < 0)
        std::swap(needle[0], needle[1]);
    meshes.emplace_back(needle, std::vector<Triangle>{{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}}, "needle");
    for (const Mesh& mesh : meshes) {
        const Grid grid = Grid::around(mesh.box(), {.resolution = 17, .margin = Length::in_voxels(1)});
        const std::map<Index3, double> first = volumes(fractions(mesh, grid));
        for (std::size_t turn = 1; turn < 3; ++turn) {
            const auto turned = [&](auto values) {
                auto result = values;
                for (std::size_t d = 0; d < 3; ++d) result[d] = values[(d + turn) % 3];
                return result;
            };
            std::vector<Vec3> vertices;
            for (const Vec3& vertex : mesh.vertices()) vertices.push_back(turned(vertex));
            const Grid own{turned(grid.origin), turned(grid.spacing), turned(grid.size), turned(grid.first)};
            const std::map<Index3, double> other = volumes(fractions(Mesh(vertices, mesh.triangles()), own));
            double worst = 0;
            for (const auto& [cell, fraction] : first)
                worst = std::max(worst, std::abs(fraction - other.at(turned(cell))));
            BOOST_TEST(worst < 1e-12, mesh.name() << ": " << worst);
        }
    }
}

BOOST_AUTO_TEST_CASE(unequal_spacings_and_far_offsets_keep_sums) {
    const Mesh knot = make_shape("knot");
    const double side = knot.box().longest_side();
    Grid grid = Grid::around(knot.box(), {.spacing = Vec3{side / 8, side * 7 / 8, side * 0.01 / 8}});
    check_sums(knot, grid, outer(knot));
    // Moved by 1e6 of its sides: the lattice's first sample moves with it.
    std::vector<Vec3> vertices = knot.vertices();
    for (Vec3& vertex : vertices)
        for (double& x : vertex) x = x / side + 1e6;
    const Mesh far(vertices, knot.triangles(), "a far knot");
    check_sums(far, Grid::around(far.box(), {.resolution = 20}), outer(far));
    grid = Grid{{0, 0, 0}, {0.1, 0.1, 0.1}, {1, 1, 1}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        grid.first[axis] = static_cast<std::int64_t>(far.box().lower[axis] / 0.1) - 1;
        grid.size[axis] = static_cast<std::int64_t>(far.box().upper[axis] / 0.1) + 3 - grid.first[axis];
    }
    const Fractions found = fractions(far, grid);
    double volume = 0;
    for (const auto& [cell, fraction] : volumes(found)) volume += fraction;
    BOOST_TEST(std::abs(volume * 1e-3 - outer(far).volume) < 1e-12);
}

BOOST_AUTO_TEST_CASE(cells_have_the_same_bytes_wherever_their_numbers_begin) {
    const OuterSurface surface = outer(make_shape("sphere3"));
    for (const Vec3& spacing : {Vec3{0.25, 0.25, 0.25}, Vec3{0.3125, 0.21875, 0.28125}}) {
        const Grid near{{-1.25, -1.25, -1.25}, spacing, {9, 13, 10}};
        for (const FractionOptions& options : {FractionOptions(), FractionOptions::of("amrex")}) {
            const Fractions known = fractions(surface, near, options);
            for (const std::int64_t first : {1000, 1000000, 100000000, -100000000, 2000000000}) {
                Grid far = near;
                far.first = {first, first, first};
                for (std::size_t axis = 0; axis < 3; ++axis) far.origin[axis] -= spacing[axis] * double(first);
                BOOST_REQUIRE(far.position(0, 0, 0) == near.origin);
                check_same_cells(known, fractions(surface, far, options));
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(vertices_half_way_between_planes_have_the_same_bytes_under_odd_numbers_too) {
    Random random(7);
    std::vector<Vec3> vertices;
    // Half cells, among others.
    for (int n = 0; n < 60; ++n) vertices.push_back(random.point(0, 8));
    for (std::size_t n = 0; n < vertices.size(); ++n)
        for (std::size_t axis = 0; axis < 3; ++axis)
            if ((n + axis) % 3 != 0) vertices[n][axis] = std::floor(vertices[n][axis]) + 0.5;
    std::vector<Mesh> tetrahedra;
    for (std::uint32_t n = 0; n + 3 < vertices.size(); n += 4) {
        const Mesh one({vertices[n], vertices[n + 1], vertices[n + 2], vertices[n + 3]},
                       {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}});
        tetrahedra.push_back(one);
    }
    std::size_t cells = 0;
    for (const Mesh& mesh : tetrahedra) {
        const OuterSurface surface = outer(mesh);
        const Grid near{{-1, -1, -1}, {1, 1, 1}, {11, 11, 11}};
        const Fractions known = fractions(surface, near);
        cells += known.cells.size();
        for (const std::int64_t first : {1, 3, 1001, 99999}) {
            Grid far = near;
            far.first = {first, first, first};
            for (double& x : far.origin) x -= static_cast<double>(first);
            check_same_cells(known, fractions(surface, far));
        }
    }
    BOOST_TEST(cells > 500U);
}

BOOST_AUTO_TEST_CASE(a_body_far_from_sample_0_has_the_bytes_of_one_near_it) {
    // Coordinates with few digits, so that the other body is the same one.
    Mesh ball = make_shape("sphere3");
    std::vector<Vec3> vertices = ball.vertices();
    for (Vec3& vertex : vertices)
        for (double& x : vertex) x = std::round(x * 0x1p20) / 0x1p20;
    ball = Mesh(vertices, ball.triangles());
    constexpr std::int64_t cells = 1 << 27;
    const Mesh other = shifted(ball, {0.25 * cells, -0.25 * cells, 0.25 * cells});
    const OuterSurface both = outer(together({ball, other}, "two balls"));
    const Grid near{{-1.25, -1.25, -1.25}, {0.25, 0.25, 0.25}, {11, 11, 11}};
    const Grid far{near.origin, near.spacing, near.size, {cells, -cells, cells}};
    for (const FractionOptions& options : {FractionOptions(), FractionOptions::of("amrex")})
        check_same_cells(fractions(both, near, options), fractions(both, far, options));
}

BOOST_AUTO_TEST_CASE(points_and_walls_are_as_exact_far_from_sample_0) {
    // A wall 2^-38 beyond a plane.
    const Mesh box = test::box({1 + 0x1p-38, 1, 1}, {2.5, 3, 3});
    const Grid grid{{-1e8, 1e8, -1e8}, {1, 1, 1}, {4, 4, 4}, {100000000, -100000000, 100000000}};
    const Fractions found = fractions(box, grid, FractionOptions::of("vtk"));
    const auto cell = std::ranges::find(found.cells, std::array{100000001, -99999999, 100000001}, &CellFraction::cell);
    BOOST_REQUIRE((cell != found.cells.end()));
    BOOST_TEST(cell->volume == 1 - 0x1p-38);
    BOOST_TEST(cell->centroid[0] == 1.5 + 0x1p-39);
    BOOST_TEST(cell->centroid[1] == 1.5);
}

BOOST_AUTO_TEST_CASE(large_triangles_are_as_exact_as_their_size_in_cells) {
    // Below x + y + z = n, in the cell from (i, j, k): the part of a cube below x + y + z = n - i - j - k.
    const auto part = [](double t) {
        const auto cube = [](double x) { return x > 0 ? x * x * x : 0; };
        return (cube(t) - 3 * cube(t - 1) + 3 * cube(t - 2)) / 6;
    };
    for (const double n : {10.5, 1e3 + 0.5, 1e5 + 0.5, 1e7 + 0.5}) {
        const Mesh tetrahedron({{0, 0, 0}, {n, 0, 0}, {0, n, 0}, {0, 0, n}},
                               {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}});
        const auto middle = static_cast<std::int64_t>(n / 3);
        double worst = 0;
        const Fractions found =
            fractions(tetrahedron, Grid{{0, 0, 0}, {1, 1, 1}, {6, 6, 6}, {middle - 2, middle - 2, middle - 2}});
        BOOST_TEST(found.cells.size() > 30U);
        for (const CellFraction& cell : found.cells)
            worst = std::max(worst, std::abs(cell.volume - part(n - cell.cell[0] - cell.cell[1] - cell.cell[2])));
        BOOST_TEST(worst <= 1e-15 * n, n << ": " << worst);
    }
}

BOOST_AUTO_TEST_CASE(vertices_near_a_plane_are_moved_onto_it_on_request) {
    // 0.3 / 0.1 is below 3.
    const Mesh box = test::box({0.1, 0.1, 0.1}, {0.3, 0.3, 0.3});
    const Grid grid{{0, 0, 0}, {0.1, 0.1, 0.1}, {6, 6, 6}};
    FractionOptions options = FractionOptions::of("amrex");
    const auto partial = [&] {
        return std::ranges::count_if(fractions(box, grid, options).cells,
                                     [](const CellFraction& cell) { return cell.volume != 0 && cell.volume != 1; });
    };
    BOOST_TEST(partial() > 0);
    options.snap = 1e-9;
    BOOST_TEST(partial() == 0);
    options.snap = 0.1;
    check_throws(ErrorCode::invalid_argument, {"snap is 0.1", "0.001"}, [&] { fractions(box, grid, options); });
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

BOOST_AUTO_TEST_CASE(an_edge_through_a_corner_of_a_cell_joins_nothing) {
    // The faces at the edge from P to Q cross the cell; the edge meets it in the corner (1, 1, 1) alone.
    const Mesh tetrahedron({{9, -7, 1}, {-7, 9, 1}, {-15, -15, -7}, {-3, -3, -15}},
                           {{0, 1, 3}, {0, 2, 1}, {0, 3, 2}, {1, 2, 3}}, "tetrahedron");
    const Fractions found = fractions(tetrahedron, Grid{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}});
    BOOST_REQUIRE(found.cells.size() == 1U);
    BOOST_TEST(found.cells[0].pieces == 2U);
}

BOOST_AUTO_TEST_CASE(what_snap_flattens_is_warned_of) {
    const auto warnings = [](double thickness, double snap) {
        std::string told;
        FractionOptions options;
        options.snap = snap;
        CallOptions call;
        call.log = [&](const std::string& message) { told += message; };
        fractions(outer(box({0.5, 0.5, 0}, {3.5, 3.5, thickness})), Grid{{0, 0, -1}, {1, 1, 1}, {5, 5, 3}}, options,
                  call);
        return told;
    };
    BOOST_TEST(warnings(4e-4, 1e-3).find("8 triangles") != std::string::npos);
    BOOST_TEST(warnings(4e-4, 1e-3).find("snap 0.001") != std::string::npos);
    BOOST_TEST(warnings(4e-4, 1e-9).empty());
    BOOST_TEST(warnings(1e-10, 1e-9).find("8 triangles") != std::string::npos);
    BOOST_TEST(warnings(1 + 1e-10, 1e-9).empty());
}

BOOST_AUTO_TEST_CASE(conventions_are_one_row_told_in_other_ways) {
    const Mesh mesh = make_shape("knot");
    const OuterSurface surface = outer(mesh);
    const double side = mesh.box().longest_side() / 20;
    for (const Vec3& spacing : {Vec3{side, side, side}, Vec3{side, 2 * side, side / 2}}) {
        const Grid grid = Grid::around(mesh.box(), {.spacing = spacing});
        const Fractions plain = fractions(surface, grid),
                        amrex = fractions(surface, grid, FractionOptions::of("amrex")),
                        vtk = fractions(surface, grid, FractionOptions::of("vtk"));
        BOOST_REQUIRE(amrex.cells.size() == plain.cells.size());
        BOOST_REQUIRE(vtk.cells.size() == plain.cells.size());
        for (std::size_t n = 0; n < plain.cells.size(); ++n) {
            const CellFraction &row = plain.cells[n], &of_faces = amrex.cells[n], &points = vtk.cells[n];
            Vec3 across;
            for (std::size_t d = 0; d < 3; ++d) {
                const double middle = grid.origin[d] + spacing[d] * (row.cell[d] + 0.5);
                BOOST_TEST(std::abs(points.centroid[d] - (middle + spacing[d] * row.centroid[d])) < 1e-12 * side);
                BOOST_TEST(std::abs(points.surface_centroid[d] - (middle + spacing[d] * row.surface_centroid[d])) <
                           1e-12 * side);
                // Differences of opposite faces are the area times the normal, in cubes.
                const double between = of_faces.face_fractions[2 * d] - of_faces.face_fractions[2 * d + 1];
                if (spacing[0] == spacing[1]) BOOST_TEST(std::abs(between - of_faces.vector_area[d]) < 1e-12);
                across[d] = row.vector_area[d] * spacing[(d + 1) % 3] * spacing[(d + 2) % 3];
            }
            const double whole = length(row.vector_area);
            if (whole < 1e-9 * side * side) continue;
            BOOST_TEST(std::abs(of_faces.area - whole * whole / length(across)) < 1e-12);
            BOOST_TEST(std::abs(length(of_faces.vector_area) - of_faces.area) < 1e-12);
        }
    }
}

BOOST_AUTO_TEST_CASE(a_grid_that_needs_more_bytes_than_a_process_has_addresses_is_refused,
                     *boost::unit_test::precondition(on_usual_memory)) {
    const Mesh box = test::box({0, 0, 0}, {1, 1, 1});
    check_throws(ErrorCode::out_of_memory, {"cells of the grids", "take parts of them"}, [&] {
        fractions(box, Grid{{0, 0, 0}, {1, 1, 1}, {40000000, 40000000, 5}});
    });
    check_throws(ErrorCode::out_of_memory, {"cells of the grids"}, [&] {
        fractions(box, Grid{{0, 0, 0}, {1, 1, 1}, {2000000000, 2000000000, 2000000000}});
    });
}

BOOST_AUTO_TEST_CASE(a_grid_without_cells_is_refused) {
    const Mesh box = test::box({0, 0, 0}, {1, 1, 1});
    check_throws(ErrorCode::invalid_argument, {"3000000000 to 3000000002 along z", "origin"}, [&] {
        fractions(box, Grid{{0, 0, 0}, {1, 1, 1}, {3, 3, 3}, {0, 0, 3000000000}});
    });
    check_throws(ErrorCode::invalid_argument, {"lies inf cells along", "larger spacing"}, [&] {
        fractions(box, Grid{{0, 0, 0}, {1e-310, 1e-310, 1e-310}, {3, 3, 3}});
    });
    check_throws(ErrorCode::invalid_argument, {"1 sample along y"}, [&] {
        fractions(box, Grid{{0, 0, 0}, {1, 1, 1}, {3, 1, 3}});
    });
    const Mesh open(box.vertices(), {{0, 2, 3}}, "open");
    check_throws(ErrorCode::unsupported, {"outer surface"}, [&] {
        fractions(open, Grid{{0, 0, 0}, {1, 1, 1}, {3, 3, 3}});
    });
}

}  // namespace clsdf
