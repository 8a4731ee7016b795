#include "mesh/equal_vertices.hpp"

#include "core/bucket_sort.hpp"
#include "core/parallel.hpp"

#include <array>
#include <bit>
#include <limits>
#include <utility>

namespace clsdf {

namespace {

/// The coordinates as integers, which are equal if and only if the coordinates are. NaNs compare by their bits, so that
/// a million of them are not a million different entries of one hash.
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
    std::vector<std::uint64_t> hashes(vertices.size());
    for_each_index(vertices.size(), [&](std::size_t v) { hashes[v] = hash_of(key_of(vertices[v])); });
    // Vertices in groups by their hash, each in the order of the mesh. The hash table of a group fits the caches.
    constexpr std::size_t group_size = 8192;
    const auto bits = static_cast<unsigned>(std::bit_width(vertices.size() / group_size));
    std::vector<std::uint32_t> grouped(vertices.size());
    const UninitializedVector<std::uint32_t> start = bucket_sort(
        vertices.size(), std::size_t{1} << bits,
        [&](std::size_t v) { return bits == 0 ? 0 : hashes[v] >> (64 - bits); },
        [&](std::size_t v, std::size_t place) { grouped[place] = static_cast<std::uint32_t>(v); });
    std::vector<std::uint32_t> first(vertices.size());
    for_each_chunk(start.size() - 1, 1, [&](std::size_t g, std::size_t, std::size_t) {
        const auto group = std::span<const std::uint32_t>(grouped).subspan(start[g], start[g + 1] - start[g]);
        constexpr std::uint32_t free = std::numeric_limits<std::uint32_t>::max();
        std::vector<std::uint32_t> table(std::bit_ceil(2 * group.size() + 1), free);
        const std::size_t mask = table.size() - 1;
        for (const std::uint32_t v : group) {
            const auto is_equal = [&](std::uint32_t other) {
                return hashes[other] == hashes[v] && key_of(vertices[other]) == key_of(vertices[v]);
            };
            std::size_t slot = hashes[v] & mask;
            while (table[slot] != free && !is_equal(table[slot])) slot = (slot + 1) & mask;
            if (table[slot] == free) table[slot] = v;
            first[v] = table[slot];
        }
    });
    return first;
}

Mesh merged(const Mesh& mesh, const std::vector<std::uint32_t>& first) {
    std::vector<Vec3> vertices;
    std::vector<std::uint32_t> new_index(first.size());
    for (std::size_t i = 0; i < first.size(); ++i)
        if (first[i] == i) {
            new_index[i] = static_cast<std::uint32_t>(vertices.size());
            vertices.push_back(mesh.vertices()[i]);
        }
    std::vector<Triangle> triangles = mesh.triangles();
    for (Triangle& triangle : triangles)
        for (std::uint32_t& index : triangle) index = new_index[first[index]];
    return Mesh(std::move(vertices), std::move(triangles), mesh.name());
}

}  // namespace clsdf
