#include "mesh/equal_vertices.hpp"

#include "core/parallel.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

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

/// The vertices in groups by their hash, each in the order of the mesh.
class HashGroups {
public:
    explicit HashGroups(std::span<const std::uint64_t> hashes);

    std::size_t count() const { return start_.size() - 1; }
    std::span<const std::uint32_t> group(std::size_t g) const {
        return std::span(vertices_).subspan(start_[g], start_[g + 1] - start_[g]);
    }

private:
    std::vector<std::size_t> start_;
    std::vector<std::uint32_t> vertices_;
};

HashGroups::HashGroups(std::span<const std::uint64_t> hashes) {
    // The hash table of a group fits the caches.
    constexpr std::size_t group_size = 8192;
    const auto bits = static_cast<unsigned>(std::bit_width(hashes.size() / group_size));
    const std::size_t groups = std::size_t{1} << bits;
    const auto group_of = [&](std::size_t v) { return bits == 0 ? 0 : hashes[v] >> (64 - bits); };
    // Sub-ranges of the vertices are sorted in parallel: first the number of each one's vertices per group.
    const std::size_t chunk_size = std::max(group_size, hashes.size() / 64 + 1);
    const std::size_t chunks = std::max<std::size_t>(1, chunk_count(hashes.size(), chunk_size));
    const auto for_each_vertex = [&](const auto& visit) {
        for_each_chunk(hashes.size(), chunk_size, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
            for (std::size_t v = begin; v != end; ++v) visit(chunk, v);
        });
    };
    std::vector<std::size_t> places(groups * chunks);
    for_each_vertex([&](std::size_t s, std::size_t v) { ++places[group_of(v) * chunks + s]; });
    std::exclusive_scan(places.begin(), places.end(), places.begin(), std::size_t{0});
    start_.resize(groups + 1, hashes.size());
    for (std::size_t g = 0; g < groups; ++g) start_[g] = places[g * chunks];
    vertices_.resize(hashes.size());
    for_each_vertex([&](std::size_t s, std::size_t v) {
        vertices_[places[group_of(v) * chunks + s]++] = static_cast<std::uint32_t>(v);
    });
}

}  // namespace

std::vector<std::uint32_t> first_equal_vertices(std::span<const Vec3> vertices) {
    std::vector<std::uint64_t> hashes(vertices.size());
    for_each_index(vertices.size(), [&](std::size_t v) { hashes[v] = hash_of(key_of(vertices[v])); });
    const HashGroups groups(hashes);
    std::vector<std::uint32_t> first(vertices.size());
    tbb::parallel_for(std::size_t{0}, groups.count(), [&](std::size_t g) {
        const std::span<const std::uint32_t> group = groups.group(g);
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

}  // namespace clsdf
