#pragma once

#include "acceptance/case.hpp"

#include <clsdf/device.hpp>
#include <clsdf/distance_transform.hpp>
#include <clsdf/reference.hpp>
#include <clsdf/tuning.hpp>

#include <span>
#include <string>
#include <vector>

namespace clsdf::acceptance {

/// An error may be as large as the larger of this and two units in the last place; the aim is the tighter one.
inline constexpr double judged_voxels = 1e-5;
inline constexpr double aim_voxels = 1e-6;

/// The result of a field.
struct Result {
    std::string kind;
    std::string name;
    std::string error;  ///< of a field that could not be computed or checked; nothing below is set then
    std::size_t triangles = 0;
    Index3 size{};
    double half_width_voxels = 0;
    SignRule sign = SignRule::none;
    std::string wrong_calls;  ///< of other calls in blocks of the grid: see calls.hpp
    bool every_sample = false;
    reference::CheckReport judged;
    std::size_t beyond_aim = 0;  ///< band samples
    double compute_seconds = 0;
    double check_seconds = 0;

    /// Fails for a field without a sample in its band, which proves nothing.
    bool passed() const { return error.empty() && wrong_calls.empty() && judged.band_samples > 0 && judged.passed(); }
};

/// A result for each body of the kernels. The truth, which takes most of the time, is found once for all of them.
std::vector<Result> run(const Device& device, const Case& example, std::span<const KernelBody> bodies);

}  // namespace clsdf::acceptance
