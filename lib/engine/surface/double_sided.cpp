#include "surface/double_sided.hpp"

#include "mesh/disjoint_sets.hpp"
#include "surface/edge_counts.hpp"
#include "surface/local_frame.hpp"
#include "surface/regions.hpp"
#include "surface/sheets.hpp"
#include "surface/winding_test.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

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
std::vector<Joined> joined_over_edges(const OrientedParts& parts) {
    const std::size_t face_count = parts.part.size();
    DisjointSets sets(face_count);
    for (std::uint32_t face = 0; face < face_count; ++face) sets.join(parts.part[face], face);
    std::vector<std::uint32_t> boundary;  // faces
    for (std::size_t edge = 0; edge + 1 < parts.edges.size(); ++edge) {
        const std::size_t begin = parts.edges[edge], end = parts.edges[edge + 1];
        const std::uint32_t first = parts.entries[begin].edge().face;
        if (end == begin + 1) boundary.push_back(first);
        for (std::size_t i = begin + 1; i < end; ++i) sets.join(first, parts.entries[i].edge().face);
    }
    constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> numbers(face_count, none);
    std::vector<Joined> result;
    for (std::uint32_t face = 0; face < face_count; ++face) {
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

/// Bodies that touch in common walls: their skin alone, if they enclose a volume.
bool find_skin(const Mesh& own, std::vector<std::uint32_t>& faces, std::vector<std::uint32_t>& turned) {
    const std::vector<FaceRole> roles = roles_by_reach(own, own.triangles());
    std::vector<std::uint32_t> skin;
    std::vector<Triangle> triangles;
    turned.clear();
    for (std::uint32_t face = 0; face < roles.size(); ++face) {
        if (roles[face] == FaceRole::wall) continue;
        if (roles[face] != FaceRole::forward && roles[face] != FaceRole::backward) return false;
        triangles.push_back(own.triangles()[face]);
        if (roles[face] == FaceRole::backward) {
            std::swap(triangles.back()[1], triangles.back()[2]);
            turned.push_back(static_cast<std::uint32_t>(skin.size()));
        }
        skin.push_back(faces[face]);
    }
    if (triangles.empty() || volume_of(own, triangles) == 0) return false;
    faces = std::move(skin);
    return true;
}

/// Whether faces are those of a body, or are when sheets or walls among them are left out. is_free: free_sheets() of
/// all.
bool find_body(const Mesh& all, const std::vector<bool>& is_free, std::vector<std::uint32_t>& faces, bool may_open,
               std::vector<std::uint32_t>& turned) {
    const Mesh own = surface_of(all, all.triangles(), faces);
    const EdgeCounts edges = count_edges(own.triangles(), own.vertices().size());
    if (edges.open() == 0 && is_body(own, false, turned)) return true;
    if (edges.non_manifold > 0 && find_skin(own, faces, turned)) return true;
    if (edges.open() == 0) return false;
    const bool is_oriented = std::ranges::all_of(edges.unbalanced, &UnbalancedEdge::is_open);
    if (is_oriented && is_much_in_doubt(own, own.triangles(), loops_of(edges))) return false;
    std::vector<std::uint32_t> rest;
    for (const std::uint32_t face : faces)
        if (!is_free[face]) rest.push_back(face);
    if (rest.empty() || !is_body(surface_of(all, all.triangles(), rest), false, turned))
        return may_open && is_body(own, may_open, turned);
    faces = std::move(rest);
    return true;
}

/// The triangles of some faces.
std::vector<Triangle> triangles_of(std::span<const Triangle> triangles, std::span<const std::uint32_t> faces) {
    std::vector<Triangle> result;
    result.reserve(faces.size());
    for (const std::uint32_t face : faces) result.push_back(triangles[face]);
    return result;
}

Mesh surface_of_all(const Mesh& mesh, std::span<const Triangle> triangles) {
    std::vector<std::uint32_t> all(triangles.size());
    std::iota(all.begin(), all.end(), 0U);
    return surface_of(mesh, triangles, all);
}

}  // namespace

SubSurface::SubSurface(const Mesh& mesh, std::span<const Triangle> triangles, std::vector<std::uint32_t> own_faces)
    : faces(std::move(own_faces)),
      surface(surface_of_all(mesh, triangles)),
      parts(surface.triangles(), surface.vertices().size()) {}

std::vector<CountedFace> double_sided_bodies(const Mesh& mesh, const SubSurface& candidates,
                                             std::span<const Triangle> counting, const OpenLoops& loops, bool may_open,
                                             double& volume) {
    struct Body {
        std::vector<std::uint32_t> faces, turned;
    };
    const Mesh& all = candidates.surface;
    const std::vector<bool> is_free = free_sheets(candidates.parts, all.triangles().size());
    std::vector<Joined> sets = joined_over_edges(candidates.parts);
    // Without those that are open for the most part.
    std::erase_if(sets, [](const Joined& set) {
        return set.boundary > std::max(std::min(few_edges, set.faces.size() / 3), set.faces.size() / 4);
    });
    if (sets.size() > most_bodies) sets.resize(most_bodies);
    std::vector<Body> bodies;
    std::erase_if(sets, [&](const Joined& set) {
        Body body{set.faces, {}};
        const bool is_found = find_body(all, is_free, body.faces, may_open, body.turned);
        if (is_found) bodies.push_back(std::move(body));
        return !is_found;
    });
    volume = 0;
    if (bodies.empty()) return {};
    // Without those with something inside beside them.
    const auto [points, ends] = points_beside(all, sets);
    const std::vector<SeenWinding> seen = WindingView(mesh, counting, loops).at(points);
    std::vector<CountedFace> result;
    std::size_t i = 0;
    for (std::size_t n = 0; n < bodies.size(); ++n) {
        std::size_t empty = 0, pairs = 0;
        for (; i < ends[n]; i += 2, ++pairs) empty += !seen[i].is_inside() && !seen[i + 1].is_inside() ? 1U : 0U;
        if (2 * empty <= pairs) continue;
        const auto& [faces, turned] = bodies[n];
        std::vector<bool> is_turned(faces.size());
        for (const std::uint32_t face : turned) is_turned[face] = true;
        std::vector<Triangle> triangles = triangles_of(all.triangles(), faces);
        for (std::size_t k = 0; k < faces.size(); ++k) {
            result.push_back({candidates.faces[faces[k]], is_turned[k]});
            if (is_turned[k]) std::swap(triangles[k][1], triangles[k][2]);
        }
        volume += volume_of(all, triangles);
    }
    std::ranges::sort(result, {}, &CountedFace::face);
    return result;
}

std::vector<std::uint32_t> doubled_cavities(const Mesh& mesh, std::span<const Triangle> triangles,
                                            std::vector<std::uint32_t> candidates) {
    const std::vector<Triangle> own = triangles_of(triangles, candidates);
    const SubSurface all(mesh, own, std::move(candidates));
    std::vector<Joined> sets = joined_over_edges(all.parts);
    if (sets.size() > most_bodies) sets.resize(most_bodies);
    const auto [points, ends] = points_beside(all.surface, sets);
    const std::vector<SeenWinding> seen = WindingView(mesh, triangles, {}).at(points);
    std::vector<std::uint32_t> result;
    std::size_t i = 0;
    for (std::size_t n = 0; n < sets.size(); ++n) {
        std::size_t filled = 0, pairs = 0;
        for (; i < ends[n]; i += 2, ++pairs) filled += seen[i].rounded * seen[i + 1].rounded < 0 ? 1U : 0U;
        if (2 * filled <= pairs) continue;
        for (const std::uint32_t face : sets[n].faces) result.push_back(all.faces[face]);
    }
    std::ranges::sort(result);
    return result;
}

}  // namespace clsdf
