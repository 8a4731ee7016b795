#pragma once

#include "core/outputs.hpp"
#include "io/meshes/mesh_files.hpp"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// Points, rays and results at points in .npy files. All throw as read_points().
namespace clsdf {

/// Rows of 3 or 6 numbers, or those of a member of structures if it has a name. what: "points have the shape (n, 3),
/// ...", for messages.
template <std::size_t width>
std::vector<std::array<double, width>> read_npy_rows(const std::string& path, const char* what,
                                                     const std::string& member = {});

/// A number a row, of any type, or the member of structures.
std::vector<double> read_npy_numbers(const std::string& path, const std::string& member);

/// Calls take(number) with the number at an address.
template <typename Take>
void with_number(ElementType type, const std::byte* address, std::endian order, const Take& take) {
    switch (type) {
        case ElementType::float64:
            return take(load<double>(address, order));
        case ElementType::uint32:
            return take(load<std::uint32_t>(address, order));
        case ElementType::int64:
            return take(load<std::int64_t>(address, order));
        case ElementType::uint8:
            return take(load<std::uint8_t>(address, order));
        default:
            return take(load<float>(address, order));
    }
}

}  // namespace clsdf
