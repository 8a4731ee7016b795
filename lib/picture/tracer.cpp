#include "picture/tracer.hpp"

#include "core/stopwatch.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace clsdf::picture {
namespace {

constexpr std::size_t piece_bytes = std::size_t{4} << 20U;  // of samples or hits that are handled at a time
constexpr double launch_seconds = 0.08;
constexpr int first_launch_rows = 2;

std::string size_text(std::size_t bytes) {
    return bytes < 1000000 ? fmt::format("{} bytes", bytes) : fmt::format("{} MB", bytes / 1000000);
}

}  // namespace

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
        program_ = context_->program(tracer_kernel_file, tracer_options);
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
        context_->queue().enqueueWriteBuffer(samples_, CL_TRUE, static_cast<std::size_t>(first) * slice * sizeof(float),
                                             values.size_bytes(), values.data());
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
        cl::Kernel kernel(program_, "render_rays");
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
            queue.enqueueReadBuffer(hits, CL_TRUE, 0, rows * columns * sizeof(RenderHit), found.data());
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
