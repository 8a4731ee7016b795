#include "mesh/input_arrays.hpp"

#include "core/least_index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

namespace clsdf {

namespace {

bool is_of_vec3(const InputArray& triples) {
    const Steps steps = steps_of(triples);
    return triples.type == ElementType::float64 && steps.triple == sizeof(Vec3) && steps.number == sizeof(double);
}

constexpr std::uint32_t no_index = std::numeric_limits<std::uint32_t>::max();

/// Throws an error that names the first index that is out of range.
void refuse_triangle(const InputArray& triangles, std::size_t triangle, const std::string& mesh_name) {
    for (const std::uint64_t index : triple_of<std::uint64_t>(triangles, triangle))
        if (index >= no_index)
            throw Error(ErrorCode::invalid_mesh,
                        fmt::format("{}: triangle {} has the vertex index {}; triangles and indices count from 0, "
                                    "indices to {} at most",
                                    mesh_name, triangle, static_cast<std::int64_t>(index), no_index - 1));
}

}  // namespace

void check_array(const InputArray& triples, ArrayKind kind, const char* what, ErrorCode code) {
    if (triples.count == 0 && triples.host == nullptr && triples.device == nullptr) return;
    const std::size_t width = bytes_of(triples.type);
    if (triples.host != nullptr && triples.device != nullptr)
        throw Error(code, fmt::format("the {} have memory of the host and of the device; give one of them", what));
    const bool is_real = triples.type == ElementType::float32 || triples.type == ElementType::float64;
    const bool is_known = is_real || (width >= 4 && triples.type <= ElementType::uint64);
    if (!is_known || is_real != (kind == ArrayKind::positions))
        throw Error(code, fmt::format("the {} are of type {}; give {}", what, name_of(triples.type),
                                      kind == ArrayKind::indices ? "integers of 32 or 64 bits" : "floats or doubles"));
    if (triples.strides[1] != 0 || triples.strides[2] != 0)
        throw Error(code, fmt::format("the {} have strides along y and z, {} and {}; an array of them has one stride, "
                                      "strides[0]",
                                      what, triples.strides[1], triples.strides[2]));
    const auto is_multiple = [&](std::ptrdiff_t stride) { return stride % static_cast<std::ptrdiff_t>(width) == 0; };
    if (triples.offset % width != 0 || !is_multiple(triples.strides[0]) || !is_multiple(triples.component_stride))
        throw Error(code,
                    fmt::format("the offset {} and the strides {} and {} of the {} are not all multiples of their "
                                "numbers' {} bytes",
                                triples.offset, triples.strides[0], triples.component_stride, what, width));
    if (triples.device != nullptr) return;
    if (triples.count > 0 && triples.host == nullptr)
        throw Error(code, fmt::format("there are {} {} and no memory for them; set the array's host or device",
                                      triples.count, what));
    if (triples.bytes == ArrayLayout::unknown_size) return;
    const std::size_t numbers = triples.bytes / width;
    if (triples.offset == 0 && triples.strides[0] == 0 && triples.component_stride == 0 && numbers % 3 != 0)
        throw Error(
            code,
            fmt::format("the array of {} has {} numbers, which is no multiple of three; each of its items has three",
                        what, numbers));
    range_of(triples, triples.bytes, what, code);
}

std::pair<double, double> extent_of(const ArrayLayout& array, std::initializer_list<ArrayAxis> axes) {
    double lowest = static_cast<double>(array.offset);
    double highest = lowest + static_cast<double>(bytes_of(array.type));
    for (const auto& [stride, count] : axes)
        (stride < 0 ? lowest : highest) += static_cast<double>(stride) * (count - 1);
    return {lowest, highest};
}

ByteRange range_of(const InputArray& triples, std::size_t bytes, const char* what, ErrorCode code) {
    if (triples.count == 0) return {};
    const Steps steps = steps_of(triples);
    const auto [lowest, highest] =
        extent_of(triples, {{steps.triple, static_cast<double>(triples.count)}, {steps.number, 3}});
    if (lowest < 0 || highest > static_cast<double>(bytes))
        throw Error(code, fmt::format("the {} {} reach from byte {:.0f} to {:.0f} with their offset and strides, and "
                                      "their memory holds {}",
                                      triples.count, what, lowest, highest, bytes));
    return {static_cast<std::size_t>(lowest), static_cast<std::size_t>(highest)};
}

std::vector<Vec3> read_positions(const InputArray& positions) {
    if (positions.count == 0) return {};
    if (is_of_vec3(positions)) {
        const std::byte* const first = first_of(positions);
        std::vector<Vec3> result(positions.count);
        std::memcpy(result.data(), first, result.size() * sizeof(Vec3));
        return result;
    }
    std::vector<Vec3> result(positions.count);
    const auto store = [&](std::size_t i, const auto& numbers) {
        result[i] = {static_cast<double>(numbers[0]), static_cast<double>(numbers[1]), static_cast<double>(numbers[2])};
    };
    if (positions.type == ElementType::float32)
        for_each_triple<float>(positions, store);
    else
        for_each_triple<double>(positions, store);
    return result;
}

std::vector<Triangle> read_triangles(const InputArray& triangles, const std::string& mesh_name) {
    std::vector<Triangle> result(triangles.count);
    if (bytes_of(triangles.type) == 4) {
        for_each_triple<std::uint32_t>(triangles, [&](std::size_t i, const auto& numbers) { result[i] = numbers; });
        return result;
    }
    LeastIndex refused(triangles.count);
    for_each_triple<std::uint64_t>(triangles, [&](std::size_t i, const auto& numbers) {
        for (std::size_t k = 0; k < 3; ++k) result[i][k] = static_cast<std::uint32_t>(numbers[k]);
        if (std::max({numbers[0], numbers[1], numbers[2]}) >= no_index) refused.take(i);
    });
    if (refused.get() < triangles.count) refuse_triangle(triangles, refused.get(), mesh_name);
    return result;
}

PositionArray::PositionArray(const InputArray& positions) {
    if (positions.count == 0) return;
    const std::byte* const first = first_of(positions);
    if (is_of_vec3(positions) && reinterpret_cast<std::uintptr_t>(first) % alignof(Vec3) == 0) {
        array_ = {reinterpret_cast<const Vec3*>(first), positions.count};
        return;
    }
    copy_ = read_positions(positions);
    array_ = copy_;
}

}  // namespace clsdf
