#pragma once

#include <clsdf/clsdf.hpp>
#include <clsdf/reference.hpp>
#include <clsdf/tuning.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

/// Fields for tests, and their comparison with the reference.
namespace clsdf::test {

/// The device of all tests of a program. It is never destroyed: the driver may be gone by the time static objects are.
inline const Device& test_device() {
    static const auto* const device = new Device(Device::strongest());
    return *device;
}

/// False on a GPU, and on PoCL that answers as one.
inline bool is_processor() {
    static const bool result = std::ranges::any_of(Device::all(), [](const DeviceInfo& info) {
        return info.id == test_device().id() && info.kind == DeviceKind::processor;
    });
    return result;
}

/// The device with one compute unit; all of it if it cannot be divided, as Debian's PoCL 7.1.
inline Device one_compute_unit() {
    try {
        return test_device().limited({.compute_units = 1});
    } catch (const Error& error) {
        BOOST_TEST((error.code() == ErrorCode::unsupported));
        BOOST_TEST_MESSAGE(error.what());
        return test_device();
    }
}

/// The allowed error: the larger of a number of voxels and a number of units in the last place.
struct Accuracy {
    double voxels;
    double ulp;
};
/// The design's aim.
inline constexpr Accuracy aimed{1e-6, 2};
/// The aim plus the excess of a few in a hundred thousand samples: for large numbers of random samples.
inline constexpr Accuracy nearly_aimed{1.5e-6, 2};
/// The contract of every field, also if distances of many voxels round more than twice.
inline constexpr Accuracy guaranteed{1e-5, 2};

/// The default of the tests. The kernels for GPUs miss the aim in a few samples of a hundred thousand.
inline Accuracy expected_accuracy() {
    return is_processor() ? aimed : guaranteed;
}

/// The distance and all others.
inline OutputSet all_outputs() {
    OutputSet outputs;
    for (const OutputInfo& info : output_table()) outputs.insert(info.output);
    return outputs;
}

inline Field compute(const Mesh& mesh, const Grid& grid, const Band& band, const TransformOptions& options = {}) {
    return DistanceTransform(test_device(), mesh, options).compute(grid, band, all_outputs());
}

inline Field compute(const Mesh& mesh, const Grid& grid, const Band& band, SignRule sign) {
    return compute(mesh, grid, band, TransformOptions{.sign = sign});
}

inline Field compute(const Mesh& mesh, const Grid& grid, const Band& band, KernelBody body) {
    return compute(mesh, grid, band, TransformOptions{.body = body});
}

/// Every sample held against the reference: distance, sign, fill and all else that the field holds.
inline reference::CheckReport check_exact(const Mesh& mesh, const Field& field,
                                          const Accuracy& accuracy = expected_accuracy()) {
    reference::CheckOptions options;
    options.samples = 0;
    options.tolerance_voxels = accuracy.voxels;
    options.tolerance_ulp = accuracy.ulp;
    reference::CheckReport report = reference::check(mesh, field, options);
    BOOST_TEST_CONTEXT("mesh " << mesh.name() << ", grid of " << field.grid.size[0] << " x " << field.grid.size[1]
                               << " x " << field.grid.size[2] << ", half widths in voxels "
                               << field.band.inside / field.grid.voxel() << " and "
                               << field.band.outside / field.grid.voxel()) {
        BOOST_TEST(report.wrong_values == 0U);
        BOOST_TEST(report.wrong_signs == 0U);
        BOOST_TEST(report.missed == 0U);
        BOOST_TEST(report.leaked == 0U);
        for (const OutputInfo& info : output_table()) {
            const std::size_t wrong = report.wrong_outputs[detail::index_of(info.output)];
            BOOST_TEST(wrong == 0U, wrong << " wrong in " << info.name);
        }
        for (const reference::CheckReport::Finding& finding : report.findings)
            BOOST_TEST_MESSAGE("  at (" << finding.sample[0] << ", " << finding.sample[1] << ", " << finding.sample[2]
                                        << "): " << finding.found << " instead of " << finding.expected << ": "
                                        << finding.what);
    }
    BOOST_TEST_MESSAGE(mesh.name() << ": " << report.band_samples << " samples of the band, error "
                                   << report.max_error_voxels << " voxels, " << report.max_error_ulp << " ulp");
    return report;
}

/// Computes a field and compares it with the reference; the band must contain samples.
inline reference::CheckReport check_exact(const Mesh& mesh, const Grid& grid, const Band& band,
                                          const Accuracy& accuracy = expected_accuracy()) {
    reference::CheckReport report = check_exact(mesh, compute(mesh, grid, band), accuracy);
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
inline std::vector<std::uint32_t> bits_of(std::span<const float> values) {
    std::vector<std::uint32_t> bits(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) bits[i] = std::bit_cast<std::uint32_t>(values[i]);
    return bits;
}

/// The very bytes of an output are the same.
inline bool same_bytes(const FieldSlab& one, const FieldSlab& other, Output output) {
    return std::ranges::equal(one.bytes(output), other.bytes(output));
}

/// For CallOptions::progress: calls `watch` with the fraction of the samples or points that are done.
template <typename Watch>
std::function<void(const Progress& progress)> when_computing(Watch watch) {
    return [watch](const Progress& progress) mutable {
        if (progress.stage == Progress::Stage::computing) watch(progress.fraction);
    };
}

/// Whether the fields have the same outputs, with the same bytes.
inline bool same_bytes(const Field& one, const Field& other) {
    return std::ranges::all_of(
        output_table(), [&](const OutputInfo& info) { return same_bytes(one.slab(), other.slab(), info.output); });
}

/// The field's values on a part of its grid.
inline Field part_of(const Field& whole, const Grid& part) {
    FieldDescription description = whole;
    description.grid = part;
    Field result(description, whole.outputs());
    const Index3 offset{part.first[0] - whole.grid.first[0], part.first[1] - whole.grid.first[1],
                        part.first[2] - whole.grid.first[2]};
    for (const OutputInfo& info : output_table()) {
        if (!whole.outputs().contains(info.output)) continue;
        const std::size_t bytes = info.sample_bytes();
        std::byte* to = result.bytes(info.output).data();
        const std::size_t row = bytes * static_cast<std::size_t>(part.size[0]);
        for (std::int64_t k = 0; k < part.size[2]; ++k)
            for (std::int64_t j = 0; j < part.size[1]; ++j, to += row) {
                const std::size_t from = whole.grid.offset(offset[0], offset[1] + j, offset[2] + k);
                std::memcpy(to, whole.bytes(info.output).data() + bytes * from, row);
            }
    }
    return result;
}

/// The tests' device as if it allocated no more at once.
inline Device with_largest_allocation(std::size_t bytes) {
    setenv("CLSDF_MAX_ALLOCATION", std::to_string(bytes).c_str(), 1);
    Device device = Device::strongest();
    unsetenv("CLSDF_MAX_ALLOCATION");
    return device;
}

/// The positions of a grid's samples.
inline std::vector<Vec3> samples_of(const Grid& grid) {
    std::vector<Vec3> points;
    for (std::int64_t k = 0; k < grid.size[2]; ++k)
        for (std::int64_t j = 0; j < grid.size[1]; ++j)
            for (std::int64_t i = 0; i < grid.size[0]; ++i) points.push_back(grid.position(i, j, k));
    return points;
}

/// Results of points in the arrays of a field.
inline Field query(const DistanceTransform& transform, std::span<const Vec3> points,
                   double half_width = std::numeric_limits<double>::infinity(), OutputSet outputs = all_outputs()) {
    Field field;
    for (const OutputInfo& info : output_table())
        if (outputs.contains(info.output)) field.resize(info.output, points.size());
    transform.query(points, half_width, field.targets());
    return field;
}

}  // namespace clsdf::test
