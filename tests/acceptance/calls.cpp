#include "acceptance/calls.hpp"

#include "acceptance/run.hpp"

#include <clsdf/reference.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <vector>

namespace clsdf::acceptance {

namespace {

constexpr std::int64_t block_side = 12;

/// Of the grid, at its lower end (0), in the middle (1) or at its upper end (2).
Grid block_of(const Grid& grid, std::int64_t place) {
    Index3 first{}, size{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        size[axis] = std::min(grid.size[axis], block_side);
        first[axis] = grid.first[axis] + place * (grid.size[axis] - size[axis]) / 2;
    }
    return grid.block(first, size);
}

/// Values of a block, in any output, that differ from those of the whole field.
std::size_t differences(const Field& field, const Field& part) {
    std::size_t count = 0;
    visit_outputs(
        [&](const char*, const auto& of_field, const auto& of_part) {
            const std::size_t components = of_field.size() / field.distance.size();
            const Grid& block = part.grid;
            if (of_part.size() != components * block.sample_count()) {
                ++count;
                return;
            }
            std::size_t i = 0;
            for (std::int64_t z = 0; z < block.size[2]; ++z)
                for (std::int64_t y = 0; y < block.size[1]; ++y)
                    for (std::int64_t x = 0; x < block.size[0]; ++x, i += components) {
                        const std::size_t at = field.grid.offset(block.first[0] - field.grid.first[0] + x,
                                                                 block.first[1] - field.grid.first[1] + y,
                                                                 block.first[2] - field.grid.first[2] + z);
                        if (components > 0 &&
                            std::memcmp(&of_field[components * at], &of_part[i], components * sizeof(of_part[0])) != 0)
                            ++count;
                    }
        },
        field, part);
    return count;
}

/// Room for the field's outputs on a block.
Field like(const Field& field, const Grid& block) {
    Field part;
    part.grid = block;
    part.band = field.band;
    part.sign = field.sign;
    visit_outputs(
        [&](const char*, const auto& of_field, auto& of_part) {
            of_part.resize(of_field.size() / field.distance.size() * block.sample_count());
        },
        field, part);
    return part;
}

Outputs outputs_of(const Field& field) {
    Outputs outputs;
    visit_extras([](const char*, const auto& values, bool& wanted) { wanted = !values.empty(); }, field, outputs);
    return outputs;
}

OutputTargets targets_of(Field& field) {
    OutputTargets targets;
    visit_outputs(
        [](const char*, auto& values, OutputTarget& target) {
            if (!values.empty()) target = values;
        },
        field, targets);
    return targets;
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
    std::array<Field, 3> parts;
    std::vector<Request> requests;
    for (std::size_t n = 0; n < parts.size(); ++n) {
        parts[n] = like(field, block_of(problem.grid, static_cast<std::int64_t>(n)));
        requests.push_back({parts[n].grid, problem.band, targets_of(parts[n])});
    }
    transform.compute(requests);
    std::size_t count = 0;
    for (const Field& part : parts) count += differences(field, part);
    return difference("requests", count);
}

std::string wrong_part(const DistanceTransform& transform, const Problem& problem, const Field& field) {
    if (!std::isfinite(problem.band.widest())) return {};
    const Grid block = block_of(problem.grid, 1);
    const Box box{block.position(0, 0, 0), block.position(block.size[0] - 1, block.size[1] - 1, block.size[2] - 1)};
    const double spacing = *std::max_element(block.spacing.begin(), block.spacing.end());
    const DistanceTransform part = transform.restrict_to(box, problem.band.widest(), spacing);
    return difference("restricted", differences(field, part(block, problem.band, outputs_of(field))));
}

std::string wrong_points(const DistanceTransform& transform, const Problem& problem, const Field& whole) {
    Field field = like(whole, block_of(problem.grid, 1));
    field.band = Band::symmetric(problem.band.outside);
    field.sign = transform.sign();
    std::vector<Vec3> points;
    for (std::int64_t z = 0; z < field.grid.size[2]; ++z)
        for (std::int64_t y = 0; y < field.grid.size[1]; ++y)
            for (std::int64_t x = 0; x < field.grid.size[0]; ++x) points.push_back(field.grid.position(x, y, z));
    transform.query(points, field.band.outside, targets_of(field));
    // A voxel of points is 1/256 of the mesh.
    const double voxel = problem.mesh.box().longest_side() / 256;
    reference::CheckOptions options;
    options.samples = 0;
    options.tolerance_voxels = judged_voxels * (voxel > 0 ? voxel / field.grid.voxel() : 1);
    return finding("points", reference::check(problem.mesh, field, options));
}

std::string wrong_move(DistanceTransform& transform, const Problem& problem, const Field& first) {
    const Box& box = problem.mesh.box();
    std::vector<Vec3> positions = problem.mesh.vertices();
    const double c = std::cos(0.3), s = std::sin(0.3);
    for (Vec3& p : positions) {
        const double x = p[0] - (box.lower[0] + box.upper[0]) / 2, y = p[1] - (box.lower[1] + box.upper[1]) / 2;
        p[0] += c * x - s * y - x;
        p[1] += s * x + c * y - y;
    }
    Mesh turned = problem.mesh;
    turned.move(positions);
    transform.move(positions);
    const Field field = transform(block_of(problem.grid, 1), problem.band, outputs_of(first));
    reference::CheckOptions options;
    options.samples = 0;
    options.tolerance_voxels = judged_voxels;
    return finding("moved", reference::check(turned, field, options));
}

}  // namespace

std::string wrong_calls(DistanceTransform& transform, const Problem& problem, const Field& field) {
    std::string wrong;
    const auto add = [&](const std::string& found) {
        if (!found.empty()) wrong += (wrong.empty() ? "" : "; ") + found;
    };
    add(wrong_requests(transform, problem, field));
    add(wrong_part(transform, problem, field));
    add(wrong_points(transform, problem, field));
    add(wrong_move(transform, problem, field));
    return wrong;
}

}  // namespace clsdf::acceptance
