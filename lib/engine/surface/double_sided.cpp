#include "surface/double_sided.hpp"

#include "mesh/disjoint_sets.hpp"
#include "surface/edge_counts.hpp"
#include "surface/local_frame.hpp"
#include "surface/parts.hpp"
#include "surface/sheets.hpp"
#include "surface/winding_test.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

namespace clsdf {

namespace {

// Bodies that are looked at: the largest numbers of faces.
constexpr std::size_t most_bodies = 256;
constexpr std::size_t places_of_body = 32;
// So many edges of one face may be holes, but at most a third of the faces' number; or a quarter of it.
constexpr std::size_t few_edges = 12;

/// Faces that are joined over edges.
struct Joined {
    std::vector<std::uint32_t> faces;
    std::size_t boundary = 0;  ///< edges of one face
};

/// The sets with most faces first.
std::vector<Joined> joined_over_edges(const Mesh& mesh) {
    struct Edge {
        std::uint64_t ends;
        std::uint32_t face;
    };
    const std::vector<Triangle>& triangles = mesh.triangles();
    std::vector<Edge> edges;
    edges.reserve(3 * triangles.size());
    for (std::uint32_t face = 0; face < triangles.size(); ++face)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint64_t a = triangles[face][k], b = triangles[face][(k + 1) % 3];
            edges.push_back({std::min(a, b) << 32 | std::max(a, b), face});
        }
    std::ranges::sort(edges, {}, &Edge::ends);
    DisjointSets sets(triangles.size());
    std::vector<std::uint32_t> boundary;  // faces
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const bool is_first = i == 0 || edges[i - 1].ends != edges[i].ends;
        if (!is_first)
            sets.join(edges[i - 1].face, edges[i].face);
        else if (i + 1 == edges.size() || edges[i + 1].ends != edges[i].ends)
            boundary.push_back(edges[i].face);
    }
    constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> numbers(triangles.size(), none);
    std::vector<Joined> result;
    for (std::uint32_t face = 0; face < triangles.size(); ++face) {
        std::uint32_t& number = numbers[sets.root(face)];
        if (number == none) {
            number = static_cast<std::uint32_t>(result.size());
            result.emplace_back();
        }
        result[number].faces.push_back(face);
    }
    for (const std::uint32_t face : boundary) ++result[numbers[sets.root(face)]].boundary;
    std::ranges::stable_sort(result, std::greater<>(), [](const Joined& set) { return set.faces.size(); });
    return result;
}

/// Six times the volume; 0 if it is within the rounding error.
double volume_of(const Mesh& mesh, std::span<const Triangle> triangles) {
    const LocalFrame frame(mesh);
    double sum = 0, magnitude = 0;
    for (const Triangle& triangle : triangles) frame.add_volume(triangle, sum, magnitude);
    const double rounding = static_cast<double>(triangles.size() + 16) * std::numeric_limits<double>::epsilon();
    return std::abs(sum) > rounding * magnitude ? sum : 0;
}

/// Whether the winding number is in doubt at most of a few points beside the faces: most open surfaces are no bodies.
bool is_much_in_doubt(const Mesh& surface, std::span<const Triangle> triangles, const OpenLoops& loops) {
    std::vector<std::uint32_t> all(triangles.size());
    std::iota(all.begin(), all.end(), 0U);
    WindingTally few;
    few.add(WindingView(surface, triangles, loops).at(points_beside(surface, triangles, all, places_of_body)));
    return 2 * few.doubtful > few.tested;
}

/// Whether a surface is that of a body, when the faces of its parts look alike. Adds the faces to turn for that.
bool is_body(const Mesh& surface, bool may_open, std::vector<std::uint32_t>& turned) {
    std::vector<Triangle> triangles = surface.triangles();
    turned = faces_to_turn(surface, triangles, true);
    for (const std::uint32_t face : turned) std::swap(triangles[face][1], triangles[face][2]);
    const EdgeCounts edges = count_edges(triangles, surface.vertices().size());
    if (edges.unbalanced.empty()) return volume_of(surface, triangles) != 0;
    if (!may_open || edges.open() == 0) return false;
    const OpenLoops loops = loops_of(edges);
    if (is_much_in_doubt(surface, triangles, loops)) return false;
    // Less than an open mesh needs for a sign: so a body with a large hole has none, instead of an empty inside.
    const WindingTally all = test_winding_number(surface, triangles, loops).all;
    return all.is_nearly_clear() && all.inside > 0;
}

struct PointsOfSets {
    std::vector<Vec3> points;       ///< set after set
    std::vector<std::size_t> ends;  ///< of each set
};
PointsOfSets points_beside(const Mesh& all, const std::vector<Joined>& sets) {
    PointsOfSets result;
    for (const Joined& set : sets) {
        const std::vector<Vec3> beside = clsdf::points_beside(all, all.triangles(), set.faces, places_of_body);
        result.points.insert(result.points.end(), beside.begin(), beside.end());
        result.ends.push_back(result.points.size());
    }
    return result;
}

/// Whether faces are those of a body, or are when sheets among them are left out.
bool find_body(const Mesh& all, std::vector<std::uint32_t>& faces, bool may_open, std::vector<std::uint32_t>& turned) {
    const Mesh own = surface_of(all, all.triangles(), faces);
    const EdgeCounts edges = count_edges(own.triangles(), own.vertices().size());
    if (edges.open() == 0) return is_body(own, false, turned);
    const bool is_oriented = std::ranges::all_of(edges.unbalanced, &UnbalancedEdge::is_open);
    if (is_oriented && is_much_in_doubt(own, own.triangles(), loops_of(edges))) return false;
    const std::vector<bool> is_free = free_sheets(OrientedParts(own.triangles(), own.vertices().size()), faces.size());
    std::vector<std::uint32_t> rest;
    for (std::size_t i = 0; i < faces.size(); ++i)
        if (!is_free[i]) rest.push_back(faces[i]);
    if (rest.empty() || !is_body(surface_of(all, all.triangles(), rest), false, turned))
        return may_open && is_body(own, may_open, turned);
    faces = std::move(rest);
    return true;
}

}  // namespace

std::vector<CountedFace> double_sided_bodies(const Mesh& mesh, std::span<const Triangle> given,
                                             std::span<const std::uint32_t> candidates,
                                             std::span<const Triangle> counting, const OpenLoops& loops, bool may_open,
                                             double& volume) {
    const Mesh all = surface_of(mesh, given, candidates);
    // Without those that are open for the most part, and those with something inside beside them.
    std::vector<Joined> sets = joined_over_edges(all);
    std::erase_if(sets, [](const Joined& set) {
        return set.boundary > std::max(std::min(few_edges, set.faces.size() / 3), set.faces.size() / 4);
    });
    if (sets.size() > most_bodies) sets.resize(most_bodies);
    const auto [points, ends] = points_beside(all, sets);
    const std::vector<SeenWinding> seen = WindingView(mesh, counting, loops).at(points);
    std::vector<CountedFace> result;
    volume = 0;
    std::size_t i = 0;
    for (std::size_t n = 0; n < sets.size(); ++n) {
        std::size_t empty = 0, pairs = 0;
        for (; i < ends[n]; i += 2, ++pairs) empty += !seen[i].is_inside() && !seen[i + 1].is_inside() ? 1U : 0U;
        if (2 * empty <= pairs) continue;
        std::vector<std::uint32_t>& faces = sets[n].faces;
        std::vector<std::uint32_t> turned;
        if (!find_body(all, faces, may_open, turned)) continue;
        std::vector<bool> is_turned(faces.size());
        for (const std::uint32_t face : turned) is_turned[face] = true;
        std::vector<Triangle> triangles;
        for (std::size_t k = 0; k < faces.size(); ++k) {
            result.push_back({candidates[faces[k]], is_turned[k]});
            triangles.push_back(all.triangles()[faces[k]]);
            if (is_turned[k]) std::swap(triangles.back()[1], triangles.back()[2]);
        }
        volume += volume_of(all, triangles);
    }
    std::ranges::sort(result, {}, &CountedFace::face);
    return result;
}

std::vector<std::uint32_t> doubled_cavities(const Mesh& mesh, std::span<const Triangle> triangles,
                                            std::span<const std::uint32_t> candidates) {
    const Mesh all = surface_of(mesh, triangles, candidates);
    std::vector<Joined> sets = joined_over_edges(all);
    if (sets.size() > most_bodies) sets.resize(most_bodies);
    const auto [points, ends] = points_beside(all, sets);
    const std::vector<SeenWinding> seen = WindingView(mesh, triangles, {}).at(points);
    std::vector<std::uint32_t> result;
    std::size_t i = 0;
    for (std::size_t n = 0; n < sets.size(); ++n) {
        std::size_t filled = 0, pairs = 0;
        for (; i < ends[n]; i += 2, ++pairs) filled += seen[i].rounded * seen[i + 1].rounded < 0 ? 1U : 0U;
        if (2 * filled <= pairs) continue;
        for (const std::uint32_t face : sets[n].faces) result.push_back(candidates[face]);
    }
    std::ranges::sort(result);
    return result;
}

}  // namespace clsdf
