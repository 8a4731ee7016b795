#include "index_base.hpp"

#include "errors.hpp"

#include <tbb/parallel_for.h>

#include <cstring>
#include <string>

namespace clsdf::c {

namespace {

const OutputArray* triangles_of(std::int32_t base, const OutputTargets& targets) {
    return base == 0 ? nullptr : targets.find(Output::triangle);
}

void add_1(std::byte* at) {
    std::uint32_t value = 0;
    std::memcpy(&value, at, sizeof value);
    ++value;
    std::memcpy(at, &value, sizeof value);
}

void shift(std::byte* first, const std::array<std::ptrdiff_t, 3>& strides, const Index3& size) {
    const std::ptrdiff_t width = sizeof(std::uint32_t);
    auto steps = strides;
    if (steps == std::array<std::ptrdiff_t, 3>{}) steps = {width, width * size[0], width * size[0] * size[1]};
    const auto rows = static_cast<std::size_t>(size[1] * size[2]);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rows, 256), [&](const auto& range) {
        for (std::size_t row = range.begin(); row < range.end(); ++row) {
            const auto y = static_cast<std::int64_t>(row) % size[1], z = static_cast<std::int64_t>(row) / size[1];
            std::byte* at = first + y * steps[1] + z * steps[2];
            for (std::int64_t x = 0; x < size[0]; ++x, at += steps[0]) add_1(at);
        }
    });
}

std::byte* first_of(const OutputArray& array) {
    return static_cast<std::byte*>(array.host) + array.offset;
}

}  // namespace

void check_base(std::int32_t base, OutputSet on_device) {
    if (base != 0 && on_device.contains(Output::triangle))
        throw Error(ErrorCode::unsupported,
                    "triangles in memory of the device, as a plan writes them, count from 0, and the mesh has index "
                    "base 1; compute the output triangle into an array on the host, or give the mesh index base 0");
}

void check_base(std::int32_t base, const OutputTargets& targets) {
    const OutputArray* array = triangles_of(base, targets);
    if (array != nullptr && array->device != nullptr) check_base(base, OutputSet(Output::triangle));
}

void set_base(std::int32_t base, const OutputTargets& targets, const Index3& size) {
    if (const OutputArray* array = triangles_of(base, targets)) shift(first_of(*array), array->strides, size);
}

void set_base(std::int32_t base, const OutputTargets& targets, std::size_t points) {
    if (const OutputArray* array = triangles_of(base, targets))
        shift(first_of(*array), array->strides[0] == 0 ? std::array<std::ptrdiff_t, 3>{} : array->strides,
              {static_cast<std::int64_t>(points), 1, 1});
}

void set_base(std::int32_t base, const BlockSet& blocks) {
    const OutputArray* array = triangles_of(base, blocks.targets);
    if (array == nullptr) return;
    const std::int64_t samples = blocks.size[0] * blocks.size[1] * blocks.size[2];
    const std::ptrdiff_t step =
        array->block_stride != 0 ? array->block_stride : static_cast<std::ptrdiff_t>(sizeof(std::uint32_t)) * samples;
    for (std::size_t n = 0; n < blocks.first.size(); ++n)
        shift(first_of(*array) + static_cast<std::ptrdiff_t>(n) * step, array->strides, blocks.size);
}

void shift_triangles(std::span<std::uint32_t> triangles, std::uint32_t added) {
    for (std::uint32_t& triangle : triangles) triangle += added;
}

}  // namespace clsdf::c
