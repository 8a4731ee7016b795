#pragma once

#include "device/context.hpp"
#include "launch/programs.hpp"

#include "render.h"

#include <clsdf/field.hpp>
#include <clsdf/picture.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace clsdf::picture {

/// The samples of a field for ray tracing: in voxels, and extrapolated beyond the band.
///
/// If the band ends between two samples, the outer one has no distance. Its value is extrapolated linearly from the
/// inner ones, so that a surface at the band's limit, or in a band of one side only, does not follow the stairs of the
/// voxels. No sample within the band is changed, and no sample beyond it gets a value within it. No edge between
/// neighbouring samples becomes steeper than a distance can be. Infinite values become the largest finite ones.
class TracedSamples {
public:
    /// Keeps a reference to the field. Throws Error(invalid_argument) if the distances do not fit the grid, are not
    /// numbers, or the grid has a side of a single sample.
    explicit TracedSamples(const Field& field);

    /// The least and the greatest finite distance, in the mesh's units; both 0 if there is none.
    double lower() const { return lower_; }
    double upper() const { return upper_; }
    /// Whether there are samples inside, so that the distance changes its sign at the surface.
    bool has_sign() const { return has_sign_; }

    /// Whether there are samples below the level, and others.
    bool has_surface(double level) const;

    /// The slices first <= k < last, x fastest, in voxels.
    void write(std::int64_t first, std::int64_t last, std::span<float> values) const;

    /// The steepest edge along each axis between samples of slices that write() gave, voxels by voxel. The slices may
    /// come in pieces, each of which begins with the last slice of the one before.
    std::array<double, 3> slopes(std::int64_t slices, std::span<const float> values) const;

    /// In samples from the first one: the ends of every row along x that has samples with a distance below `level`.
    struct RowEnds {
        std::array<std::int64_t, 3> first;
        std::int64_t last_x;
    };
    std::vector<RowEnds> rows_below(double level) const;

private:
    float value(std::int64_t i, std::int64_t j, std::int64_t k) const;
    // A zero with a plus sign is exact also if the band has no inside, and minus zero what is beyond.
    bool within(float value) const {
        return (value > inside_ || (value == 0 && !std::signbit(value))) && value < outside_;
    }
    double continued(std::int64_t i, std::int64_t j, std::int64_t k, float own) const;

    const Field& field_;
    double voxel_;
    double lower_ = 0;
    double upper_ = 0;
    bool has_sign_ = false;
    bool is_inside_somewhere_ = false;
    float inside_;  // the band's limits as floats, the values of samples beyond them
    float outside_;
};

/// The program of the renderer.
device::ProgramSource tracer_source();

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
