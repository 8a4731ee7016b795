#include <clsdf/error.hpp>
#include <clsdf/papers.hpp>

#include "core/parallel.hpp"
#include "papers/site_solids.hpp"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <vector>

// Uses the vectors of the processor, like a program that is compiled for it.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define CLSDF_FOR_THIS_PROCESSOR __attribute__((target_clones("default", "avx2", "avx512f")))
#else
#define CLSDF_FOR_THIS_PROCESSOR
#endif

namespace clsdf {

namespace {

using papers::SiteSolid;

constexpr std::int32_t slices_of_slab = 8;

struct Row {
    float least, most;
};

/// `count` samples from `values` on. The site's coordinates (of a face one) change from sample to sample by their
/// steps.
CLSDF_FOR_THIS_PROCESSOR void scan_face(float* values, std::int32_t count, float first, float step, float limit) {
    for (std::int32_t i = 0; i < count; ++i) {
        const float d = first + static_cast<float>(i) * step;
        values[i] = std::fabs(d) < std::fabs(values[i]) && std::fabs(d) <= limit ? d : values[i];
    }
}

CLSDF_FOR_THIS_PROCESSOR void scan_edge(float* values, std::int32_t count, float x, float x_step, float y, float y_step,
                                        float sign, float limit) {
    for (std::int32_t i = 0; i < count; ++i) {
        const float a = x + static_cast<float>(i) * x_step, b = y + static_cast<float>(i) * y_step;
        const float d = std::sqrt(a * a + b * b);
        values[i] = d < std::fabs(values[i]) && d <= limit ? sign * d : values[i];
    }
}

CLSDF_FOR_THIS_PROCESSOR void scan_vertex(float* values, std::int32_t count, float x, float across_squared, float sign,
                                          float limit) {
    for (std::int32_t i = 0; i < count; ++i) {
        const float a = x + static_cast<float>(i);
        const float d = std::sqrt(a * a + across_squared);
        values[i] = d < std::fabs(values[i]) && d <= limit ? sign * d : values[i];
    }
}

/// Scan conversion of solids into slabs of a field in voxels.
class Converter {
public:
    Converter(const Grid& grid, float half_width, std::span<float> field)
        : size_{static_cast<std::int32_t>(grid.size[0]), static_cast<std::int32_t>(grid.size[1]),
                static_cast<std::int32_t>(grid.size[2])},
          half_width_(half_width),
          // Several times the rounding of floats of this size.
          slack_(1e-5F + 4e-6F * half_width),
          field_(field),
          rows_(static_cast<std::size_t>(grid.size[1])) {}

    /// The slices of the grid that cut a solid: [begin, end).
    std::pair<std::int32_t, std::int32_t> slices_of(const SiteSolid& solid) const {
        const auto [low, high] = heights_of(solid);
        const auto begin = static_cast<std::int32_t>(std::ceil(low - slack_)) + solid.origin[2];
        const auto end = static_cast<std::int32_t>(std::floor(high + slack_)) + solid.origin[2] + 1;
        return {std::max(begin, 0), std::min(end, size_[2])};
    }

    void convert(const SiteSolid& solid, std::int32_t begin, std::int32_t end, SoftwareScanCounts& counts) {
        const auto [low, high] = heights_of(solid);
        for (std::int32_t k = begin; k < end; ++k) {
            const auto z = static_cast<float>(k - solid.origin[2]);
            // A slice along an end of the solid cuts just inside it.
            const float inset = std::min(slack_, 0.25F * (high - low));
            cut(solid, std::clamp(z, low + inset, high - inset));
            if (!(least_y_ <= most_y_)) continue;
            ++counts.intersections;
            scan(solid, k, counts);
        }
    }

private:
    static std::pair<float, float> heights_of(const SiteSolid& solid) {
        float low = solid.corners[0][2], high = low;
        for (std::size_t i = 1; i < solid.corner_count(); ++i) {
            low = std::min(low, solid.corners[i][2]);
            high = std::max(high, solid.corners[i][2]);
        }
        return {low, high};
    }

    struct Point {
        float x, y;
    };

    /// The polygon in which the plane at `z` cuts the solid: a segment of each face that it cuts.
    void cut(const SiteSolid& solid, float z) {
        segments_.clear();
        least_y_ = std::numeric_limits<float>::infinity();
        most_y_ = -least_y_;
        const std::size_t n = solid.sides;
        if (solid.shape == SiteSolid::Shape::prism) {
            cut_polygon(solid, z, 0, n);
            cut_polygon(solid, z, n, n);
            for (std::size_t i = 0; i < n; ++i) {
                const std::size_t next = i + 1 < n ? i + 1 : 0;
                begin_face();
                cut_edge(solid, z, i, next);
                cut_edge(solid, z, next, n + next);
                cut_edge(solid, z, n + next, n + i);
                cut_edge(solid, z, n + i, i);
                end_face();
            }
        } else {
            cut_polygon(solid, z, 1, n);
            for (std::size_t i = 0; i < n; ++i) {
                const std::size_t next = i + 1 < n ? i + 1 : 0;
                begin_face();
                cut_edge(solid, z, 0, 1 + i);
                cut_edge(solid, z, 1 + i, 1 + next);
                cut_edge(solid, z, 1 + next, 0);
                end_face();
            }
        }
    }

    void cut_polygon(const SiteSolid& solid, float z, std::size_t first, std::size_t count) {
        begin_face();
        for (std::size_t i = 0; i < count; ++i) cut_edge(solid, z, first + i, first + (i + 1 < count ? i + 1 : 0));
        end_face();
    }

    void begin_face() { crossings_ = 0; }

    void cut_edge(const SiteSolid& solid, float z, std::size_t from, std::size_t to) {
        const std::array<float, 3>& a = solid.corners[from];
        const std::array<float, 3>& b = solid.corners[to];
        if ((a[2] < z) == (b[2] < z) || crossings_ == 2) return;
        const float t = (z - a[2]) / (b[2] - a[2]);
        crossing_[crossings_++] = {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])};
    }

    void end_face() {
        if (crossings_ < 2) return;
        segments_.push_back(crossing_);
        for (const Point& point : crossing_) {
            least_y_ = std::min(least_y_, point.y);
            most_y_ = std::max(most_y_, point.y);
        }
    }

    /// The rows of the polygon, and their samples.
    void scan(const SiteSolid& solid, std::int32_t k, SoftwareScanCounts& counts) {
        const std::int32_t origin_y = solid.origin[1];
        const std::int32_t begin = std::max(static_cast<std::int32_t>(std::ceil(least_y_ - slack_)) + origin_y, 0);
        const std::int32_t end =
            std::min(static_cast<std::int32_t>(std::floor(most_y_ + slack_)) + origin_y + 1, size_[1]);
        if (begin >= end) return;
        constexpr float far = std::numeric_limits<float>::infinity();
        std::fill(rows_.begin() + begin, rows_.begin() + end, Row{far, -far});
        for (const auto& [p, q] : segments_) {
            const Point& low = p.y <= q.y ? p : q;
            const Point& high = p.y <= q.y ? q : p;
            const std::int32_t first = std::max(static_cast<std::int32_t>(std::ceil(low.y - slack_)) + origin_y, begin);
            const std::int32_t last =
                std::min(static_cast<std::int32_t>(std::floor(high.y + slack_)) + origin_y + 1, end);
            const float height = high.y - low.y;
            const float slope = height > 0 ? (high.x - low.x) / height : 0;
            for (std::int32_t j = first; j < last; ++j) {
                Row& row = rows_[static_cast<std::size_t>(j)];
                if (!(height > slack_)) {
                    row.least = std::min({row.least, low.x, high.x});
                    row.most = std::max({row.most, low.x, high.x});
                    continue;
                }
                const float up = std::clamp(static_cast<float>(j - origin_y) - low.y, 0.0F, height);
                const float x = low.x + slope * up;
                row.least = std::min(row.least, x);
                row.most = std::max(row.most, x);
            }
        }
        for (std::int32_t j = begin; j < end; ++j) {
            const Row& row = rows_[static_cast<std::size_t>(j)];
            if (!(row.least <= row.most)) continue;
            const std::int32_t left =
                std::max(static_cast<std::int32_t>(std::ceil(row.least - slack_)) + solid.origin[0], 0);
            const std::int32_t right =
                std::min(static_cast<std::int32_t>(std::floor(row.most + slack_)) + solid.origin[0] + 1, size_[0]);
            if (left >= right) continue;
            counts.distances += static_cast<std::size_t>(right - left);
            scan_row(solid, left, right - left, j, k);
        }
    }

    void scan_row(const SiteSolid& solid, std::int32_t i, std::int32_t count, std::int32_t j, std::int32_t k) {
        float* const values =
            field_.data() +
            (static_cast<std::size_t>(k) * static_cast<std::size_t>(size_[1]) + static_cast<std::size_t>(j)) *
                static_cast<std::size_t>(size_[0]) +
            i;
        const float x = static_cast<float>(i - solid.origin[0]) - solid.point[0];
        const float y = static_cast<float>(j - solid.origin[1]) - solid.point[1];
        const float z = static_cast<float>(k - solid.origin[2]) - solid.point[2];
        const auto along = [&](const std::array<float, 3>& axis) { return axis[0] * x + axis[1] * y + axis[2] * z; };
        switch (solid.site) {
            case SiteSolid::Site::face:
                scan_face(values, count, along(solid.axes[0]), solid.axes[0][0], half_width_);
                break;
            case SiteSolid::Site::edge:
                scan_edge(values, count, along(solid.axes[0]), solid.axes[0][0], along(solid.axes[1]), solid.axes[1][0],
                          solid.sign, half_width_);
                break;
            default:
                scan_vertex(values, count, x, y * y + z * z, solid.sign, half_width_);
        }
    }

    std::array<std::int32_t, 3> size_;
    float half_width_;
    float slack_;  ///< voxels by which polygons are enlarged, so that no sample between two neighbours is lost
    std::span<float> field_;
    std::vector<Row> rows_;
    std::vector<std::array<Point, 2>> segments_;
    std::array<Point, 2> crossing_{};
    std::size_t crossings_ = 0;
    float least_y_ = 0;
    float most_y_ = 0;
};

/// The solids of each slab.
struct SlabLists {
    std::vector<std::size_t> starts;
    std::vector<std::uint32_t> solids;
};

SlabLists lists_of(const std::vector<SiteSolid>& solids, const Converter& converter, std::size_t slabs) {
    SlabLists lists;
    lists.starts.assign(slabs + 1, 0);
    std::vector<std::pair<std::int32_t, std::int32_t>> ranges(solids.size());
    for_each_index(
        solids.size(),
        [&](std::size_t i) {
            if (solids[i].shape == SiteSolid::Shape::none) return;
            const auto [begin, end] = converter.slices_of(solids[i]);
            if (begin < end) ranges[i] = {begin / slices_of_slab, (end - 1) / slices_of_slab + 1};
        },
        4096);
    for (const auto& [begin, end] : ranges)
        for (std::int32_t slab = begin; slab < end; ++slab) ++lists.starts[static_cast<std::size_t>(slab) + 1];
    for (std::size_t slab = 0; slab < slabs; ++slab) lists.starts[slab + 1] += lists.starts[slab];
    lists.solids.resize(lists.starts.back());
    std::vector<std::size_t> next(lists.starts.begin(), lists.starts.end() - 1);
    for (std::size_t i = 0; i < ranges.size(); ++i)
        for (std::int32_t slab = ranges[i].first; slab < ranges[i].second; ++slab)
            lists.solids[next[static_cast<std::size_t>(slab)]++] = static_cast<std::uint32_t>(i);
    return lists;
}

/// From voxels to the mesh's units; samples without a distance get the half width, and the sign of those before them.
void finish(const Grid& grid, float half_width, std::span<float> field) {
    const auto length = static_cast<std::size_t>(grid.size[0]);
    const std::size_t rows = field.size() / length;
    std::vector<float> signs(rows);  // sign of each row's first sample; 0 if no sample of the row has a distance
    for_each_index(
        rows,
        [&](std::size_t row) {
            const std::span<const float> values = field.subspan(row * length, length);
            const auto known = std::find_if(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
            signs[row] = known == values.end() ? 0.0F : std::copysign(1.0F, *known);
        },
        256);
    const auto height = static_cast<std::size_t>(grid.size[1]);
    for (std::size_t row = 0; row < rows; ++row) {
        if (signs[row] != 0) continue;
        // The row before, or that at the same place of the slice before.
        signs[row] = row % height > 0 ? signs[row - 1] : row > 0 ? signs[row - height] : 1.0F;
    }
    const auto voxel = static_cast<float>(grid.voxel());
    for_each_index(
        rows,
        [&](std::size_t row) {
            float sign = signs[row];
            for (float& value : field.subspan(row * length, length)) {
                if (std::isfinite(value)) {
                    sign = std::copysign(1.0F, value);
                    value = value * voxel + 0.0F;  // no negative zero
                } else {
                    value = sign * half_width;
                }
            }
        },
        256);
}

}  // namespace

SoftwareScanCounts software_scan(const Mesh& mesh, const Grid& grid, double half_width, std::size_t threads,
                                 std::span<float> distance) {
    if (grid.spacing[0] != grid.spacing[1] || grid.spacing[0] != grid.spacing[2])
        throw Error(ErrorCode::unsupported, "the scan conversion in software needs equal spacing on all axes");
    if (!(half_width > 0) || !std::isfinite(half_width))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("the half width is {}; it must be positive and finite", half_width));
    if (distance.size() != grid.sample_count())
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("there is room for {} distances, and the grid has {} samples", distance.size(),
                                grid.sample_count()));
    SoftwareScanCounts total;
    tbb::task_arena arena(threads == 0 ? tbb::task_arena::automatic : static_cast<int>(threads));
    arena.execute([&] {
        const std::vector<SiteSolid> solids = papers::site_solids(mesh, grid, half_width);
        total.polyhedra = static_cast<std::size_t>(std::count_if(
            solids.begin(), solids.end(), [](const SiteSolid& s) { return s.shape != SiteSolid::Shape::none; }));
        const auto width = static_cast<float>(half_width / grid.voxel());
        const auto slabs = static_cast<std::size_t>((grid.size[2] + slices_of_slab - 1) / slices_of_slab);
        const SlabLists lists = lists_of(solids, Converter(grid, width, distance), slabs);
        std::atomic<std::size_t> intersections{0}, distances{0};
        const auto slice = static_cast<std::size_t>(grid.size[0] * grid.size[1]);
        for_each_range(
            slabs,
            [&](std::size_t from, std::size_t to) {
                Converter converter(grid, width, distance);
                SoftwareScanCounts counts;
                for (std::size_t slab = from; slab != to; ++slab) {
                    const auto first = static_cast<std::int32_t>(slab) * slices_of_slab;
                    const std::int32_t last = std::min(first + slices_of_slab, static_cast<std::int32_t>(grid.size[2]));
                    std::fill_n(distance.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(first) * slice),
                                static_cast<std::size_t>(last - first) * slice, std::numeric_limits<float>::infinity());
                    for (std::size_t n = lists.starts[slab]; n < lists.starts[slab + 1]; ++n) {
                        const SiteSolid& solid = solids[lists.solids[n]];
                        const auto [begin, end] = converter.slices_of(solid);
                        converter.convert(solid, std::max(begin, first), std::min(end, last), counts);
                    }
                }
                intersections += counts.intersections;
                distances += counts.distances;
            },
            1);
        total.intersections = intersections;
        total.distances = distances;
        finish(grid, static_cast<float>(half_width), distance);
    });
    return total;
}

}  // namespace clsdf
