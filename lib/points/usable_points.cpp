#include "points/usable_points.hpp"

#include "frusta/prepared_mesh.hpp"
#include "mesh/mesh_arrays.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace clsdf::points {

namespace {

/// Stores a number in a packed array of floats or doubles.
void store_number(const targets::HostArray& array, std::size_t index, double number) {
    if (array.in_double) {
        std::memcpy(array.data + index * sizeof number, &number, sizeof number);
    } else {
        const auto rounded = static_cast<float>(number);
        std::memcpy(array.data + index * sizeof rounded, &rounded, sizeof rounded);
    }
}

}  // namespace

namespace {

std::string reason_of(bool is_finite, const UsableRange& range) {
    if (!is_finite) return "is not finite";
    return range.is_limit_of_floats ? "lies so far from the mesh that its distance may be beyond the floats"
                                    : "lies more than 1e14 voxels from the mesh, a voxel being 1/256 of the mesh";
}

}  // namespace

void check_half_width(double half_width) {
    if (!(half_width >= 0))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("points are looked up within the half width {}, which must be 0 or more; infinity is "
                                "no limit",
                                half_width));
    if (std::isfinite(half_width) && half_width > static_cast<double>(std::numeric_limits<float>::max()))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("points are looked up within the half width {}, which is beyond the floats that "
                                "distances are given in; infinity is no limit",
                                half_width));
}

UsableRange usable_range(const Box& box) {
    const double longest = box.longest_side();
    const double far_voxels = engine::farthest * (longest > 0 ? longest / 256 : 1);
    constexpr double most = std::numeric_limits<float>::max() / 4;  // distances of a point and a mesh in it are floats
    const double far = std::min(far_voxels, most);
    UsableRange range{box, far_voxels >= most};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        range.limits.lower[axis] = box.lower[axis] - far;
        range.limits.upper[axis] = box.upper[axis] + far;
    }
    return range;
}

void refuse_unusable(const UnusablePoints& unusable, const UsableRange& range) {
    const Vec3& p = unusable.position;
    throw Error(ErrorCode::invalid_argument,
                fmt::format("point {}, counted from 0, at ({}, {}, {}) {}; leave it out", unusable.first, p[0], p[1],
                            p[2], reason_of(unusable.are_finite, range)));
}

std::string warning_of(const std::array<UnusablePoints, 2>& unusable, std::size_t all, const UsableRange& range,
                       double half_width) {
    std::string text;
    for (const UnusablePoints& points : unusable) {
        if (points.count == 0) continue;
        const Vec3& p = points.position;
        const std::string distance =
            points.are_finite && std::isfinite(half_width) ? fmt::format("the half width, {}", half_width) : "NaN";
        text += fmt::format(
            "{}{} of {} points {} no triangle and the distance {}; the first, point {}, counted from 0, at ({}, {}, "
            "{}), "
            "{}",
            text.empty() ? "" : "; ", points.count, all, points.count == 1 ? "has" : "have", distance, points.first,
            p[0], p[1], p[2], reason_of(points.are_finite, range));
    }
    return text;
}

void UsablePoints::find(const Box& box) {
    range_ = usable_range(box);
    const Box& limits = range_.limits;
    unusable_.clear();
    first_usable_ = 0;
    for (std::size_t i = 0; i < given_.size(); ++i) {
        const Vec3& p = given_[i];
        bool is_usable = true;
        for (std::size_t axis = 0; axis < 3; ++axis)
            is_usable = is_usable && p[axis] >= limits.lower[axis] && p[axis] <= limits.upper[axis];
        if (is_usable) continue;
        unusable_.push_back({i, is_finite(p)});
        if (are_refused_) refuse_unusable({is_finite(p), 1, i, p}, range_);
    }
    if (unusable_.empty()) return;
    // A point before or behind, which costs least.
    replaced_.assign(given_.begin(), given_.end());
    while (first_usable_ < unusable_.size() && unusable_[first_usable_].index == first_usable_) ++first_usable_;
    const Vec3 first = first_usable_ < given_.size() ? given_[first_usable_] : box.lower;
    for (const Unusable& unusable : unusable_)
        replaced_[unusable.index] = unusable.index == 0 ? first : replaced_[unusable.index - 1];
}

void UsablePoints::store(std::size_t begin, std::size_t count, double half_width,
                         const targets::HostArrays& arrays) const {
    const auto first = std::ranges::lower_bound(unusable_, begin, {}, &Unusable::index);
    for (auto unusable = first; unusable != unusable_.end() && unusable->index < begin + count; ++unusable) {
        const std::size_t at = unusable->index - begin;
        for_each_output(
            [&](const OutputInfo& info, const targets::HostArray& array) {
                if (array.data == nullptr) return;
                const std::size_t bytes = sample_bytes(info, array.in_double);
                if (info.output == Output::distance)
                    store_number(array, at,
                                 unusable->is_finite && std::isfinite(half_width)
                                     ? half_width
                                     : std::numeric_limits<double>::quiet_NaN());
                else
                    std::memset(array.data + at * bytes, 0xFF, bytes);
            },
            arrays);
    }
}

std::string UsablePoints::warning(double half_width) const {
    std::array<UnusablePoints, 2> found{UnusablePoints{false}, UnusablePoints{true}};
    for (UnusablePoints& points : found) {
        points.count = static_cast<std::size_t>(std::ranges::count(unusable_, points.are_finite, &Unusable::is_finite));
        if (points.count == 0) continue;
        points.first = std::ranges::find(unusable_, points.are_finite, &Unusable::is_finite)->index;
        points.position = given_[points.first];
    }
    return warning_of(found, given_.size(), range_, half_width);
}

}  // namespace clsdf::points
