#include "mesh/topology.hpp"

#include "core/bucket_sort.hpp"
#include "core/parallel.hpp"
#include "mesh/local_frame.hpp"
#include "mesh/one_rings.hpp"
#include "mesh/open_edges.hpp"
#include "mesh/parts.hpp"
#include "mesh/sign_surface.hpp"

#include <clsdf/topology.hpp>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
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
    std::int64_t net = 0;  ///< faces that use it from `lower` to `higher`, minus the others
    bool is_noted = false;

    friend bool operator<(const UnbalancedEdge& a, const UnbalancedEdge& b) {
        return std::tie(a.lower, a.higher) < std::tie(b.lower, b.higher);
    }
};

struct EdgeCounts {
    std::size_t boundary = 0;
    std::size_t non_manifold = 0;
    std::vector<UnbalancedEdge> unbalanced{};  ///< sorted

    /// An edge with all its faces.
    void add(std::span<const Triangle> triangles, std::uint32_t lower, std::span<const EdgeEntry> faces) {
        const auto leaving =
            static_cast<std::size_t>(std::count_if(faces.begin(), faces.end(), [&](const EdgeEntry& face) {
                return triangles[face.edge().face][face.edge().vertex] == lower;
            }));
        if (2 * leaving != faces.size())
            unbalanced.push_back({lower, faces[0].other_vertex(), faces.size() % 2 != 0,
                                  2 * static_cast<std::int64_t>(leaving) - static_cast<std::int64_t>(faces.size())});
        if (faces.size() == 1) ++boundary;
        if (faces.size() > 2) ++non_manifold;
    }

    std::size_t open() const {
        return static_cast<std::size_t>(std::count_if(unbalanced.begin(), unbalanced.end(),
                                                      [](const UnbalancedEdge& edge) { return edge.is_open; }));
    }

    /// Adds the counts of the vertices after these.
    void append(const EdgeCounts& later) {
        boundary += later.boundary;
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

namespace {

/// Six times a volume, and the sum of the magnitudes of its terms.
struct Volume {
    double sum = 0;
    double magnitude = 0;

    friend Volume operator+(const Volume& a, const Volume& b) { return {a.sum + b.sum, a.magnitude + b.magnitude}; }
};

/// Of faces [begin, end), divided by halves down to leaves of 64: an order that GPUs sum in, too
/// (kernels/frusta/mesh_topology.cl).
template <class TriangleOf>
Volume volume_of(const LocalFrame& frame, const TriangleOf& triangle_of, std::size_t begin, std::size_t end) {
    if (end - begin > volume_leaf) {
        const std::size_t middle = begin + (end - begin) / 2;
        return volume_of(frame, triangle_of, begin, middle) + volume_of(frame, triangle_of, middle, end);
    }
    Volume volume;
    for (std::size_t t = begin; t != end; ++t) frame.add_volume(triangle_of(t), volume.sum, volume.magnitude);
    return volume;
}

}  // namespace

bool is_negative_volume(double sum, double magnitude, std::size_t faces) {
    const double rounding = static_cast<double>(faces + 16) * std::numeric_limits<double>::epsilon();
    return sum < -rounding * magnitude;
}

bool encloses_negative_volume(const Mesh& mesh, const SignSurface& surface) {
    const LocalFrame frame(mesh);
    constexpr std::size_t grain = 4096;  // ranges are divided by halves, too
    const auto sum_of = [&](const auto& triangle_of) {
        return reduce_ranges(
            mesh.triangles().size(), grain, Volume{},
            [&](std::size_t begin, std::size_t end, const Volume& before) {
                return before + volume_of(frame, triangle_of, begin, end);
            },
            std::plus<>());
    };
    const std::vector<Triangle>& given = mesh.triangles();
    const Volume volume = surface.is_mesh() ? sum_of([&](std::size_t t) -> const Triangle& { return given[t]; })
                                            : sum_of([&](std::size_t t) { return surface.triangle(given[t], t); });
    return is_negative_volume(volume.sum, volume.magnitude, given.size());
}

namespace {

/// Finds the surface that decides the sign: the rules of docs/sign.md in their order, each only if the surface is not
/// balanced after the one before.
class SurfaceSearch {
public:
    /// `triangles`: of the mesh, with numbers of vertices that are all different.
    SurfaceSearch(const Mesh& mesh, std::span<const Triangle> triangles, EdgeCounts edges)
        : mesh_(mesh), triangles_(triangles.begin(), triangles.end()), edges_(std::move(edges)) {}

    void join_noise() {
        std::vector<std::uint32_t> ends;
        for (const UnbalancedEdge& edge : edges_.unbalanced) {
            ends.push_back(edge.lower);
            ends.push_back(edge.higher);
        }
        std::ranges::sort(ends);
        const auto repeated = std::ranges::unique(ends);
        ends.erase(repeated.begin(), repeated.end());
        const Box& box = mesh_.box();
        double half_side = 0;
        for (std::size_t axis = 0; axis < 3; ++axis)
            half_side = std::max(half_side, 0.5 * box.upper[axis] - 0.5 * box.lower[axis]);
        const std::vector<JoinedVertex> joined =
            join_vertices(mesh_.vertices(), std::move(ends), 2 * joining_tolerance * half_side);
        if (joined.empty()) return;
        joined_ = joined.size();
        surface_.vertices.resize(mesh_.vertices().size());
        std::iota(surface_.vertices.begin(), surface_.vertices.end(), std::uint32_t{0});
        for (const auto& [vertex, least] : joined) surface_.vertices[vertex] = least;
        for (Triangle& triangle : triangles_)
            for (std::uint32_t& index : triangle) index = surface_.vertices[index];
        count();
    }

    /// Faces of the same three vertices count by their net number, at most once. If edges stay open, faces that cancel
    /// each other count once where that closes the surface. The surface stays as it is if more edges would be
    /// unbalanced than before, or if it is closed and that would open it, unless it consists of doubled faces alone.
    void count_doubled_once(const std::vector<DoubledFace>& doubled) {
        if (doubled.empty()) return;
        std::vector<int> net(triangles_.size(), 1);
        for (const DoubledFace& one : doubled) {
            net[one.first] += one.is_reversed ? -1 : 1;
            net[one.face] = 0;
        }
        const std::vector<Triangle> before = triangles_;
        EdgeCounts edges_before = edges_;
        std::vector<SignSurface::Use> uses(triangles_.size(), SignSurface::forward);
        const auto use_of = [&](std::uint32_t first, bool is_reversed) {
            return (net[first] < 0) != is_reversed ? SignSurface::unused_backward : SignSurface::unused_forward;
        };
        for (const DoubledFace& one : doubled) {
            uses[one.face] = use_of(one.first, one.is_reversed);
            uses[one.first] = net[one.first] > 0   ? SignSurface::forward
                              : net[one.first] < 0 ? SignSurface::backward
                                                   : SignSurface::unused_forward;
            drop(one.face);
            if (net[one.first] == 0) drop(one.first);
        }
        for (std::uint32_t face = 0; face < triangles_.size(); ++face)
            if (uses[face] == SignSurface::backward) turn(face);
        count();
        if (!is_closed())
            for (const std::uint32_t face : close_with(cancelled_faces(before, doubled, net)))
                uses[face] = SignSurface::forward;
        const bool is_opened = edges_before.open() == 0 && !is_closed() && has_odd_face(before, doubled);
        if (is_opened || edges_.unbalanced.size() > edges_before.unbalanced.size()) {
            triangles_ = before;
            edges_ = std::move(edges_before);
            return;
        }
        surface_.faces = std::move(uses);
    }

    /// Turns around the faces that look otherwise than most of their part.
    void orient_parts(const std::vector<DoubledFace>& doubled) {
        const std::vector<std::uint32_t> faces = faces_to_turn(mesh_, triangles_);
        if (faces.empty()) return;
        for (const std::uint32_t face : faces) turn(face);
        EdgeCounts before = std::move(edges_);
        count();
        if (!is_balanced()) {
            for (const std::uint32_t face : faces) turn(face);
            edges_ = std::move(before);
            return;
        }
        const bool has_uses = !surface_.faces.empty();
        if (!has_uses) surface_.faces.assign(triangles_.size(), SignSurface::forward);
        for (const std::uint32_t face : faces)
            surface_.faces[face] = surface_.faces[face] > 0 ? SignSurface::backward : SignSurface::forward;
        if (has_uses)
            for (const DoubledFace& one : doubled)
                if (SignSurface::count_of(surface_.faces[one.first]) != 0)
                    surface_.faces[one.face] = (surface_.faces[one.first] > 0) != one.is_reversed
                                                   ? SignSurface::unused_forward
                                                   : SignSurface::unused_backward;
        reoriented_ = faces.size();
    }

    bool is_balanced() const { return edges_.unbalanced.empty(); }
    bool is_closed() const { return edges_.open() == 0; }
    std::size_t joined() const { return joined_; }
    std::size_t reoriented() const { return reoriented_; }
    std::size_t uncounted() const {
        return static_cast<std::size_t>(std::ranges::count_if(
            surface_.faces, [](SignSurface::Use use) { return SignSurface::count_of(use) == 0; }));
    }
    const std::vector<Triangle>& triangles() const { return triangles_; }
    const EdgeCounts& edges() const { return edges_; }
    SignSurface take_surface() { return std::move(surface_); }

private:
    /// Whether a face comes an odd number of times, by itself for instance.
    static bool has_odd_face(std::span<const Triangle> triangles, std::span<const DoubledFace> doubled) {
        std::vector<std::uint8_t> is_odd(triangles.size(), 1);
        for (const DoubledFace& one : doubled) {
            is_odd[one.first] ^= 1U;
            is_odd[one.face] = 0;
        }
        for (std::size_t face = 0; face < triangles.size(); ++face)
            if (is_odd[face] != 0 && !has_repeated_vertex(triangles[face])) return true;
        return false;
    }

    /// The lowest faces of those that cancel each other; in place of all others, points.
    static std::vector<Triangle> cancelled_faces(std::span<const Triangle> triangles,
                                                 std::span<const DoubledFace> doubled, std::span<const int> net) {
        std::vector<Triangle> result(triangles.size());
        for (const DoubledFace& one : doubled)
            if (net[one.first] == 0) result[one.first] = triangles[one.first];
        return result;
    }

    /// Adds the parts of another surface whose rims are open edges, if the surface is closed then. Returns their faces.
    std::vector<std::uint32_t> close_with(const std::vector<Triangle>& other) {
        const OrientedParts parts(other, mesh_.vertices().size());
        std::vector<std::uint8_t> has_rim(other.size()), fits(other.size(), 1);  // of each part, by its lowest face
        for (std::size_t i = 0; i + 1 < parts.edges.size(); ++i) {
            if ((parts.edges[i + 1] - parts.edges[i]) % 2 == 0) continue;
            for (std::size_t n = parts.edges[i]; n < parts.edges[i + 1]; ++n) {
                const Corner corner = parts.entries[n].edge();
                const std::uint32_t part = parts.part[corner.face];
                const Triangle& face = other[corner.face];
                has_rim[part] = 1;
                if (!is_open(face[corner.vertex], face[next_of_three(corner.vertex)])) fits[part] = 0;
            }
        }
        std::vector<std::uint32_t> added;
        for (std::uint32_t face = 0; face < other.size(); ++face)
            if (has_rim[parts.part[face]] != 0 && fits[parts.part[face]] != 0) added.push_back(face);
        if (added.empty()) return {};
        EdgeCounts before = edges_;
        for (const std::uint32_t face : added) triangles_[face] = other[face];
        count();
        if (is_closed()) return added;
        for (const std::uint32_t face : added) drop(face);
        edges_ = std::move(before);
        return {};
    }

    bool is_open(std::uint32_t a, std::uint32_t b) const {
        const UnbalancedEdge edge{std::min(a, b), std::max(a, b)};
        const auto found = std::ranges::lower_bound(edges_.unbalanced, edge, std::less<>());
        return found != edges_.unbalanced.end() && !(edge < *found) && found->is_open;
    }

    void turn(std::uint32_t face) { std::swap(triangles_[face][1], triangles_[face][2]); }
    void drop(std::uint32_t face) { triangles_[face][1] = triangles_[face][2] = triangles_[face][0]; }
    void count() { edges_ = count_edges(triangles_, mesh_.vertices().size()); }

    const Mesh& mesh_;
    std::vector<Triangle> triangles_;  // of the surface so far; those that do not count have one vertex
    EdgeCounts edges_;                 // of the surface so far
    SignSurface surface_;
    std::size_t joined_ = 0;
    std::size_t reoriented_ = 0;
};

OpenLoops loops_of(const EdgeCounts& edges) {
    std::vector<OpenEdge> open;
    open.reserve(edges.unbalanced.size());
    for (const UnbalancedEdge& edge : edges.unbalanced) {
        if (edge.net > 0)
            open.push_back({edge.lower, edge.higher, static_cast<std::uint32_t>(edge.net)});
        else
            open.push_back({edge.higher, edge.lower, static_cast<std::uint32_t>(-edge.net)});
    }
    return clsdf::loops_of(std::move(open));
}

/// Describes the edges of a mesh's triangles, whose vertices are all different.
SignSurface describe_edges(const Mesh& mesh, std::span<const Triangle> triangles, SignRule asked, Topology& report) {
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
    if (edges.unbalanced.empty()) {
        report.closed = report.balanced = true;
        if (edges.non_manifold > 0) report.duplicate_faces = doubled_faces(triangles).size();
        report.inside_out = encloses_negative_volume(mesh);
        return {};
    }
    SurfaceSearch search(mesh, triangles, std::move(edges));
    search.join_noise();
    const std::vector<DoubledFace> doubled = doubled_faces(search.triangles());
    if (!search.is_balanced()) search.count_doubled_once(doubled);
    if (!search.is_balanced() && search.is_closed()) search.orient_parts(doubled);
    report.joined_vertices = search.joined();
    report.duplicate_faces = doubled.size();
    report.uncounted_faces = search.uncounted();
    report.reoriented_faces = search.reoriented();
    report.boundary_edges = search.edges().boundary;
    report.unbalanced_edges = search.edges().unbalanced.size();
    report.open_edges = search.edges().open();
    report_first_edges(search.edges().unbalanced, search.triangles(), mesh.vertices(), report);
    report.closed = search.is_closed();
    report.balanced = search.is_balanced();
    if (report.open_edges > 0 && report.boundary_edges == 0) find_inner_walls(mesh, search.triangles(), report);
    SignSurface surface = search.take_surface();
    report.inside_out = report.balanced && encloses_negative_volume(mesh, surface);
    if (report.balanced) return surface;
    if (asked == SignRule::solid_angle || (asked == SignRule::automatic && !report.closed)) {
        surface.open_loops = loops_of(search.edges());
        test_winding_number(mesh, search.triangles(), surface.open_loops, report);
        report.inside_out = report.inside_out && (asked == SignRule::solid_angle || has_clear_winding_number(report));
    }
    return surface;
}

/// The triangles of the surface that decides the sign.
std::vector<Triangle> triangles_of(std::span<const Triangle> given, const SignSurface& surface) {
    std::vector<Triangle> triangles(given.size());
    for_each_index(given.size(), [&](std::size_t face) { triangles[face] = surface.triangle(given[face], face); });
    return triangles;
}

}  // namespace

OpenLoops open_loops_of(const Mesh& mesh, const SignSurface& surface) {
    const std::vector<Triangle> own =
        surface.is_mesh() ? std::vector<Triangle>() : triangles_of(mesh.triangles(), surface);
    const std::span<const Triangle> triangles = surface.is_mesh() ? std::span(mesh.triangles()) : std::span(own);
    return loops_of(count_edges(triangles, mesh.vertices().size()));
}

Topology describe_vertices(const Mesh& mesh, std::span<const std::uint32_t> first) {
    Topology report;
    count_vertices(mesh.triangles(), first, report);
    return report;
}

SignSurface describe_edges(const Mesh& mesh, std::span<const Triangle> neighbours, bool are_paired, SignRule asked,
                           Topology& report) {
    if (are_paired) {
        describe_paired_edges(encloses_negative_volume(mesh), report);
        if (!is_one_part(neighbours, mesh.vertices().size())) describe_parts(mesh, mesh.triangles(), report);
        return {};
    }
    SignSurface surface = describe_edges(mesh, mesh.triangles(), asked, report);
    report.parts = report.balanced ? 1 : 0;
    if (report.balanced && (!surface.is_mesh() || !is_one_part(neighbours, mesh.vertices().size())))
        describe_parts(mesh, triangles_of(mesh.triangles(), surface), report);
    return surface;
}

void describe_paired_edges(bool encloses_negative_volume, Topology& report) {
    report.closed = report.balanced = true;
    report.inside_out = encloses_negative_volume;
    report.parts = 1;
}

DescribedMesh describe_mesh(const Mesh& mesh, SignRule asked) {
    DescribedMesh described;
    auto& [report, surface] = described;
    const std::vector<std::uint32_t> first = first_equal_vertices(mesh.vertices());
    count_vertices(mesh.triangles(), first, report);
    const std::vector<Triangle> own =
        report.coincident_vertices > 0 ? triangles_over(first, mesh.triangles()) : std::vector<Triangle>();
    const std::span<const Triangle> triangles = own.empty() ? std::span(mesh.triangles()) : std::span(own);
    surface = describe_edges(mesh, triangles, asked, report);
    report.parts = report.balanced ? 1 : 0;
    if (report.balanced && (!surface.is_mesh() || !is_one_part(triangles, mesh.vertices().size())))
        describe_parts(mesh, triangles_of(triangles, surface), report);
    if (!own.empty() && !surface.is_mesh()) {
        if (surface.vertices.empty())
            surface.vertices = first;
        else
            for (std::size_t v = 0; v < first.size(); ++v) surface.vertices[v] = surface.vertices[first[v]];
    }
    return described;
}

Topology describe_topology(const Mesh& mesh) {
    return describe_mesh(mesh).topology;
}

}  // namespace clsdf
