#include "acceptance/calls.hpp"

#include "acceptance/run.hpp"
#include "support/point_contract.hpp"
#include "support/random_meshes.hpp"

#include <clsdf/reference.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <random>
#include <span>
#include <vector>

namespace clsdf::acceptance {

namespace {

constexpr std::int64_t block_side = 12;

/// At the grid's lower end (0), in its middle (1) or at its upper end (2).
Grid block_of(const Grid& grid, std::int64_t place) {
    Index3 first{}, size{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        size[axis] = std::min(grid.size[axis], block_side);
        first[axis] = grid.first[axis] + place * (grid.size[axis] - size[axis]) / 2;
    }
    return grid.block(first, size);
}

/// A sample of the band, counted from the field's first one: from a seeded place on, the first that is within a voxel
/// of the surface, or else the first of the band. Nothing if the band has no sample.
std::optional<Index3> band_sample(const Field& field) {
    const std::size_t count = field.triangle().size();
    const double voxel = *std::max_element(field.grid.spacing.begin(), field.grid.spacing.end());
    const std::size_t start = std::mt19937_64(1)() % count;
    std::optional<std::size_t> found;
    for (std::size_t n = 0; n < count; ++n) {
        const std::size_t i = (start + n) % count;
        if (field.triangle()[i] == no_triangle) continue;
        const bool is_near = std::fabs(static_cast<double>(field.distance()[i])) <= voxel;
        if (is_near || !found) found = i;
        if (is_near) break;
    }
    if (!found) return std::nullopt;
    const auto [nx, ny, nz] = field.grid.size;
    const auto i = static_cast<std::int64_t>(*found);
    return Index3{i % nx, i / nx % ny, i / nx / ny};
}

/// Around a sample of the band, within the field's grid.
Grid band_block(const Field& field) {
    const std::optional<Index3> centre = band_sample(field);
    if (!centre) return block_of(field.grid, 1);
    const Grid& grid = field.grid;
    Index3 first{}, size{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        size[axis] = std::min(grid.size[axis], block_side);
        first[axis] = grid.first[axis] +
                      std::clamp<std::int64_t>((*centre)[axis] - size[axis] / 2, 0, grid.size[axis] - size[axis]);
    }
    return grid.block(first, size);
}

/// A block of the grid's lattice around the vertex that is nearest to a sample, among a thousand vertices: in the grid
/// or beyond it.
Grid vertex_block(const Mesh& mesh, const Grid& grid) {
    test::Random random(1);
    double least = std::numeric_limits<double>::infinity();
    Index3 first{};
    for (int n = 0; n < 1000; ++n) {
        const Triangle& triangle = mesh.triangles()[random.index(mesh.triangles().size())];
        const Vec3& vertex = mesh.vertices()[triangle[random.index(3)]];
        Index3 nearest{};
        double squared = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double steps = (vertex[axis] - grid.origin[axis]) / grid.spacing[axis];
            nearest[axis] = std::llround(steps);
            squared += std::pow((steps - std::round(steps)) * grid.spacing[axis], 2);
        }
        if (!(squared < least)) continue;
        least = squared;
        for (std::size_t axis = 0; axis < 3; ++axis) first[axis] = nearest[axis] - block_side / 2;
    }
    return grid.block(first, {block_side, block_side, block_side});
}

std::string nothing_in_band(const char* call) {
    return fmt::format("{}: no sample of the block is in the band", call);
}

bool has_band_sample(const Field& part) {
    return std::any_of(part.triangle().begin(), part.triangle().end(),
                       [](std::uint32_t triangle) { return triangle != no_triangle; });
}

/// Values of a block, in any output, that differ from those of the whole field.
std::size_t differences(const Field& field, const Field& part) {
    std::size_t count = 0;
    for (const OutputInfo& info : output_table()) {
        const std::span<const std::byte> of_field = field.bytes(info.output), of_part = part.bytes(info.output);
        const Grid& block = part.grid;
        const std::size_t width = of_field.empty() ? 0 : info.sample_bytes();
        if (of_part.size() != width * block.sample_count()) {
            ++count;
            continue;
        }
        if (width == 0) continue;
        std::size_t i = 0;
        for (std::int64_t z = 0; z < block.size[2]; ++z)
            for (std::int64_t y = 0; y < block.size[1]; ++y)
                for (std::int64_t x = 0; x < block.size[0]; ++x, i += width) {
                    const std::size_t at = field.grid.offset(block.first[0] - field.grid.first[0] + x,
                                                             block.first[1] - field.grid.first[1] + y,
                                                             block.first[2] - field.grid.first[2] + z);
                    if (std::memcmp(&of_field[width * at], &of_part[i], width) != 0) ++count;
                }
    }
    return count;
}

/// Room for the field's outputs on a block.
Field like(const Field& field, const Grid& block) {
    FieldDescription description = field;
    description.grid = block;
    return Field(description, field.outputs());
}

std::string difference(const char* call, std::size_t count) {
    return count == 0 ? std::string() : fmt::format("{}: {} values have other bytes than the field's", call, count);
}

std::string finding(const char* call, const reference::CheckReport& report) {
    if (report.passed()) return {};
    if (report.findings.empty()) return fmt::format("{}: wrong", call);
    const auto& first = report.findings.front();
    return fmt::format("{}: sample ({}, {}, {}) is {:.9g} instead of {:.17g}: {}", call, first.sample[0],
                       first.sample[1], first.sample[2], first.found, first.expected, first.what);
}

std::string wrong_requests(const DistanceTransform& transform, const Problem& problem, const Field& field) {
    std::array<Field, 3> parts{like(field, block_of(problem.grid, 0)), like(field, band_block(field)),
                               like(field, block_of(problem.grid, 2))};
    std::vector<Request> requests;
    for (Field& part : parts) requests.push_back({part.grid, problem.band, part.targets()});
    transform.compute(requests);
    if (!has_band_sample(parts[1])) return nothing_in_band("requests");
    std::size_t count = 0;
    for (const Field& part : parts) count += differences(field, part);
    return difference("requests", count);
}

std::string wrong_part(const DistanceTransform& transform, const Problem& problem, const Field& field) {
    if (!std::isfinite(problem.band.widest())) return {};
    const Grid block = band_block(field);
    const double spacing = *std::max_element(block.spacing.begin(), block.spacing.end());
    const DistanceTransform part = transform.restrict_to({block.box(), problem.band.widest(), spacing});
    const Field found = part.compute(block, problem.band, field.outputs());
    if (!has_band_sample(found)) return nothing_in_band("restricted");
    return difference("restricted", differences(field, found));
}

std::string wrong_samples(const DistanceTransform& transform, const Problem& problem, const Field& whole,
                          std::size_t samples) {
    Field field = like(whole, band_block(whole));
    field.band = Band::symmetric(problem.band.widest());
    field.sign = transform.sign();
    std::vector<Vec3> points;
    for (std::int64_t z = 0; z < field.grid.size[2]; ++z)
        for (std::int64_t y = 0; y < field.grid.size[1]; ++y)
            for (std::int64_t x = 0; x < field.grid.size[0]; ++x) points.push_back(field.grid.position(x, y, z));
    transform.query(points, field.band.outside, field.targets());
    if (!has_band_sample(field)) return nothing_in_band("points at samples");
    // A voxel of points is 1/256 of the mesh.
    const double voxel = problem.mesh.box().longest_side() / 256;
    reference::CheckOptions options;
    options.samples = samples;
    options.tolerance_voxels = judged_voxels * (voxel > 0 ? voxel / field.grid.voxel() : 1);
    return finding("points at samples", reference::check(problem.mesh, field, options));
}

/// Points that are no samples: four in five on faces or beside them, at most `reach` away on each axis, the others in
/// the mesh's box and a tenth of its side around it.
std::vector<Vec3> points_of(const Mesh& mesh, double reach, std::size_t count) {
    test::Random random(1);
    const Box& box = mesh.box();
    const double margin = 0.1 * box.longest_side();
    std::vector<Vec3> points(count);
    for (std::size_t i = 0; i < count; ++i) {
        const Triangle& triangle = mesh.triangles()[random.index(mesh.triangles().size())];
        const double u = random.uniform(0, 1), v = random.uniform(0, 1 - u);
        const double off = std::array{0.0, 1e-6, 0.03, 1.0}[random.index(4)] * reach;
        const bool is_anywhere = random.index(5) == 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto corner = [&](std::size_t k) { return mesh.vertices()[triangle[k]][axis]; };
            points[i][axis] = is_anywhere ? random.uniform(box.lower[axis] - margin, box.upper[axis] + margin)
                                          : corner(0) + u * (corner(1) - corner(0)) + v * (corner(2) - corner(0)) +
                                                random.uniform(-off, off);
        }
    }
    return points;
}

/// All outputs of points.
Field query(const DistanceTransform& transform, std::span<const Vec3> points, double half_width) {
    Field field;
    for (const OutputInfo& info : output_table()) field.resize(info.output, points.size());
    transform.query(points, half_width, field.targets());
    return field;
}

/// Points that are looked up one by one are held against the reference. The same points among so many that they are
/// scanned in groups have the same bytes.
std::string wrong_points(const DistanceTransform& transform, const Problem& problem, std::size_t samples) {
    const double half_width = problem.band.widest();
    const Mesh& mesh = problem.mesh;
    constexpr std::size_t scanned = 16384;  // or as many as triangles: docs/library.md, 'Points'
    const std::vector<Vec3> points = points_of(mesh, std::min(half_width, 0.1 * mesh.box().longest_side()),
                                               std::max(scanned, mesh.triangles().size()));
    const std::size_t count = samples > 0 ? samples : 1024, step = points.size() / count;
    std::vector<Vec3> chosen(count);
    for (std::size_t i = 0; i < count; ++i) chosen[i] = points[step * i];
    const Field few = query(transform, chosen, half_width), many = query(transform, points, half_width);

    std::size_t different = 0;
    for (const OutputInfo& info : output_table()) {
        const std::size_t bytes = info.sample_bytes();
        for (std::size_t i = 0; i < count; ++i)
            if (std::memcmp(&few.bytes(info.output)[bytes * i], &many.bytes(info.output)[bytes * step * i], bytes) != 0)
                ++different;
    }
    if (different > 0) return fmt::format("points: {} values of many have other bytes than those of few", different);
    if (!has_band_sample(few)) return "points: none is in the band";
    const test::PointContract contract(mesh, transform.sign(), half_width);
    for (std::size_t i = 0; i < count; ++i)
        if (const std::string fault = contract.fault(chosen[i], few, i); !fault.empty())
            return fmt::format("points: ({:.17g}, {:.17g}, {:.17g}): {}", chosen[i][0], chosen[i][1], chosen[i][2],
                               fault);
    return {};
}

std::string wrong_move(DistanceTransform& transform, const Problem& problem, const Field& first, std::size_t samples) {
    const Box& box = problem.mesh.box();
    std::vector<Vec3> positions = problem.mesh.vertices();
    const double c = std::cos(0.3), s = std::sin(0.3);
    for (Vec3& p : positions) {
        const double x = p[0] - (box.lower[0] + box.upper[0]) / 2, y = p[1] - (box.lower[1] + box.upper[1]) / 2;
        p[0] += c * x - s * y - x;
        p[1] += s * x + c * y - y;
    }
    Mesh turned = problem.mesh;
    turned.set_positions(positions);
    transform.set_positions(positions);
    const Field field = transform.compute(vertex_block(turned, problem.grid), problem.band, first.outputs());
    if (!has_band_sample(field)) return nothing_in_band("moved");
    reference::CheckOptions options;
    options.samples = samples;
    options.tolerance_voxels = judged_voxels;
    return finding("moved", reference::check(turned, field, options));
}

}  // namespace

std::string wrong_calls(DistanceTransform& transform, const Problem& problem, const Field& field,
                        const CallChecks& checks) {
    std::string wrong;
    const auto add = [&](const std::string& found) {
        if (!found.empty()) wrong += (wrong.empty() ? "" : "; ") + found;
    };
    add(wrong_requests(transform, problem, field));
    add(wrong_part(transform, problem, field));
    add(wrong_samples(transform, problem, field, checks.samples));
    if (checks.has_points) add(wrong_points(transform, problem, checks.samples));
    add(wrong_move(transform, problem, field, checks.samples));
    return wrong;
}

}  // namespace clsdf::acceptance
