#include "plan/restriction.hpp"

#include <clsdf/error.hpp>

#include "layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace clsdf::engine {

namespace {

std::string text_of(const Box& box) {
    const auto& [lower, upper] = box;
    return fmt::format("({}, {}, {}) to ({}, {}, {})", lower[0], lower[1], lower[2], upper[0], upper[1], upper[2]);
}

bool is_within(const Box& box, const Box& other, double slack) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (!(box.lower[axis] >= other.lower[axis] - slack && box.upper[axis] <= other.upper[axis] + slack))
            return false;
    return true;
}

/// The square of the distance between two boxes' centres.
double square_between(const Box& a, const Box& b) {
    double square = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double difference = (a.lower[axis] + a.upper[axis] - b.lower[axis] - b.upper[axis]) / 2;
        square += difference * difference;
    }
    return square;
}

std::vector<Box> boxes_of(const std::vector<Region>& regions) {
    std::vector<Box> boxes;
    boxes.reserve(regions.size());
    for (const Region& region : regions) boxes.push_back(region.box);
    return boxes;
}

}  // namespace

Restriction::Restriction(std::vector<Region> regions_in) : regions(std::move(regions_in)), index_(boxes_of(regions)) {}

std::size_t Restriction::host_bytes() const {
    return numbers.size() * sizeof(numbers[0]) + sample.size() * sizeof(sample[0]);
}

Restriction::NearBoxes Restriction::near_boxes(SignRule sign, double joined) const {
    // Up to the grids' outermost bricks and the slack of their tests, which is far less than a sample.
    NearBoxes near;
    for (const Region& region : regions) {
        near.boxes.push_back(widened(region.box, region.half_width * (1 + 1e-3) + (CLSDF_BRICK + 1) * region.spacing));
        if (sign == SignRule::none) continue;
        // The sweep's rows are those of the grid's bricks: see box_near_rows().
        near.rows.push_back(widened(region.box, (CLSDF_BRICK + 1) * region.spacing + joined));
        near.rows.back().lower[0] = -infinite_length;
    }
    return near;
}

NearRecords Restriction::near(const ClusterIndex& index, SignRule sign, double joined) {
    const auto [boxes, rows] = near_boxes(sign, joined);
    NearRecords near = index.near(boxes);
    record_count = near.face_count + near.site_count;
    if (sign != SignRule::none) {
        const NearRecords crossed = index.near(rows);
        near.faces.insert(near.faces.end(), crossed.faces.begin(), crossed.faces.end());
    }
    if (near.faces.empty()) near.faces.push_back({0, 1});  // a mesh has a triangle
    return near;
}

NearRecords Restriction::near_bricks(const ClusterIndex& index, const Vec3& origin, const Vec3& spacing) const {
    // The slack of their tests is far less than the longest spacing.
    const double slack = *std::max_element(spacing.begin(), spacing.end());
    std::vector<Box> boxes;  // near the bricks with samples in the regions
    for (const Region& region : regions) {
        Box box;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double size = CLSDF_BRICK * spacing[axis];
            // Samples may lie beyond it by the rounding of their positions.
            const auto brick = [&](double position, double slack_of_sample) {
                return std::floor((position - origin[axis] + slack_of_sample * spacing[axis]) / size);
            };
            box.lower[axis] = origin[axis] + brick(region.box.lower[axis], -1e-3) * size;
            box.upper[axis] = origin[axis] + (brick(region.box.upper[axis], 1e-3) + 1) * size;
        }
        boxes.push_back(widened(box, region.half_width * (1 + 1e-3) + slack));
    }
    return index.near(boxes);
}

bool Restriction::holds(const Box& box, double half_width, double spacing, double slack) const {
    return index_.any(widened(box, slack), [&](std::size_t n) {
        const Region& region = regions[n];
        return half_width <= region.half_width && spacing <= region.spacing && is_within(box, region.box, slack);
    });
}

void Restriction::refuse(const std::string& what, const Box& box) const {
    const Region& nearest = *std::min_element(regions.begin(), regions.end(), [&](const Region& a, const Region& b) {
        return square_between(a.box, box) < square_between(b.box, box);
    });
    throw Error(
        ErrorCode::invalid_argument,
        fmt::format("{}, and the transform is restricted: the nearest of its {} regions is the box from {}, for "
                    "half widths up to {} and spacings up to {}; restrict the whole transform to more",
                    what, regions.size(), text_of(nearest.box), nearest.half_width, nearest.spacing));
}

void Restriction::check(const Grid& grid, const Band& band, SignRule sign, const char* what) const {
    const Box samples{grid.position(0, 0, 0), grid.position(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1)};
    const double longest = *std::max_element(grid.spacing.begin(), grid.spacing.end());
    const double widest = sign == SignRule::none ? band.outside : band.widest();
    // Samples are as far off as their positions are rounded.
    if (!holds(samples, widest, longest, 1e-6 * longest))
        refuse(fmt::format("{} reach from {}, its spacing is {} and the band's half width {}", what, text_of(samples),
                           longest, widest),
               samples);
}

void Restriction::check(std::span<const Vec3> points, double half_width, std::size_t first) const {
    for (std::size_t i = 0; i < points.size(); ++i)
        if (const Box box{points[i], points[i]}; !holds(box, half_width, 0, 0))
            refuse(fmt::format("point {} lies at ({}, {}, {}) and is looked up within {}", first + i, points[i][0],
                               points[i][1], points[i][2], half_width),
                   box);
}

void Restriction::check(std::span<const Box> boxes, double half_width) const {
    for (std::size_t i = 0; i < boxes.size(); ++i)
        if (!holds(boxes[i], half_width, 0, 0))
            refuse(fmt::format("box {} reaches from {} and is widened by {}", i, text_of(boxes[i]), half_width),
                   boxes[i]);
}

}  // namespace clsdf::engine
