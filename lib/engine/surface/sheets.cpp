#include "surface/sheets.hpp"

#include "mesh/box_index.hpp"
#include "mesh/disjoint_sets.hpp"
#include "surface/edge_counts.hpp"
#include "surface/winding_test.hpp"

#include <algorithm>
#include <limits>
#include <ranges>

namespace clsdf {

namespace {

// With more, the surface stays as it is.
constexpr std::size_t most_sheets = 1024;
// Points that are looked at in the boxes of all sets of sheets, and of each.
constexpr std::size_t all_points = 8192, most_points = 512, least_points = 64, places = 64;
// Sheets are of one set if their boxes meet when they are widened by that part of their longest side.
constexpr double widening = 0.125;
// A body with a hole has more faces.
constexpr std::size_t fewest_faces = 3;

void drop(std::vector<Triangle>& triangles, std::uint32_t face) {
    triangles[face][1] = triangles[face][2] = triangles[face][0];
}

/// Sheets that are joined over vertices, or a set of such whose boxes meet.
struct Set {
    std::vector<std::uint32_t> faces;  ///< ascending, but for sets that were joined
    Box box = empty_box;
};

OpenLoops loops_of(const Mesh& surface) {
    return clsdf::loops_of(count_edges(surface.triangles(), surface.vertices().size()));
}

std::vector<Set> joined_over_vertices(const Mesh& mesh, std::span<const Triangle> triangles,
                                      const std::vector<bool>& is_wanted) {
    DisjointSets sets(mesh.vertices().size());
    for (std::uint32_t face = 0; face < triangles.size(); ++face)
        if (is_wanted[face]) {
            sets.join(triangles[face][0], triangles[face][1]);
            sets.join(triangles[face][0], triangles[face][2]);
        }
    constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> numbers(mesh.vertices().size(), none);
    std::vector<Set> result;
    for (std::uint32_t face = 0; face < triangles.size(); ++face) {
        if (!is_wanted[face]) continue;
        std::uint32_t& number = numbers[sets.root(triangles[face][0])];
        if (number == none) {
            number = static_cast<std::uint32_t>(result.size());
            result.emplace_back();
        }
        Set& set = result[number];
        set.faces.push_back(face);
        for (const std::uint32_t vertex : triangles[face])
            add(set.box, {mesh.vertices()[vertex], mesh.vertices()[vertex]});
    }
    return result;
}

Box widened_by_share(const Box& box) {
    double half = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) half = std::max(half, box.upper[axis] / 2 - box.lower[axis] / 2);
    return widened(box, 2 * widening * half);
}

void join_sets_that_meet(std::vector<Set>& sets) {
    bool is_changed = true;
    while (is_changed) {
        is_changed = false;
        for (std::size_t i = 0; i < sets.size(); ++i)
            for (std::size_t j = i + 1; j < sets.size();) {
                if (!overlap(widened_by_share(sets[i].box), widened_by_share(sets[j].box))) {
                    ++j;
                    continue;
                }
                add(sets[i].box, sets[j].box);
                sets[i].faces.insert(sets[i].faces.end(), sets[j].faces.begin(), sets[j].faces.end());
                sets.erase(sets.begin() + static_cast<std::ptrdiff_t>(j));
                is_changed = true;
            }
    }
}

/// A surface that has a sign, perhaps.
class Rest {
public:
    Rest(const Mesh& mesh, std::span<const Triangle> triangles, const EdgeCounts& edges)
        : is_balanced_(edges.unbalanced.empty()),
          is_closed_(edges.open() == 0),
          view_(mesh, triangles, is_closed_ ? OpenLoops() : clsdf::loops_of(edges)) {}

    std::vector<bool> are_inside(std::span<const Vec3> points) const {
        std::vector<bool> result;
        result.reserve(points.size());
        for (const SeenWinding& seen : view_.at(points))
            result.push_back(is_closed_ && !is_balanced_ ? seen.rounded % 2 != 0 : seen.is_inside());
        return result;
    }

private:
    bool is_balanced_, is_closed_;
    WindingView view_;
};

/// Whether a set of sheets encloses something outside the rest; null: there is none.
bool encloses_something(const Mesh& own, const Box& box, std::size_t count, const Rest* rest) {
    const WindingView view(own, own.triangles(), loops_of(own));
    std::vector<std::uint32_t> faces(own.triangles().size());
    for (std::uint32_t face = 0; face < faces.size(); ++face) faces[face] = face;
    // A share of the points may have such a winding number.
    const std::vector<Vec3> beside = points_beside(own, own.triangles(), faces, places);
    // What lies within the rest has nothing of the outside between its faces.
    if (rest != nullptr && std::ranges::count(rest->are_inside(beside), false) == 0) return false;
    const auto has_more = [&](const std::vector<Vec3>& points, double to_half, std::size_t per_point, bool is_beside) {
        const std::vector<bool> are_inside =
            rest != nullptr ? rest->are_inside(points) : std::vector<bool>(points.size());
        const std::vector<SeenWinding> seen = view.at(points);
        std::size_t tested = 0, positive = 0, negative = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (are_inside[i]) continue;
            ++tested;
            if (seen[i].is_inside() && seen[i].to_half >= to_half) ++(seen[i].rounded > 0 ? positive : negative);
        }
        // Sheets that look the same way have it, too, with one sign before the first and the other behind the last.
        const std::size_t enclosed =
            is_beside ? std::max(positive, negative) - std::min(positive, negative) : positive + negative;
        return per_point * enclosed > tested;
    };
    return has_more(points_in(box, count), 0.1, 100, false) || has_more(beside, 0.4, 20, true);
}

}  // namespace

std::vector<bool> free_sheets(const OrientedParts& parts, std::size_t face_count) {
    std::vector<std::uint32_t> left(parts.edges.size() - 1);    // faces of each edge
    std::vector<std::vector<std::uint32_t>> edges(face_count);  // of each part, as often as it has faces there
    for (std::uint32_t edge = 0; edge < left.size(); ++edge)
        for (std::size_t i = parts.edges[edge]; i < parts.edges[edge + 1]; ++i) {
            edges[parts.part[parts.entries[i].edge().face]].push_back(edge);
            ++left[edge];
        }
    std::vector<bool> is_free(face_count);
    std::vector<std::uint32_t> found;
    const auto take = [&](std::uint32_t part) {
        if (is_free[part]) return;
        is_free[part] = true;
        found.push_back(part);
    };
    const auto part_left_at = [&](std::uint32_t edge) {
        std::size_t i = parts.edges[edge];
        while (is_free[parts.part[parts.entries[i].edge().face]]) ++i;
        return parts.part[parts.entries[i].edge().face];
    };
    for (std::uint32_t edge = 0; edge < left.size(); ++edge)
        if (left[edge] == 1) take(parts.part[parts.entries[parts.edges[edge]].edge().face]);
    while (!found.empty()) {
        const std::uint32_t part = found.back();
        found.pop_back();
        for (const std::uint32_t edge : edges[part]) --left[edge];
        for (const std::uint32_t edge : edges[part])
            if (left[edge] == 1 &&
                std::ranges::any_of(parts.entries.begin() + static_cast<std::ptrdiff_t>(parts.edges[edge]),
                                    parts.entries.begin() + static_cast<std::ptrdiff_t>(parts.edges[edge + 1]),
                                    [&](const EdgeEntry& entry) { return !is_free[parts.part[entry.edge().face]]; }))
                take(part_left_at(edge));
    }
    std::vector<bool> result(face_count);
    for (std::uint32_t face = 0; face < face_count; ++face) result[face] = is_free[parts.part[face]];
    return result;
}

bool enclose_something(const Mesh& mesh, std::span<const Triangle> triangles, std::span<const std::uint32_t> faces) {
    const Mesh own = surface_of(mesh, triangles, faces);
    return encloses_something(own, own.box(), most_points, nullptr);
}

Sheets find_sheets(const Mesh& mesh, std::span<const Triangle> triangles) {
    std::vector<bool> is_free = free_sheets(OrientedParts(triangles, mesh.vertices().size()), triangles.size());
    for (std::uint32_t face = 0; face < triangles.size(); ++face)
        if (has_repeated_vertex(triangles[face])) is_free[face] = false;
    std::vector<Set> sets = joined_over_vertices(mesh, triangles, is_free);
    if (sets.size() > most_sheets) return {};
    const auto is_left = [&](std::uint32_t face) { return !is_free[face] && !has_repeated_vertex(triangles[face]); };
    if (sets.size() == 1 && std::ranges::none_of(std::views::iota(0U, triangles.size()), is_left)) return {};
    // Bodies with holes stay.
    std::erase_if(sets, [&](const Set& set) {
        if (set.faces.size() < fewest_faces) return false;
        const Mesh own = surface_of(mesh, triangles, set.faces);
        return test_winding_number(own, own.triangles(), loops_of(own)).is_clear();
    });
    Sheets result;
    std::vector<Triangle> rest(triangles.begin(), triangles.end());
    for (const Set& set : sets)
        for (const std::uint32_t face : set.faces) {
            drop(rest, face);
            result.left_out.push_back(face);
        }
    if (std::ranges::all_of(rest, has_repeated_vertex)) return {};
    EdgeCounts edges = count_edges(rest, mesh.vertices().size());
    if (edges.open() > 0 && edges.boundary == 0) {
        result.walls = inner_walls(mesh, rest);
        for (const std::uint32_t face : result.walls) drop(rest, face);
        result.left_out.insert(result.left_out.end(), result.walls.begin(), result.walls.end());
        edges = count_edges(rest, mesh.vertices().size());
    }
    if (result.left_out.empty()) return {};
    if (edges.open() == 0 && !edges.unbalanced.empty()) {
        result.turned = faces_to_turn(mesh, rest, true);
        for (const std::uint32_t face : result.turned) std::swap(rest[face][1], rest[face][2]);
        EdgeCounts turned = count_edges(rest, mesh.vertices().size());
        if (turned.unbalanced.empty()) {
            edges = std::move(turned);
        } else {
            for (const std::uint32_t face : result.turned) std::swap(rest[face][1], rest[face][2]);
            result.turned.clear();
        }
    }
    if (edges.open() > 0 && !test_winding_number(mesh, rest, clsdf::loops_of(edges)).is_clear()) return {};
    const Rest judge(mesh, rest, edges);
    std::vector<std::uint32_t> faces;
    for (std::uint32_t face = 0; face < rest.size(); ++face)
        if (!has_repeated_vertex(rest[face])) faces.push_back(face);
    const std::vector<bool> beside_rest = judge.are_inside(points_beside(mesh, rest, faces, places));
    if (std::ranges::count(beside_rest, true) == 0) return {};
    const std::vector<bool> beside_walls = judge.are_inside(points_beside(mesh, triangles, result.walls, places));
    if (20 * static_cast<std::size_t>(std::ranges::count(beside_walls, false)) > beside_walls.size()) return {};
    join_sets_that_meet(sets);
    const std::size_t count = std::clamp(all_points / std::max<std::size_t>(sets.size(), 1), least_points, most_points);
    for (const Set& set : sets)
        if (encloses_something(surface_of(mesh, triangles, set.faces), set.box, count, &judge)) {
            Sheets enclosing;
            enclosing.enclosing = set.faces.size();
            enclosing.first_enclosing = *std::ranges::min_element(set.faces);
            return enclosing;
        }
    std::ranges::sort(result.left_out);
    return result;
}

}  // namespace clsdf
