#pragma once

#include "device/buffer_pool.hpp"
#include "launch/device_tools.hpp"
#include "segments/sample_box.hpp"
#include "sweep.h"

#include <cstddef>
#include <vector>

namespace clsdf::segments {

/// The samples of a box as kernels read them.
struct DeviceSamples {
    SampleRows rows{};
    device::BufferPool::Lease at;  ///< coordinates: see SampleRows

    /// words: of 32 sides in a row.
    DeviceSamples(const engine::DeviceTools& tools, const SampleBox& box, std::size_t words) {
        rows.per_unit = box.scale;
        rows.words = static_cast<clsdf_uint32>(words);
        std::vector<double> all;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            rows.per_spacing[axis] = box.per_spacing[axis];
            rows.size[axis] = box.size[axis];
            all.insert(all.end(), box.at[axis].begin(), box.at[axis].end());
        }
        at = device::copied(tools.context, tools.pool, all, "coordinates of samples");
    }
};

}  // namespace clsdf::segments
