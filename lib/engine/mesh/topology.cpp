#include "mesh/topology.hpp"

#include "core/bucket_sort.hpp"
#include "core/parallel.hpp"
#include "mesh/one_rings.hpp"

#include <clsdf/topology.hpp>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

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
    const std::vector<std::uint32_t> start = bucket_sort(
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

namespace {

bool has_repeated_vertex(const Triangle& triangle) {
    return triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
}

/// Counts the vertices; `first` as of first_equal_vertices().
void count_vertices(std::span<const Triangle> triangles, std::span<const std::uint32_t> first, Topology& report) {
    // Counts the vertices number_of(index) of the triangles' indices.
    const auto count_used = [&](const auto& number_of) {
        std::vector<std::uint8_t> used(first.size());
        for_each_index(triangles.size(), [&](std::size_t t) {
            for (const std::uint32_t index : triangles[t]) {
                const std::atomic_ref flag(used[number_of(index)]);
                if (flag.load(std::memory_order_relaxed) == 0) flag.store(1, std::memory_order_relaxed);
            }
        });
        return static_cast<std::size_t>(std::count(used.begin(), used.end(), 1));
    };
    bool are_different = true;
    for (std::size_t v = 0; v < first.size(); ++v) are_different = are_different && first[v] == v;
    const std::size_t used = count_used([](std::uint32_t index) { return index; });
    report.unused_vertices = first.size() - used;
    report.coincident_vertices =
        are_different ? 0 : used - count_used([&](std::uint32_t index) { return first[index]; });
}

std::vector<Triangle> triangles_over(std::span<const std::uint32_t> first, std::span<const Triangle> triangles) {
    std::vector<Triangle> result(triangles.size());
    for_each_index(triangles.size(), [&](std::size_t t) {
        for (std::size_t k = 0; k < 3; ++k) result[t][k] = first[triangles[t][k]];
    });
    return result;
}

/// An edge that is not used equally often in both directions.
struct UnbalancedEdge {
    std::uint32_t lower;
    std::uint32_t higher;
    bool is_open = false;
    bool is_noted = false;

    friend bool operator<(const UnbalancedEdge& a, const UnbalancedEdge& b) {
        return std::tie(a.lower, a.higher) < std::tie(b.lower, b.higher);
    }
};

struct EdgeCounts {
    std::size_t non_manifold = 0;
    std::vector<UnbalancedEdge> unbalanced{};  ///< sorted

    /// An edge with all its faces.
    void add(std::span<const Triangle> triangles, std::uint32_t lower, std::span<const EdgeEntry> faces) {
        const auto leaving =
            static_cast<std::size_t>(std::count_if(faces.begin(), faces.end(), [&](const EdgeEntry& face) {
                return triangles[face.edge().face][face.edge().vertex] == lower;
            }));
        if (2 * leaving != faces.size()) unbalanced.push_back({lower, faces[0].other_vertex(), faces.size() % 2 != 0});
        if (faces.size() > 2) ++non_manifold;
    }

    /// Adds the counts of the vertices after these.
    void append(const EdgeCounts& later) {
        non_manifold += later.non_manifold;
        unbalanced.insert(unbalanced.end(), later.unbalanced.begin(), later.unbalanced.end());
    }
};

EdgeCounts count_edges(std::span<const Triangle> triangles, std::size_t vertex_count) {
    const OneRings rings(triangles, vertex_count);
    constexpr std::size_t chunk = 4096;
    std::vector<EdgeCounts> counts(chunk_count(vertex_count, chunk));
    for_each_chunk(vertex_count, chunk, [&](std::size_t s, std::size_t begin, std::size_t end) {
        std::vector<EdgeEntry> entries;
        for (std::size_t v = begin; v != end; ++v) {
            if (pair_ring(triangles, rings, v, [](const Corner&, const Corner&) {})) continue;
            const auto vertex = static_cast<std::uint32_t>(v);
            edges_above(triangles, rings, vertex, entries);
            std::erase_if(entries,
                          [&](const EdgeEntry& entry) { return has_repeated_vertex(triangles[entry.edge().face]); });
            for_each_edge(entries, [&](std::span<const EdgeEntry> faces) { counts[s].add(triangles, vertex, faces); });
        }
    });
    EdgeCounts all;
    for (const EdgeCounts& of_chunk : counts) all.append(of_chunk);
    return all;
}

/// The first five of the edges, and the first five open ones, in the order and the direction of the first triangles
/// that use them.
void report_first_edges(std::vector<UnbalancedEdge> edges, std::span<const Triangle> triangles,
                        const std::vector<Vec3>& vertices, Topology& report) {
    constexpr std::size_t limit = 5;
    const std::size_t wanted = std::min(report.unbalanced_edges, limit);
    const std::size_t open_wanted = std::min(report.open_edges, limit);
    std::vector<Topology::Edge>& first = report.first_unbalanced_edges;
    std::vector<Topology::Edge>& first_open = report.first_open_edges;
    for (std::size_t t = 0; first.size() < wanted || first_open.size() < open_wanted; ++t) {
        if (has_repeated_vertex(triangles[t])) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t from = triangles[t][k];
            const std::uint32_t to = triangles[t][(k + 1) % 3];
            const UnbalancedEdge edge{std::min(from, to), std::max(from, to)};
            const auto found = std::lower_bound(edges.begin(), edges.end(), edge);
            if (found == edges.end() || edge < *found || found->is_noted) continue;
            found->is_noted = true;
            if (first.size() < wanted) first.push_back({vertices[from], vertices[to]});
            if (found->is_open && first_open.size() < open_wanted) first_open.push_back({vertices[from], vertices[to]});
        }
    }
}

}  // namespace

bool encloses_negative_volume(const Mesh& mesh) {
    // Halves avoid overflow of the difference of the largest numbers. Relative to the centre, the volume is not lost in
    // rounding far from the origin.
    const Box& box = mesh.box();
    Vec3 centre{};
    double half_side = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        centre[axis] = 0.5 * box.lower[axis] + 0.5 * box.upper[axis];
        half_side = std::max(half_side, 0.5 * box.upper[axis] - 0.5 * box.lower[axis]);
    }
    if (half_side == 0) return false;
    const double scale = std::min(1 / half_side, 1e300);  // finite for the smallest numbers, too
    const auto local = [&](std::uint32_t index) {
        const Vec3& vertex = mesh.vertices()[index];
        return Vec3{(vertex[0] - centre[0]) * scale, (vertex[1] - centre[1]) * scale, (vertex[2] - centre[2]) * scale};
    };
    struct Volume {
        double sum = 0;
        double magnitude = 0;
    };
    constexpr std::size_t grain = 4096;
    const Volume volume = reduce_ranges(
        mesh.triangles().size(), grain, Volume{},
        [&](std::size_t begin, std::size_t end, Volume part) {
            for (std::size_t t = begin; t != end; ++t) {
                const Triangle& triangle = mesh.triangles()[t];
                const Vec3 a = local(triangle[0]);
                const Vec3 b = local(triangle[1]);
                const Vec3 c = local(triangle[2]);
                for (std::size_t i = 0; i < 3; ++i) {
                    const std::size_t j = (i + 1) % 3;
                    const std::size_t k = (i + 2) % 3;
                    part.sum += a[i] * (b[j] * c[k] - b[k] * c[j]);
                    part.magnitude += std::abs(a[i]) * (std::abs(b[j] * c[k]) + std::abs(b[k] * c[j]));
                }
            }
            return part;
        },
        [](const Volume& a, const Volume& b) {
            return Volume{a.sum + b.sum, a.magnitude + b.magnitude};
        });
    const double rounding = static_cast<double>(mesh.triangles().size() + 16) * std::numeric_limits<double>::epsilon();
    return volume.sum < -rounding * volume.magnitude;
}

namespace {

/// Describes the edges of a mesh's triangles, whose vertices are all different.
void describe_edges(const Mesh& mesh, std::span<const Triangle> triangles, Topology& report) {
    constexpr std::size_t grain = 4096;
    report.repeated_vertex_faces = reduce_ranges(
        triangles.size(), grain, std::size_t{0},
        [&](std::size_t begin, std::size_t end, std::size_t count) {
            const auto part = triangles.subspan(begin, end - begin);
            return count + static_cast<std::size_t>(std::count_if(part.begin(), part.end(), has_repeated_vertex));
        },
        std::plus<>());
    EdgeCounts edges = count_edges(triangles, mesh.vertices().size());
    report.non_manifold_edges = edges.non_manifold;
    report.unbalanced_edges = edges.unbalanced.size();
    report.open_edges = static_cast<std::size_t>(std::count_if(
        edges.unbalanced.begin(), edges.unbalanced.end(), [](const UnbalancedEdge& edge) { return edge.is_open; }));
    report_first_edges(std::move(edges.unbalanced), triangles, mesh.vertices(), report);
    report.closed = report.open_edges == 0;
    report.balanced = report.unbalanced_edges == 0;
    report.inside_out = report.balanced && encloses_negative_volume(mesh);
}

}  // namespace

Topology describe_vertices(const Mesh& mesh) {
    Topology report;
    count_vertices(mesh.triangles(), first_equal_vertices(mesh.vertices()), report);
    return report;
}

void describe_edges(const Mesh& mesh, bool are_paired, Topology& report) {
    if (are_paired) {
        report.closed = report.balanced = true;
        report.inside_out = encloses_negative_volume(mesh);
    } else {
        describe_edges(mesh, mesh.triangles(), report);
    }
}

Topology describe_topology(const Mesh& mesh) {
    Topology report;
    const std::vector<std::uint32_t> first = first_equal_vertices(mesh.vertices());
    count_vertices(mesh.triangles(), first, report);
    if (report.coincident_vertices > 0)
        describe_edges(mesh, triangles_over(first, mesh.triangles()), report);
    else
        describe_edges(mesh, mesh.triangles(), report);
    return report;
}

}  // namespace clsdf
