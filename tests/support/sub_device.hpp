#pragma once

#include "support/exact_field.hpp"

#include "device/context.hpp"

#include <vector>

namespace clsdf::test {

/// A device that has so many of the compute units of the tests' own.
inline Device with_compute_units(cl_uint units) {
    return device::guarded([&] {
        cl::Device whole(test_device().id(), true);
        const cl_device_partition_property properties[] = {CL_DEVICE_PARTITION_BY_COUNTS,
                                                           static_cast<cl_device_partition_property>(units),
                                                           CL_DEVICE_PARTITION_BY_COUNTS_LIST_END, 0};
        std::vector<cl::Device> parts;
        whole.createSubDevices(properties, &parts);
        const cl::Context context(parts.at(0));
        const cl::CommandQueue queue(context, parts[0]);
        return Device::from_handles(context(), parts[0](), queue());
    });
}

}  // namespace clsdf::test
