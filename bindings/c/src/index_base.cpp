#include "index_base.hpp"

#include "core/parallel.hpp"
#include "errors.hpp"

#include <cstring>
#include <string>

namespace clsdf::c {

namespace {

/// Calls visit(array) for the arrays of numbers, if they do not count from 0.
template <typename Visit>
void for_each_number(std::int32_t base, const OutputTargets& targets, const Visit& visit) {
    if (base == 0) return;
    for (const Output output : {Output::triangle, Output::body})
        if (const OutputArray* array = targets.find(output)) visit(*array);
}

constexpr std::ptrdiff_t width = sizeof(std::uint32_t);

/// Adds 1 to `count` numbers, `step` bytes apart.
void add_1(std::byte* at, std::size_t count, std::ptrdiff_t step) {
    for (; count > 0; --count, at += step) {
        std::uint32_t value = 0;
        std::memcpy(&value, at, sizeof value);
        ++value;
        std::memcpy(at, &value, sizeof value);
    }
}

/// Adds 1 to the numbers of a box, on all cores. Strides of 0: packed.
void shift(std::byte* first, std::array<std::ptrdiff_t, 3> strides, Index3 size) {
    if (strides == std::array<std::ptrdiff_t, 3>{}) {
        size = {size[0] * size[1] * size[2], 1, 1};
        strides = {width, 0, 0};
    }
    const auto length = static_cast<std::size_t>(size[0]), rows = static_cast<std::size_t>(size[1] * size[2]);
    if (rows == 1)
        return for_each_range(
            length,
            [&](std::size_t begin, std::size_t end) {
                add_1(first + static_cast<std::ptrdiff_t>(begin) * strides[0], end - begin, strides[0]);
            },
            16384);
    for_each_index(
        rows,
        [&](std::size_t row) {
            const auto y = static_cast<std::int64_t>(row) % size[1], z = static_cast<std::int64_t>(row) / size[1];
            add_1(first + y * strides[1] + z * strides[2], length, strides[0]);
        },
        256);
}

std::byte* first_of(const OutputArray& array) {
    return static_cast<std::byte*>(array.host) + array.offset;
}

}  // namespace

void check_base(std::int32_t base, OutputSet on_device) {
    if (base != 0 && (on_device.contains(Output::triangle) || on_device.contains(Output::body)))
        throw Error(
            ErrorCode::unsupported,
            "triangles and bodies in memory of the device, as a plan writes them, count from 0, and the mesh has index "
            "base 1; compute these outputs into arrays on the host, or give the mesh index base 0");
}

void check_base(std::int32_t base, const OutputTargets& targets) {
    for_each_number(base, targets, [&](const OutputArray& array) {
        if (array.device != nullptr) check_base(base, OutputSet(Output::triangle));
    });
}

void set_base(std::int32_t base, const OutputTargets& targets, const Index3& size) {
    for_each_number(base, targets, [&](const OutputArray& array) { shift(first_of(array), array.strides, size); });
}

void set_base(std::int32_t base, const OutputTargets& targets, std::size_t points) {
    for_each_number(base, targets, [&](const OutputArray& array) {
        shift(first_of(array), array.strides[0] == 0 ? std::array<std::ptrdiff_t, 3>{} : array.strides,
              {static_cast<std::int64_t>(points), 1, 1});
    });
}

void set_base(std::int32_t base, const BlockSet& blocks) {
    const std::int64_t samples = blocks.size[0] * blocks.size[1] * blocks.size[2];
    for_each_number(base, blocks.targets, [&](const OutputArray& array) {
        const std::ptrdiff_t step = array.block_stride != 0 ? array.block_stride : width * samples;
        for (std::size_t n = 0; n < blocks.first.size(); ++n)
            shift(first_of(array) + static_cast<std::ptrdiff_t>(n) * step, array.strides, blocks.size);
    });
}

void set_base(std::int32_t base, const OutputArray& triangles, std::size_t rays, std::size_t most) {
    if (base == 0 || triangles.host == nullptr || rays == 0) return;
    const std::ptrdiff_t of_hits = triangles.component_stride != 0 ? triangles.component_stride : width;
    const std::ptrdiff_t packed = of_hits == width ? width * static_cast<std::ptrdiff_t>(most) : width;
    shift(first_of(triangles), {triangles.strides[0] != 0 ? triangles.strides[0] : packed, of_hits, 0},
          {static_cast<std::int64_t>(rays), static_cast<std::int64_t>(most), 1});
}

void set_base(std::int32_t base, std::span<std::uint32_t> numbers) {
    if (base != 0) shift(std::as_writable_bytes(numbers).data(), {}, {static_cast<std::int64_t>(numbers.size()), 1, 1});
}

}  // namespace clsdf::c
