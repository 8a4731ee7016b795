#pragma once

#include "picture/traced_samples.hpp"

#include "render.h"

#include <clsdf/picture.hpp>

#include "device/context.hpp"

#include <functional>
#include <memory>
#include <span>

namespace clsdf::picture {

inline constexpr const char* tracer_kernel_file = "render.cl";
inline constexpr const char* tracer_options = "-cl-std=CL1.2";

/// A field's samples on the device, and the rays that are traced through them.
class Tracer {
public:
    /// Throws Error(out_of_memory) if the samples exceed the device's largest allocation.
    Tracer(const Field& field, const TracedSamples& samples, const Device& device);

    /// Spacing, size and slopes of a view; the rest is the caller's.
    RenderView view() const;

    /// Calls `take(first row, hits)` for rows of rays from the first to the last. No launch lasts much longer than a
    /// tenth of a second. Throws Error(cancelled).
    void trace(const RenderView& view, const std::function<bool()>& should_stop,
               const std::function<void(int first_row, std::span<const RenderHit> hits)>& take) const;

private:
    void copy_to_device(const Field& field, const TracedSamples& samples);

    std::shared_ptr<device::Context> context_;
    cl::Program program_;
    cl::Buffer samples_;
    RenderView view_{};
};

}  // namespace clsdf::picture
