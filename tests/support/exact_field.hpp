#pragma once

#include <clsdf/clsdf.hpp>
#include <clsdf/reference.hpp>

#include <boost/test/unit_test.hpp>

#include <bit>
#include <cstdint>
#include <vector>

/// Fields for tests, and what they are held against.
namespace clsdf::test {

/// The device of all tests of a program. It is never destroyed: the driver may be gone by the time static objects are.
inline const Device& test_device() {
    static const auto* const device = new Device(Device::best());
    return *device;
}

/// What DESIGN promises: an error of at most this, or of 2 units in the last place.
inline constexpr double promised_voxels = 1e-5;

inline Field compute(const Mesh& mesh, const Grid& grid, const Band& band, SignRule sign = SignRule::automatic) {
    DistanceTransform transform(test_device(), mesh, {.sign = sign});
    return transform(grid, band, {.triangle = true});
}

/// Every sample held against the reference: distance, sign, fill and triangle.
inline reference::CheckReport check_exact(const Mesh& mesh, const Field& field) {
    reference::CheckOptions options;
    options.samples = 0;
    options.tolerance_voxels = promised_voxels;
    const reference::CheckReport report = reference::check(mesh, field, options);
    BOOST_TEST_CONTEXT("mesh " << mesh.name() << ", grid of " << field.grid.size[0] << " x " << field.grid.size[1]
                               << " x " << field.grid.size[2] << ", half widths in voxels "
                               << field.band.inside / field.grid.voxel() << " and "
                               << field.band.outside / field.grid.voxel()) {
        BOOST_TEST(report.wrong_values == 0U);
        BOOST_TEST(report.wrong_signs == 0U);
        BOOST_TEST(report.missed == 0U);
        BOOST_TEST(report.leaked == 0U);
        BOOST_TEST(report.wrong_triangles == 0U);
        for (const reference::CheckReport::Finding& finding : report.findings)
            BOOST_TEST_MESSAGE("  at (" << finding.sample[0] << ", " << finding.sample[1] << ", " << finding.sample[2]
                                        << "): " << finding.found << " instead of " << finding.expected << ": "
                                        << finding.what);
    }
    BOOST_TEST_MESSAGE(mesh.name() << ": " << report.band_samples << " samples of the band, error "
                                   << report.max_error_voxels << " voxels, " << report.max_error_ulp << " ulp");
    return report;
}

/// Computed and held against the reference; there must be something in the band to look at.
inline reference::CheckReport check_exact(const Mesh& mesh, const Grid& grid, const Band& band,
                                          SignRule sign = SignRule::automatic) {
    const reference::CheckReport report = check_exact(mesh, compute(mesh, grid, band, sign));
    BOOST_TEST(report.band_samples > 0U, "nothing of " << mesh.name() << " is in the band");
    return report;
}

/// A grid around the mesh's box with `margin` samples of room; h = 1 on the longest side's scale of `resolution`.
inline Grid grid_around(const Mesh& mesh, std::int64_t resolution, double margin_voxels) {
    GridOptions options;
    options.resolution = resolution;
    options.margin = Length::in_voxels(margin_voxels);
    return Grid::around(mesh.box(), options);
}

/// A grid of spacing h whose middle sample is at `centre` exactly (where doubles allow it), `reach` samples on each
/// side.
inline Grid grid_at(const Vec3& centre, double h, std::int64_t reach) {
    Grid grid;
    grid.spacing = {h, h, h};
    grid.size = {2 * reach + 1, 2 * reach + 1, 2 * reach + 1};
    for (std::size_t axis = 0; axis < 3; ++axis) grid.origin[axis] = centre[axis] - static_cast<double>(reach) * h;
    return grid;
}

/// The very bits, so that -0 differs from 0 and a NaN equals itself.
inline std::vector<std::uint32_t> bits_of(const std::vector<float>& values) {
    std::vector<std::uint32_t> bits(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) bits[i] = std::bit_cast<std::uint32_t>(values[i]);
    return bits;
}

inline bool same_bytes(const Field& one, const Field& other) {
    return bits_of(one.distance) == bits_of(other.distance) && one.triangle == other.triangle;
}

}  // namespace clsdf::test
