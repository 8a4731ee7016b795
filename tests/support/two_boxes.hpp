#pragma once

#include "support/device_memory.hpp"
#include "support/exact_field.hpp"

#include <array>
#include <cstddef>
#include <vector>

namespace clsdf::test {

/// Two boxes and their arrays on the device: of the first lattice packed, of a finer one with strides.
class TwoBoxes {
public:
    explicit TwoBoxes(const Grid& grid)
        : grids_{grid, grid.refined(2).part({1, 2, 3}, {20, 21, 22})}, band_(Band::symmetric(3 * grid.voxel())) {}

    std::vector<Request> requests() const {
        OutputArray apart = apart_.handle();
        apart.offset = sizeof(float);
        apart.strides = {step * width, step * width * grids_[1].size[0],
                         step * width * grids_[1].size[0] * grids_[1].size[1]};
        return {{grids_[0], band_, packed_.handle()}, {grids_[1], band_, apart}};
    }
    std::vector<OutputTargets> targets() const { return {requests()[0].targets, requests()[1].targets}; }

    /// The bytes of the plain call; nothing else has changed.
    bool have_fields_of(const DistanceTransform& transform) const {
        std::vector<std::uint32_t> expected(1 + step * grids_[1].sample_count(), untouched);
        const std::vector<std::uint32_t> values = bits_of(transform.compute(grids_[1], band_).distance());
        for (std::size_t i = 0; i < values.size(); ++i) expected[1 + step * i] = values[i];
        return packed_.read(queue()) == bits_of(transform.compute(grids_[0], band_).distance()) &&
               apart_.read(queue()) == expected;
    }
    bool are_untouched() const {
        const auto is_untouched = [](std::uint32_t value) { return value == untouched; };
        return std::ranges::all_of(packed_.read(queue()), is_untouched) &&
               std::ranges::all_of(apart_.read(queue()), is_untouched);
    }

private:
    static constexpr std::ptrdiff_t step = 2, width = sizeof(float);

    static cl::CommandQueue queue() {
        const device::Context& context = device::context_of(test_device());
        return {context.context(), context.device()};
    }

    std::array<Grid, 2> grids_;
    Band band_;
    DeviceMemory packed_{test_device().context(), grids_[0].sample_count()};
    DeviceMemory apart_{test_device().context(), 1 + step* grids_[1].sample_count()};
};

}  // namespace clsdf::test
