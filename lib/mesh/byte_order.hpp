#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <type_traits>

namespace clsdf {

/// The number that the bytes at this address mean in the given byte order.
template <typename Number>
Number load(const std::byte* address, std::endian order) {
    static_assert(std::is_arithmetic_v<Number>);
    std::array<std::byte, sizeof(Number)> bytes{};
    std::memcpy(bytes.data(), address, sizeof(Number));
    if (order != std::endian::native) std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<Number>(bytes);
}

/// The inverse of load() with the order little endian; returns the address after the number.
template <typename Number>
std::byte* store_little_endian(std::byte* address, Number number) {
    auto bytes = std::bit_cast<std::array<std::byte, sizeof(Number)>>(number);
    if (std::endian::native != std::endian::little) std::reverse(bytes.begin(), bytes.end());
    std::memcpy(address, bytes.data(), sizeof(Number));
    return address + sizeof(Number);
}

}  // namespace clsdf
