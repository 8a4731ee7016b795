#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include <clsdf/papers.hpp>
#include <clsdf/tuning.hpp>

#include <algorithm>
#include <cmath>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// A tetrahedron `size` voxels large whose face opposite to its last vertex passes the origin.
Mesh large_tetrahedron(double size) {
    const auto at = [&](double x, double y, double z) { return Vec3{size * x + 0.3, size * y - 0.2, size * z + 0.1}; };
    return {{at(-0.4, -0.3, -0.15), at(0.5, -0.25, 0.1), at(-0.05, 0.6, 0.05), at(0.02, 0.03, -0.9)},
            {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}},
            "tetrahedron of " + std::to_string(size) + " voxels"};
}

/// A box from x = 0 to x = 7.3 that reaches to y = -+ size, to z = -+ 5: its long faces are steep along the rows.
Mesh long_prism(double size) {
    return moved(box({0, -size, -5}, {7.3, size, 5}, "prism of " + std::to_string(size) + " voxels"),
                 [&](const Vec3& v) {
                     return Vec3{v[0] + 3 * v[1] / size, v[1], v[2]};
                 });
}

/// A lattice whose sample (0, 0, 0) is far away, and of it a block that begins with sample `first`. The block's middle
/// is at (0, 0, 0), as nearly as the origin's doubles allow.
struct FarLattice {
    Vec3 spacing;
    Index3 first;

    Grid block(const Index3& size) const {
        Grid grid;
        grid.spacing = spacing;
        grid.first = first;
        grid.size = size;
        for (std::size_t axis = 0; axis < 3; ++axis)
            grid.origin[axis] =
                -spacing[axis] * (static_cast<double>(first[axis]) + 0.5 * static_cast<double>(size[axis] - 1));
        return grid;
    }

    /// A mesh in the block, one unit of which becomes a sample on every axis.
    Mesh in_samples(const Mesh& mesh) const {
        return moved(mesh, [&](const Vec3& v) {
            return Vec3{spacing[0] * v[0], spacing[1] * v[1], spacing[2] * v[2]};
        });
    }
};

/// In the smallest spacing, 7e5 to 7e11 from sample (0, 0, 0).
const std::vector<FarLattice> far_lattices{
    {{0.138, 0.138, 13.8}, {-1, -233306, -708969157}},
    {{0.073, 0.51, 0.00073}, {1000000007, -999999937, 812345678}},
    {{51.1, 0.0731, 0.0731}, {-1073741000, 12345, 1073000000}},
    {{1, 1, 1}, {1073000000, -1073000000, 600000000}},
};

}  // namespace

BOOST_AUTO_TEST_CASE(solids_a_million_times_larger_than_a_voxel_are_exact) {
    for (const double size : {1e4, 1e6}) {
        const Mesh mesh = large_tetrahedron(size);
        for (const Vec3& vertex : mesh.vertices()) check_exact(mesh, grid_at(vertex, 1, 7), Band::symmetric(3));
        const Vec3 &a = mesh.vertices()[0], &b = mesh.vertices()[1], &c = mesh.vertices()[2];
        const Vec3 on_edge{0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])};
        const Vec3 on_face{(a[0] + b[0] + c[0]) / 3, (a[1] + b[1] + c[1]) / 3, (a[2] + b[2] + c[2]) / 3};
        check_exact(mesh, grid_at(on_edge, 1, 7), Band::symmetric(3));
        check_exact(mesh, grid_at(on_face, 1, 7), Band{2.5, 3});
    }
}

// Offsets are formed in double, from the exact numbers of the record.
BOOST_AUTO_TEST_CASE(solids_a_billion_times_larger_than_a_voxel_are_as_good_as_their_numbers) {
    const Mesh mesh = large_tetrahedron(1e9);
    for (const Vec3& vertex : mesh.vertices()) check_exact(mesh, grid_at(vertex, 1, 7), Band::symmetric(3), guaranteed);
    check_exact(long_prism(1e9), grid_at({1, 2, 3}, 1, 9), Band::symmetric(3), guaranteed);
}

BOOST_AUTO_TEST_CASE(the_sign_is_exact_up_to_the_limit_of_its_integers) {
    for (const double size : {1e6, 0x1p31, 0x1p40, 0x1p41 - 1024}) {
        const Mesh mesh = long_prism(size);
        const Grid grid = grid_at({1, 2, 3}, 1, 9);
        const Field field = compute(mesh, grid, Band::signs_only());
        const reference::Oracle oracle(mesh);
        for (std::int64_t k = 0; k < grid.size[2]; ++k)
            for (std::int64_t j = 0; j < grid.size[1]; ++j)
                for (std::int64_t i = 0; i < grid.size[0]; ++i) {
                    // Nearer than the record's numbers resolve, a distance may be 0, and 0 has no sign.
                    const Vec3 position = grid.position(i, j, k);
                    if (oracle.nearest(position).distance <= 0x1p-46 * size) continue;
                    const std::optional<int> winding = oracle.winding_number(position);
                    if (winding) BOOST_REQUIRE(std::signbit(field.distance()[grid.offset(i, j, k)]) == (*winding != 0));
                }
    }
}

BOOST_AUTO_TEST_CASE(without_a_band_every_sample_has_its_distance_or_the_grid_is_refused) {
    const DistanceTransform transform(test_device(), make_shape("tetrahedron"), {.sign = SignRule::none});
    Grid grid{{0.1, 0.1, 0.1}, {1, 1, 1e9}, {2, 2, 8}};
    grid.first = {0, 0, 799'990};
    const Field field = transform.compute(grid, Band::full());
    BOOST_TEST(std::ranges::count_if(field.distance(), [](float d) { return !std::isfinite(d); }) == 0);
    grid.first = {0, 0, 800'000};
    check_throws(ErrorCode::invalid_argument, {"reaches 8e+14 voxels", "sample (0, 0, 0)", "move the origin nearer"},
                 [&] { transform.compute(grid, Band::full()); });
}

BOOST_AUTO_TEST_CASE(a_mesh_beyond_the_signs_integers_is_refused) {
    for (const double size : {0x1p41, 0x1p44}) {
        const Mesh mesh = long_prism(size);
        const Grid grid = grid_at({1, 2, 3}, 1, 9);
        check_throws(ErrorCode::unsupported, {"2^40 voxels", "unsigned", mesh.name()},
                     [&] { compute(mesh, grid, Band::symmetric(3)); });
        check_throws(ErrorCode::unsupported, {"voxels"},
                     [&] { DistanceTransform(test_device(), mesh).plan(grid, Band::symmetric(3)); });
    }
}

// Rows that cross thousands of walls, in no order, several of them between two samples.
BOOST_AUTO_TEST_CASE(rows_of_many_crossings_have_every_sign_right) {
    std::vector<Mesh> slices;
    slices.reserve(1500);
    for (int i = 0; i < 1500; ++i) {
        const double x = 0.01 + 0.0613 * ((i * 611) % 1500);
        slices.push_back(box({x, -0.9, -0.8}, {x + 0.0331, 0.93, 0.87}));
    }
    const Mesh mesh = together(slices, "slices");
    Grid grid;
    grid.size = {100, 5, 5};
    grid.origin = {-3, -1, -1};
    grid.spacing = {1, 0.5, 0.5};
    check_exact(mesh, grid, Band::symmetric(0.02));
    check_exact(mesh, grid, Band::full());
}

BOOST_AUTO_TEST_CASE(ten_thousand_triangles_in_a_voxel_are_exact) {
    const Mesh drop = scaled(make_shape("sphere5"), 0.21);
    BOOST_TEST(drop.triangles().size() > 8000U);
    for (const Vec3& centre : {Vec3{0.45, 0.4, 0.55}, Vec3{7.5, 7.6, 7.4}, Vec3{0, 0, 0}}) {
        const Mesh mesh = shifted(drop, centre);
        check_exact(mesh, grid_at({4, 4, 4}, 1, 6), Band::symmetric(4), guaranteed);
        check_exact(mesh, grid_at({4, 4, 4}, 1, 6), Band::full(), guaranteed);
    }
}

BOOST_AUTO_TEST_CASE(a_tip_of_a_thousand_triangles_is_exact) {
    const Mesh mesh = tilted(cone(1000));
    const Grid grid = grid_around(mesh, 30, 5);
    check_exact(mesh, grid, Band::symmetric(4 * grid.voxel()));
    const Vec3 tip = mesh.vertices()[0];
    check_exact(mesh, grid_at(tip, 0.01, 12), Band::symmetric(0.08), guaranteed);
}

// The position of the lattice's sample (0, 0, 0) does not matter: the difference from it is not rounded.
BOOST_AUTO_TEST_CASE(a_lattice_that_begins_a_billion_samples_away_is_exact) {
    for (const FarLattice& lattice : far_lattices)
        for (const char* shape : {"knot", "cube", "sphere3"}) {
            const Mesh mesh = lattice.in_samples(scaled(tilted(make_shape(shape)), 7));
            const Grid grid = lattice.block({29, 27, 25});
            for (const double half_width : {3 * grid.voxel(), 2 * grid.spacing[0], 3 * grid.spacing[2]})
                check_exact(mesh, grid, Band::symmetric(half_width), guaranteed);
            check_exact(mesh, grid, Band::full(), guaranteed);
        }
}

BOOST_AUTO_TEST_CASE(a_lattice_that_begins_a_billion_samples_away_is_exact_by_every_method) {
    for (const FarLattice& lattice : far_lattices) {
        const Mesh mesh = lattice.in_samples(scaled(tilted(make_shape("cube")), 7));
        const Grid grid = lattice.block({29, 27, 25});
        const Band band = Band::symmetric(2 * *std::max_element(grid.spacing.begin(), grid.spacing.end()));
        check_exact(mesh, compute(mesh, grid, band, KernelBody::by_group), guaranteed);
        for (const PapersOptions& method : {PapersOptions{.scan = Scan::slices}, {.polyhedra = Polyhedra::mauch}})
            check_exact(mesh, make_transform(test_device(), mesh, method).compute(grid, band, Output::triangle),
                        guaranteed);
    }
}

// Walls that pass samples by a few millionths of a voxel, on one side and on the other.
BOOST_AUTO_TEST_CASE(the_sign_beside_walls_is_exact_a_billion_samples_away) {
    for (const FarLattice& lattice : far_lattices) {
        const Grid grid = lattice.block({12, 11, 10});
        const Vec3 low = grid.position(3, 3, 3), high = grid.position(8, 7, 6);
        for (const double by : {-4e-6, 4e-6}) {
            const auto beyond = [&](double sign, const Vec3& corner) {
                const double step = sign * by * grid.voxel();
                return Vec3{corner[0] + step, corner[1] + step, corner[2] + step};
            };
            const Mesh mesh = box(beyond(-1, low), beyond(1, high));
            check_exact(mesh, compute(mesh, grid, Band::symmetric(2 * grid.voxel())), guaranteed);
        }
    }
}

BOOST_AUTO_TEST_CASE(a_part_of_a_far_lattice_has_the_bytes_of_the_whole) {
    for (const FarLattice& lattice : far_lattices) {
        const Mesh mesh = lattice.in_samples(scaled(tilted(make_shape("knot")), 7));
        const Grid grid = lattice.block({29, 27, 25});
        const Band band = Band::symmetric(3 * *std::max_element(grid.spacing.begin(), grid.spacing.end()));
        const Field whole = compute(mesh, grid, band);
        const Index3 offset{5, 9, 3}, size{17, 10, 14};
        const Field part = compute(mesh, grid.part(offset, size), band);
        std::vector<float> cut;
        for (std::int64_t k = 0; k < size[2]; ++k)
            for (std::int64_t j = 0; j < size[1]; ++j)
                for (std::int64_t i = 0; i < size[0]; ++i)
                    cut.push_back(whole.distance()[grid.offset(offset[0] + i, offset[1] + j, offset[2] + k)]);
        BOOST_TEST((bits_of(cut) == bits_of(part.distance())));
    }
}
