#include "support/exact_field.hpp"
#include "support/open_meshes.hpp"
#include "support/throws.hpp"

#pragma GCC visibility push(default)
#include <openvdb/tools/MeshToVolume.h>
#include <clsdf/openvdb.hpp>
#pragma GCC visibility pop

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

// OpenVDB's grids of sparse fields, held against the dense field and against OpenVDB's own level set of the mesh.

using namespace clsdf;
using namespace clsdf::test;

namespace {

struct Counts {
    std::size_t wrong = 0, wrong_activity = 0, wrong_triangles = 0, active = 0;
};

Counts compare(const LevelSet& found, const Field& dense) {
    Counts counts;
    const Grid& grid = dense.grid;
    const auto outside = std::bit_cast<std::uint32_t>(static_cast<float>(dense.band.outside));
    const auto inside = std::bit_cast<std::uint32_t>(-static_cast<float>(dense.band.inside));
    const auto distance = found.distance->getConstAccessor();
    for (std::int64_t k = 0; k < grid.size[2]; ++k)
        for (std::int64_t j = 0; j < grid.size[1]; ++j)
            for (std::int64_t i = 0; i < grid.size[0]; ++i) {
                const std::size_t sample = grid.offset(i, j, k);
                const openvdb::Coord at(static_cast<int>(grid.first[0] + i), static_cast<int>(grid.first[1] + j),
                                        static_cast<int>(grid.first[2] + k));
                // Bit by bit: 0.0 is in a band that has the inside's half width 0, and -0.0 is beyond it.
                const auto value = std::bit_cast<std::uint32_t>(dense.distance()[sample]);
                const bool is_active = value != outside && value != inside;
                counts.active += is_active ? 1U : 0U;
                counts.wrong += std::bit_cast<std::uint32_t>(distance.getValue(at)) != value ? 1U : 0U;
                counts.wrong_activity += distance.isValueOn(at) != is_active ? 1U : 0U;
                if (found.triangle)
                    counts.wrong_triangles +=
                        found.triangle->tree().getValue(at) != static_cast<std::int32_t>(dense.triangle()[sample]) ? 1U
                                                                                                                   : 0U;
            }
    return counts;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(a_level_set)

BOOST_AUTO_TEST_CASE(has_the_dense_fields_values_the_band_active_and_the_inside_in_tiles) {
    const Mesh sphere = make_shape("sphere4"), open = open_box({0, 0, 0}, {1, 1, 1}, 0);
    for (const auto& [mesh, sign] : {std::pair(&sphere, SignRule::automatic), std::pair(&sphere, SignRule::none),
                                     std::pair(&open, SignRule::solid_angle)}) {
        const DistanceTransform transform(test_device(), *mesh, {.sign = sign});
        const Grid whole = grid_around(*mesh, 75, 9);
        for (const Grid& grid : {whole, whole.block({-11, 3, 7}, {70, 50, 45})}) {
            const double h = grid.voxel();
            for (const Band& band : {Band{3 * h, 3 * h}, Band{4 * h, h}, Band{0, 2 * h}}) {
                const OutputSet outputs = Output::triangle;
                const LevelSet found = make_level_set(transform.compute_sparse(grid, band, outputs));
                const Counts counts = compare(found, transform.compute(grid, band, outputs));
                BOOST_TEST(counts.wrong == 0U);
                BOOST_TEST(counts.wrong_activity == 0U);
                BOOST_TEST(counts.wrong_triangles == 0U);
                BOOST_TEST(found.distance->activeVoxelCount() == counts.active);
                BOOST_TEST(found.distance->background() == static_cast<float>(band.outside));
                BOOST_TEST(found.triangle->background() == -1);
                BOOST_TEST((found.distance->getGridClass() ==
                            (sign == SignRule::none ? openvdb::GRID_UNKNOWN : openvdb::GRID_LEVEL_SET)));
                const openvdb::Vec3d corner = found.distance->indexToWorld(openvdb::Coord(
                    static_cast<int>(grid.first[0]), static_cast<int>(grid.first[1]), static_cast<int>(grid.first[2])));
                const Vec3 expected = grid.position(0, 0, 0);
                for (std::size_t axis = 0; axis < 3; ++axis)
                    BOOST_TEST(std::abs(corner[static_cast<int>(axis)] - expected[axis]) < 1e-12);
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(is_the_same_slab_by_slab) {
    const Mesh mesh = make_shape("sphere4");
    const DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_around(mesh, 90, 9);
    const Band band = Band::symmetric(3 * grid.voxel());
    LevelSetBuilder builder({grid, band, transform.sign(), {}});
    transform.compute_sparse(grid, band, Output::distance, [&](const SparseSlab& slab) { builder.append(slab); });
    const LevelSet slabs = builder.finish(), whole = make_level_set(transform.compute_sparse(grid, band));
    BOOST_TEST(!slabs.triangle);
    BOOST_TEST(slabs.distance->tree().hasSameTopology(whole.distance->tree()));
    BOOST_TEST(compare(slabs, transform.compute(grid, band)).wrong == 0U);
    check_throws(ErrorCode::invalid_argument, {"level set", "finish()"}, [&] { builder.finish(); });
}

// meshToVolume() does not find the nearest triangle of every voxel, so a few differ, by less than a voxel.
BOOST_AUTO_TEST_CASE(is_that_of_openvdbs_mesh_to_volume) {
    const Mesh mesh = make_shape("sphere4");
    const DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_around(mesh, 75, 9);
    const double h = grid.voxel();
    const LevelSet found = make_level_set(transform.compute_sparse(grid, Band::symmetric(3 * h)));

    std::vector<openvdb::Vec3s> points;
    for (const Vec3& vertex : mesh.vertices())
        points.emplace_back(static_cast<float>(vertex[0]), static_cast<float>(vertex[1]),
                            static_cast<float>(vertex[2]));
    std::vector<openvdb::Vec3I> triangles;
    for (const Triangle& triangle : mesh.triangles()) triangles.emplace_back(triangle[0], triangle[1], triangle[2]);
    const openvdb::FloatGrid::Ptr theirs = openvdb::tools::meshToSignedDistanceField<openvdb::FloatGrid>(
        found.distance->transform(), points, triangles, {}, 3, 3);

    BOOST_TEST(std::abs(theirs->background() - found.distance->background()) < 1e-6F);
    const auto accessor = found.distance->getConstAccessor();
    std::size_t active = 0, inactive_here = 0;
    double sum = 0, largest = 0;
    for (auto value = theirs->cbeginValueOn(); value; ++value) {
        ++active;
        if (!accessor.isValueOn(value.getCoord())) {
            ++inactive_here;
            continue;
        }
        const double difference = std::abs(static_cast<double>(*value - accessor.getValue(value.getCoord()))) / h;
        largest = std::max(largest, difference);
        sum += difference;
    }
    BOOST_TEST(active > 10000U);
    BOOST_TEST(largest < 1);
    BOOST_TEST(sum < 1e-3 * static_cast<double>(active));
    BOOST_TEST(static_cast<double>(inactive_here) < 1e-3 * static_cast<double>(active));
    // The inside: tiles of minus the half width, beyond the band.
    const openvdb::Coord middle =
        openvdb::Coord::round(found.distance->transform().worldToIndex(openvdb::Vec3d(0, 0, 0)));
    BOOST_TEST(accessor.getValue(middle) == -found.distance->background());
    BOOST_TEST(theirs->tree().getValue(middle) == -theirs->background());
}

BOOST_AUTO_TEST_CASE(refuses_what_it_has_no_grid_for) {
    const Mesh mesh = make_shape("sphere3");
    const DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_around(mesh, 40, 5);
    const Band band = Band::symmetric(3 * grid.voxel());
    check_throws(ErrorCode::unsupported, {"level set", "triangle"}, [&] {
        LevelSetBuilder({grid, band, SignRule::nonzero, {}}, Output::gradient);
    });
    LevelSetBuilder builder({grid, band, SignRule::nonzero, {}}, Output::triangle);
    const SparseField field = transform.compute_sparse(grid, band);
    check_throws(ErrorCode::invalid_argument, {"level set", "triangle", "compute this output"},
                 [&] { builder.append(field.slab()); });
    Grid far = grid;
    far.first[1] = std::int64_t{1} << 31;
    check_throws(ErrorCode::unsupported, {"32 bits", "along y"}, [&] {
        LevelSetBuilder({far, band, SignRule::nonzero, {}});
    });
    SparseField negated = field;
    negated.positive_inside = true;
    check_throws(ErrorCode::unsupported, {"negative inside"}, [&] { make_level_set(negated); });
}

BOOST_AUTO_TEST_SUITE_END()
