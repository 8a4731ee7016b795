#pragma once

#include <clsdf/calls.hpp>
#include <clsdf/field.hpp>
#include <clsdf/outputs.hpp>

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

/// Numbers of triangles and bodies that count from 1: the library counts from 0. Beyond the band, no_triangle + 1 and
/// no_body + 1 are 0.
namespace clsdf::c {

/// Throws Error(unsupported) if a base of 1 is asked for in memory of the device.
void check_base(std::int32_t base, OutputSet on_device);
void check_base(std::int32_t base, const OutputTargets& targets);

/// After a call, makes the numbers that it wrote on the host count from `base`: of a grid, of points, of blocks.
void set_base(std::int32_t base, const OutputTargets& targets, const Index3& size);
void set_base(std::int32_t base, const OutputTargets& targets, std::size_t points);
void set_base(std::int32_t base, const BlockSet& blocks);
/// The same of the first hits of rays, `most` each.
void set_base(std::int32_t base, const OutputArray& triangles, std::size_t rays, std::size_t most);
/// The same of packed numbers.
void set_base(std::int32_t base, std::span<std::uint32_t> numbers);

/// Values whose numbers count from another base, in arrays of this.
class ShiftedValues {
public:
    /// by: what is added to the numbers, 1 or -1; 0: the same values.
    FieldSlab operator()(FieldSlab values, std::int32_t by);

private:
    std::vector<std::uint32_t> triangles_, bodies_;
};

inline FieldSlab ShiftedValues::operator()(FieldSlab values, std::int32_t by) {
    const auto set = [&](Output output, std::span<const std::uint32_t> numbers, std::vector<std::uint32_t>& own) {
        if (by == 0 || numbers.empty()) return;
        own.resize(numbers.size());
        std::ranges::transform(numbers, own.begin(),
                               [&](std::uint32_t number) { return number + static_cast<std::uint32_t>(by); });
        values.set(output, own);
    };
    set(Output::triangle, values.triangle(), triangles_);
    set(Output::body, values.body(), bodies_);
    return values;
}

}  // namespace clsdf::c
