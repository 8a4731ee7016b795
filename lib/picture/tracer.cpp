#include "picture/tracer.hpp"

#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "core/stopwatch.hpp"
#include "device/read_back.hpp"
#include "picture/plane.hpp"

#include "kernel_sources.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace clsdf::picture {

namespace {

struct Range {
    float lower = std::numeric_limits<float>::infinity();
    float upper = -std::numeric_limits<float>::infinity();
    bool negative = false;
    std::size_t first_not_a_number = std::numeric_limits<std::size_t>::max();
};

Range range_of(std::span<const float> values) {
    return reduce_ranges(
        values.size(), usual_grain, Range{},
        [&](std::size_t begin, std::size_t end, Range range) {
            for (std::size_t i = begin; i < end; ++i) {
                const float value = values[i];
                if (std::isnan(value)) range.first_not_a_number = std::min(range.first_not_a_number, i);
                range.negative = range.negative || (std::signbit(value) && !std::isnan(value));
                if (!std::isfinite(value)) continue;
                range.lower = std::min(range.lower, value);
                range.upper = std::max(range.upper, value);
            }
            return range;
        },
        [](const Range& one, const Range& other) {
            return Range{std::min(one.lower, other.lower), std::max(one.upper, other.upper),
                         one.negative || other.negative, std::min(one.first_not_a_number, other.first_not_a_number)};
        });
}

// The least distance of a value beyond the band from the band's limit, in voxels. If the band has only an outside, -0
// inside must become a number below zero.
constexpr double clearly = 1e-6;

}  // namespace

TracedSamples::TracedSamples(const Field& field)
    : field_(field),
      voxel_(field.grid.voxel()),
      inside_(-static_cast<float>(field.band.inside)),
      outside_(static_cast<float>(field.band.outside)) {
    check_field(field);
    const Index3& size = field.grid.size;
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (size[axis] < 2 || size[axis] > std::numeric_limits<std::int32_t>::max())
            refuse(
                "field: its number of samples along {} is {}; a surface needs 2 or more on every "
                "axis, and less than 2^31; draw a flat field with \"clsdf slice\"",
                "xyz"[axis], size[axis]);
    const Range range = range_of(field.distance());
    if (range.first_not_a_number < field.distance().size()) {
        const auto index = static_cast<std::int64_t>(range.first_not_a_number);
        refuse(
            "field: sample ({}, {}, {}) is not a number, so there is no surface to "
            "follow; \"clsdf slice\" draws such fields",
            index % size[0], index / size[0] % size[1], index / size[0] / size[1]);
    }
    // Infinite distances of both signs have a surface between them.
    if (range.lower > range.upper && !range.negative)
        refuse("field: none of its distances is finite, so there is no surface to follow");
    if (range.lower <= range.upper) {
        lower_ = static_cast<double>(range.lower);
        upper_ = static_cast<double>(range.upper);
    }
    is_inside_somewhere_ = range.negative;
    // A file of another program may not state whether its distances have signs.
    has_sign_ = field.sign == SignRule::automatic ? range.negative : field.sign != SignRule::none;
    if (!has_sign_) inside_ = -std::numeric_limits<float>::infinity();
}

bool TracedSamples::has_surface(double level) const {
    // If the band has only an outside, -0 means inside.
    const bool has_below = level == 0 && has_sign_ ? is_inside_somewhere_ : lower_ < level;
    return has_below && upper_ >= level;
}

float TracedSamples::value(std::int64_t i, std::int64_t j, std::int64_t k) const {
    const float value = field_.distance()[field_.grid.offset(i, j, k)];
    return std::clamp(value, static_cast<float>(lower_), static_cast<float>(upper_));
}

double TracedSamples::continued(std::int64_t i, std::int64_t j, std::int64_t k, float own) const {
    const bool is_inside = std::signbit(own) && has_sign_;
    const double side = is_inside ? -1 : 1;
    const double limit = side * static_cast<double>(is_inside ? inside_ : outside_);
    double sum = 0;
    int lines = 0;
    double most = limit + voxel_;  // as seen from the band: distances are taken as positive
    for (std::int64_t dz = -1; dz <= 1; ++dz)
        for (std::int64_t dy = -1; dy <= 1; ++dy)
            for (std::int64_t dx = -1; dx <= 1; ++dx) {
                const Index3 step{dx, dy, dz};
                const Index3 at{i, j, k};
                bool has_near = step != Index3{};
                bool has_far = has_near;
                double squared = 0;
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const std::int64_t size = field_.grid.size[axis];
                    has_near = has_near && at[axis] + step[axis] >= 0 && at[axis] + step[axis] < size;
                    has_far = has_far && at[axis] + 2 * step[axis] >= 0 && at[axis] + 2 * step[axis] < size;
                    const double length = static_cast<double>(step[axis]) * field_.grid.spacing[axis];
                    squared += length * length;
                }
                if (!has_near) continue;
                const float near = value(i + dx, j + dy, k + dz);
                if (!within(near)) continue;
                most = std::min(most, side * static_cast<double>(near) + std::sqrt(squared));
                if (!has_far) continue;
                const float far = value(i + 2 * dx, j + 2 * dy, k + 2 * dz);
                if (!within(far)) continue;
                sum += side * (2 * static_cast<double>(near) - static_cast<double>(far));
                ++lines;
            }
    const double mean = lines == 0 ? limit : sum / lines;
    const double least = limit + (is_inside ? clearly * voxel_ : 0);
    return side * std::max(least, std::min(mean, most));
}

void TracedSamples::write(std::int64_t first, std::int64_t last, std::span<float> values) const {
    const auto& [nx, ny, nz] = field_.grid.size;
    for_each_index(
        static_cast<std::size_t>((last - first) * ny),
        [&, rows = ny, columns = nx](std::size_t index) {
            const auto row = static_cast<std::int64_t>(index);
            const std::int64_t j = row % rows;
            const std::int64_t k = first + row / rows;
            for (std::int64_t i = 0; i < columns; ++i) {
                const float own = value(i, j, k);
                const double drawn = within(own) ? static_cast<double>(own) : continued(i, j, k, own);
                values[static_cast<std::size_t>(row * columns + i)] = static_cast<float>(drawn / voxel_);
            }
        },
        1);
}

std::array<double, 3> TracedSamples::slopes(std::int64_t slices, std::span<const float> values) const {
    using Slopes = std::array<double, 3>;
    const std::int64_t columns = field_.grid.size[0];
    const std::int64_t rows = field_.grid.size[1];
    const std::int64_t strides[] = {1, columns, columns * rows};
    const Slopes steepest = reduce_ranges(
        static_cast<std::size_t>(slices * rows), 1, Slopes{},
        [&](std::size_t begin, std::size_t end, Slopes found) {
            for (auto row = static_cast<std::int64_t>(begin); row < static_cast<std::int64_t>(end); ++row) {
                const bool has_next[] = {false, row % rows + 1 < rows, row / rows + 1 < slices};
                for (std::int64_t i = 0; i < columns; ++i)
                    for (std::size_t axis = 0; axis < 3; ++axis) {
                        if (axis == 0 ? i + 1 == columns : !has_next[axis]) continue;
                        const std::int64_t at = row * columns + i;
                        const double rise = static_cast<double>(values[static_cast<std::size_t>(at + strides[axis])]) -
                                            static_cast<double>(values[static_cast<std::size_t>(at)]);
                        found[axis] = std::max(found[axis], std::abs(rise));
                    }
            }
            return found;
        },
        [](const Slopes& one, const Slopes& other) {
            return Slopes{std::max(one[0], other[0]), std::max(one[1], other[1]), std::max(one[2], other[2])};
        });
    const Vec3& spacing = field_.grid.spacing;
    return {steepest[0] * voxel_ / spacing[0], steepest[1] * voxel_ / spacing[1], steepest[2] * voxel_ / spacing[2]};
}

std::vector<TracedSamples::RowEnds> TracedSamples::rows_below(double level) const {
    const auto& [nx, ny, nz] = field_.grid.size;
    const auto limit = static_cast<float>(level);
    const auto is_below = [&](float value) {
        return value < limit || (level == 0 && has_sign_ && value == 0 && std::signbit(value));
    };
    std::vector<RowEnds> ends;
    for (std::int64_t k = 0; k < nz; ++k)
        for (std::int64_t j = 0; j < ny; ++j) {
            const auto row = field_.distance().subspan(field_.grid.offset(0, j, k), static_cast<std::size_t>(nx));
            const auto first = std::find_if(row.begin(), row.end(), is_below);
            if (first == row.end()) continue;
            const auto last = std::find_if(row.rbegin(), row.rend(), is_below);
            ends.push_back({{first - row.begin(), j, k}, nx - 1 - (last - row.rbegin())});
        }
    return ends;
}

namespace {

constexpr std::size_t piece_bytes = std::size_t{4} << 20U;  // of samples or hits that are handled at a time
constexpr double launch_seconds = 0.08;
constexpr int first_launch_rows = 2;

std::string size_text(std::size_t bytes) {
    return bytes < 1000000 ? fmt::format("{} bytes", bytes) : fmt::format("{} MB", bytes / 1000000);
}

}  // namespace

device::ProgramSource tracer_source() {
    return {"render.cl", "-cl-std=CL1.2", kernels::files};
}

Tracer::Tracer(const Field& field, const TracedSamples& samples, const Device& device)
    : context_(device::shared_context_of(device)) {
    const std::size_t bytes = field.grid.sample_count() * sizeof(float);
    const std::size_t most = context_->capabilities().largest_allocation;
    if (bytes > most)
        throw Error(ErrorCode::out_of_memory,
                    fmt::format("render: the field takes {}, and \"{}\" allocates at most {} at once; choose another "
                                "device, or compute the field with a lower resolution",
                                size_text(bytes), device.name(), size_text(most)));
    device::guarded([&] {
        program_ = context_->program(tracer_source());
        samples_ = cl::Buffer(context_->context(), CL_MEM_READ_ONLY, bytes);
        copy_to_device(field, samples);
    });
    for (std::size_t axis = 0; axis < 3; ++axis) {
        view_.size[axis] = static_cast<clsdf_int32>(field.grid.size[axis]);
        view_.spacing[axis] = static_cast<float>(field.grid.spacing[axis] / field.grid.voxel());
    }
}

// In pieces, which overlap by a slice so that no edge between slices is left out.
void Tracer::copy_to_device(const Field& field, const TracedSamples& samples) {
    const std::size_t slice =
        static_cast<std::size_t>(field.grid.size[0]) * static_cast<std::size_t>(field.grid.size[1]);
    const std::int64_t slices = field.grid.size[2];
    const auto most = static_cast<std::int64_t>(std::max<std::size_t>(2, piece_bytes / (slice * sizeof(float))));
    std::vector<float> piece(slice * static_cast<std::size_t>(std::min(most, slices)));
    std::array<double, 3> steepest{};
    for (std::int64_t first = 0; first + 1 < slices;) {
        const std::int64_t last = std::min(first + most, slices);
        const auto values = std::span(piece).first(slice * static_cast<std::size_t>(last - first));
        samples.write(first, last, values);
        const std::array<double, 3> slopes = samples.slopes(last - first, values);
        for (std::size_t axis = 0; axis < 3; ++axis) steepest[axis] = std::max(steepest[axis], slopes[axis]);
        device::write_values(*context_, values, samples_, static_cast<std::size_t>(first) * slice * sizeof(float));
        first = last - 1;
    }
    // Rounding in the kernel must not make a step too long.
    for (std::size_t axis = 0; axis < 3; ++axis) view_.slope[axis] = static_cast<float>(1.00001 * steepest[axis]);
}

RenderView Tracer::view() const {
    return view_;
}

void Tracer::trace(const RenderView& view, const std::function<bool()>& should_stop,
                   const std::function<void(int first_row, std::span<const RenderHit> hits)>& take) const {
    const auto columns = static_cast<std::size_t>(view.columns);
    const std::size_t most_rows = std::max<std::size_t>(1, piece_bytes / (columns * sizeof(RenderHit)));
    const std::size_t group = std::min<std::size_t>(64, context_->capabilities().largest_group);
    const cl::CommandQueue& queue = context_->queue();
    std::vector<RenderHit> found;
    device::guarded([&] {
        device::LentKernel kernel(context_->kernels(), program_, "render_rays");
        cl::Buffer hits;
        std::size_t room = 0;
        std::size_t rows = first_launch_rows;
        for (int first = 0; first < view.rows;) {
            if (should_stop && should_stop()) throw Error(ErrorCode::cancelled, "cancelled; no picture was written");
            rows = std::min({rows, most_rows, static_cast<std::size_t>(view.rows - first)});
            if (rows * columns > room) {
                room = rows * columns;
                hits = cl::Buffer(context_->context(), CL_MEM_WRITE_ONLY, room * sizeof(RenderHit));
                found.resize(room);
            }
            const Stopwatch stopwatch;
            kernel.setArg(0, view);
            kernel.setArg(1, static_cast<cl_int>(first));
            kernel.setArg(2, samples_);
            kernel.setArg(3, hits);
            queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange((columns + group - 1) / group * group, rows),
                                       cl::NDRange(group, 1));
            kernel.note_launch();
            context_->read(queue, hits, 0, rows * columns * sizeof(RenderHit),
                           reinterpret_cast<std::byte*>(found.data()));
            const double seconds = stopwatch.seconds();
            take(first, std::span(found).first(rows * columns));
            first += static_cast<int>(rows);
            // Rows differ, so that the number of rows grows slowly and shrinks at once.
            const double wanted = static_cast<double>(rows) * launch_seconds / std::max(seconds, 1e-6);
            rows = static_cast<std::size_t>(std::clamp(wanted, 1.0, 2.0 * static_cast<double>(rows)));
        }
    });
}

}  // namespace clsdf::picture
