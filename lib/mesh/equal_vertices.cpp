#include "mesh/equal_vertices.hpp"

#include <bit>
#include <limits>

namespace clsdf {

namespace {

/// The coordinates as integers that are equal exactly where the coordinates are. NaNs compare by their bits here, so
/// that a million of them do not make a million different entries of one hash.
using Key = std::array<std::uint64_t, 3>;

Key key_of(const Vec3& vertex) {
    // Adding 0.0 turns -0.0 into 0.0.
    return {std::bit_cast<std::uint64_t>(vertex[0] + 0.0), std::bit_cast<std::uint64_t>(vertex[1] + 0.0),
            std::bit_cast<std::uint64_t>(vertex[2] + 0.0)};
}

std::uint64_t mix(std::uint64_t value) {
    value = (value ^ (value >> 32U)) * 0x9E3779B97F4A7C15U;
    return value ^ (value >> 29U);
}

std::uint64_t hash_of(const Key& key) {
    return mix(mix(mix(key[0]) ^ key[1]) ^ key[2]);
}

}  // namespace

std::vector<std::uint32_t> first_equal_vertices(std::span<const Vec3> vertices) {
    constexpr std::uint32_t free = std::numeric_limits<std::uint32_t>::max();
    const std::size_t capacity = std::bit_ceil(2 * vertices.size() + 1);
    const std::size_t mask = capacity - 1;
    std::vector<std::uint32_t> table(capacity, free);
    std::vector<std::uint32_t> first(vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        const Key key = key_of(vertices[i]);
        std::size_t slot = hash_of(key) & mask;
        while (table[slot] != free && key_of(vertices[table[slot]]) != key) slot = (slot + 1) & mask;
        if (table[slot] == free) table[slot] = static_cast<std::uint32_t>(i);
        first[i] = table[slot];
    }
    return first;
}

}  // namespace clsdf
