#include "surface/regions.hpp"

#include "core/parallel.hpp"
#include "mesh/box_index.hpp"
#include "mesh/disjoint_sets.hpp"
#include "mesh/face_crossings.hpp"
#include "mesh/predicates.hpp"
#include "surface/local_frame.hpp"
#include "surface/parts.hpp"
#include "surface/ray_side.hpp"
#include "surface/sheets.hpp"
#include "surface/sign_surface.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>

namespace clsdf {

namespace {

constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

/// A part of the surface (OrientedParts) at an edge, with the vertex of its face that stands for its direction.
struct AtEdge {
    std::uint32_t part;
    bool is_ahead;  ///< whether its even side looks to greater angles around the edge
    std::uint32_t apex;
    int quarter = 0;  ///< of the directions around the edge, from the first part's on: at it, before, opposite, beyond
};

/// The sides of a surface's faces, joined to regions. A part of OrientedParts has two sides: the even one, of its
/// lowest face's front, and the odd one.
class Regions {
public:
    /// first_closing: triangles from there on close edges, and have no area but for rounding.
    Regions(const Mesh& mesh, std::span<const Triangle> triangles, std::size_t first_closing)
        : mesh_(mesh),
          triangles_(triangles),
          first_closing_(first_closing),
          parts_(triangles, mesh.vertices().size()),
          sides_(2 * triangles.size()),
          surfaces_(triangles.size()),
          is_kept_(triangles.size(), true) {
        for (std::uint32_t face = 0; face < triangles.size(); ++face)
            if (parts_.part[face] == face && !parts_.is_orientable[face]) sides_.join(2 * face, 2 * face + 1);
        for_each_edge([&](std::span<const EdgeEntry> faces) {
            for (const EdgeEntry& entry : faces) surfaces_.join(part_at(faces[0]), part_at(entry));
        });
        for_each_edge([&](std::span<const EdgeEntry> faces) {
            if (faces.size() > 2) is_kept_[surfaces_.root(part_at(faces[0]))] = false;
        });
    }

    /// Whether there is an edge of three faces or more.
    bool has_any() const { return std::ranges::count(is_kept_, false) > 0; }

    std::vector<FaceRole> roles() {
        keep_those_that_cross();
        for_each_edge([&](std::span<const EdgeEntry> faces) {
            const std::uint32_t surface = surfaces_.root(part_at(faces[0]));
            if (!is_kept_[surface] && !join_sides(faces)) is_kept_[surface] = true;
        });
        keep_those_that_leak();
        find_bodies();
        std::vector<FaceRole> roles(triangles_.size(), FaceRole::as_before);
        for (Body& body : bodies_) take_skin(body, roles);
        for (std::uint32_t face = 0; face < triangles_.size(); ++face)
            if (is_sheet(face))
                roles[face] = is_inside_[sides_.root(2 * parts_.part[face])] ? FaceRole::wall : FaceRole::sheet;
        return roles;
    }

private:
    /// Faces of the skins and inner walls of a surface without its sheets, joined over edges.
    struct Body {
        std::vector<std::uint32_t> faces;
        std::uint32_t outer = 0;  ///< region
    };

    template <typename Function>
    void for_each_edge(const Function& f) const {
        for (std::size_t edge = 0; edge + 1 < parts_.edges.size(); ++edge)
            f(std::span(parts_.entries).subspan(parts_.edges[edge], parts_.edges[edge + 1] - parts_.edges[edge]));
    }
    std::uint32_t part_at(const EdgeEntry& entry) const { return parts_.part[entry.edge().face]; }
    const Vec3& at(std::uint32_t vertex) const { return mesh_.vertices()[vertex]; }
    bool has_area(std::uint32_t face) const {
        const Triangle& corners = triangles_[face];
        return face < first_closing_ && !are_collinear(at(corners[0]), at(corners[1]), at(corners[2]));
    }
    /// Of a face's front or back.
    std::uint32_t region(std::uint32_t face, bool is_front) {
        return sides_.root(2 * parts_.part[face] + (parts_.is_turned[face] == is_front ? 1U : 0U));
    }
    bool is_walked(std::uint32_t face) {
        return !has_repeated_vertex(triangles_[face]) && !is_kept_[surfaces_.root(parts_.part[face])];
    }
    bool is_sheet(std::uint32_t face) { return is_walked(face) && region(face, true) == region(face, false); }

    /// Whether one of two faces is on one side of the other's plane, but for what vertices that are joined may differ
    /// by: an edge that lay on a face before the mesh was turned and rounded.
    bool touch_but_for_rounding(const LocalFrame& frame, std::uint32_t first, std::uint32_t second) const {
        constexpr double tolerance = 2 * joining_tolerance;  // half of the longest side is 1
        for (const auto& [one, other] : {std::pair(first, second), {second, first}}) {
            const Vec3 normal = frame.normal(triangles_[other]), origin = frame.local(triangles_[other][0]);
            const double length = length_of(normal);
            double lowest = 0, highest = 0;
            for (const std::uint32_t vertex : triangles_[one]) {
                const Vec3 at = frame.local(vertex);
                double above = 0;
                for (std::size_t axis = 0; axis < 3; ++axis) above += (at[axis] - origin[axis]) * normal[axis];
                lowest = std::min(lowest, above / length);
                highest = std::max(highest, above / length);
            }
            if ((lowest >= -tolerance) != (highest <= tolerance)) return true;
        }
        return false;
    }

    void keep_those_that_cross() {
        const LocalFrame frame(mesh_);
        std::vector<std::uint32_t> faces;
        for (std::uint32_t face = 0; face < triangles_.size(); ++face)
            if (is_walked(face)) faces.push_back(face);
        std::vector<std::uint8_t> have_area(faces.size());
        std::vector<Box> boxes(faces.size(), empty_box);
        std::vector<std::uint32_t> surface_of(faces.size());
        for (std::size_t i = 0; i < faces.size(); ++i) surface_of[i] = surfaces_.root(parts_.part[faces[i]]);
        for_each_index(faces.size(), [&](std::size_t i) {
            const Triangle& triangle = triangles_[faces[i]];
            have_area[i] = has_area(faces[i]) ? 1 : 0;
            for (const std::uint32_t vertex : triangle) add(boxes[i], {at(vertex), at(vertex)});
        });
        const BoxIndex index(boxes);
        std::vector<std::uint8_t> cross(triangles_.size());
        for_each_index(
            index.leaf_count(),
            [&](std::size_t leaf) {
                index.for_each_pair(leaf, [&](std::size_t a, std::size_t b) {
                    if (surface_of[a] != surface_of[b] || have_area[a] == 0 || have_area[b] == 0) return;
                    const std::atomic_ref known(cross[surface_of[a]]);
                    if (known.load(std::memory_order_relaxed) != 0) return;
                    if (faces_cross(mesh_.vertices(), triangles_[faces[a]], triangles_[faces[b]]) &&
                        !touch_but_for_rounding(frame, faces[a], faces[b]))
                        known.store(1, std::memory_order_relaxed);
                });
            },
            16);
        for (std::size_t surface = 0; surface < cross.size(); ++surface)
            if (cross[surface] != 0) is_kept_[surface] = true;
    }

    /// The vertex in whose direction a face stands at its edge from a to b. A face without an area stands where its
    /// neighbour does that it joins to the edge. Nothing if that is not known.
    std::optional<std::uint32_t> apex_of(std::uint32_t face, std::uint32_t a, std::uint32_t b) {
        const auto apex_in = [&](std::uint32_t other, std::uint32_t from, std::uint32_t to) {
            for (const std::uint32_t vertex : triangles_[other])
                if (vertex != from && vertex != to) return vertex;
            return from;
        };
        const std::uint32_t middle = apex_in(face, a, b);
        if (has_area(face)) return middle;
        if (!rings_) rings_.emplace(triangles_, mesh_.vertices().size());
        std::vector<EdgeEntry> beside;
        for (const std::uint32_t end : {a, b}) {
            edges_to(
                triangles_, *rings_, middle, [&](std::uint32_t other) { return other == end; }, beside);
            if (beside.size() != 2) continue;
            const std::uint32_t other = beside[beside[0].edge().face == face ? 1 : 0].edge().face;
            if (has_area(other)) return apex_in(other, middle, end);
        }
        return std::nullopt;
    }

    /// Joins the sides that look at each other around an edge; false if two faces lie in each other there.
    bool join_sides(std::span<const EdgeEntry> faces) {
        const std::uint32_t a = triangles_[faces[0].edge().face][faces[0].edge().vertex];
        const std::uint32_t b = triangles_[faces[0].edge().face][next_of_three(faces[0].edge().vertex)];
        std::vector<AtEdge> around;
        for (const EdgeEntry& entry : faces) {
            const auto [face, vertex] = entry.edge();
            const std::optional<std::uint32_t> apex = faces.size() > 2 ? apex_of(face, a, b) : triangles_[face][vertex];
            if (!apex) return false;
            around.push_back({parts_.part[face], (triangles_[face][vertex] == a) != parts_.is_turned[face], *apex});
        }
        const auto turn = [&](const AtEdge& from, const AtEdge& to) {
            return orientation(at(a), at(b), at(from.apex), at(to.apex));
        };
        if (faces.size() > 2) {
            for (AtEdge& one : around) {
                const int side = turn(around[0], one);
                one.quarter = side > 0 ? 1 : side < 0 ? 3 : is_opposite(a, b, around[0].apex, one.apex) ? 2 : 0;
            }
            std::ranges::sort(around, [&](const AtEdge& one, const AtEdge& other) {
                return one.quarter != other.quarter ? one.quarter < other.quarter
                                                    : one.quarter % 2 != 0 && turn(one, other) > 0;
            });
            for (std::size_t n = 0; n + 1 < around.size(); ++n)
                if (around[n].quarter == around[n + 1].quarter && turn(around[n], around[n + 1]) == 0) return false;
        }
        for (std::size_t n = 0; n < around.size(); ++n) {
            const AtEdge &one = around[n], &next = around[(n + 1) % around.size()];
            sides_.join(2 * one.part + (one.is_ahead ? 0 : 1), 2 * next.part + (next.is_ahead ? 1 : 0));
        }
        return true;
    }

    /// Of two vertices in a plane with an edge: whether they are on its two sides.
    bool is_opposite(std::uint32_t a, std::uint32_t b, std::uint32_t one, std::uint32_t other) const {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::size_t first = (axis + 1) % 3, second = (axis + 2) % 3;
            const int side = side_of_line(at(a), at(b), at(one), first, second);
            if (side != 0) return side_of_line(at(a), at(b), at(other), first, second) != side;
        }
        return false;
    }

    /// A surface of sheets alone, and one most of which are sheets that enclose something: a body with a hole.
    void keep_those_that_leak() {
        struct Surface {
            std::uint32_t number = 0;
            std::vector<std::uint32_t> sheets{};
            double area = 0, area_of_sheets = 0;
        };
        std::vector<Surface> surfaces;
        std::vector<std::uint32_t> places(triangles_.size(), none);
        const LocalFrame frame(mesh_);
        for (std::uint32_t face = 0; face < triangles_.size(); ++face) {
            if (!is_walked(face)) continue;
            const std::uint32_t number = surfaces_.root(parts_.part[face]);
            if (places[number] == none) {
                places[number] = static_cast<std::uint32_t>(surfaces.size());
                surfaces.push_back({number});
            }
            Surface& own = surfaces[places[number]];
            const double area = length_of(frame.normal(triangles_[face]));
            own.area += area;
            if (!is_sheet(face)) continue;
            own.area_of_sheets += area;
            own.sheets.push_back(face);
        }
        for (const Surface& own : surfaces)
            if (2 * own.area_of_sheets > own.area &&
                (own.area_of_sheets >= own.area || enclose_something(mesh_, triangles_, own.sheets)))
                is_kept_[own.number] = true;
    }

    void find_bodies() {
        DisjointSets bodies(triangles_.size());
        for_each_edge([&](std::span<const EdgeEntry> faces) {
            const auto is_skin = [&](const EdgeEntry& entry) {
                return is_walked(entry.edge().face) && !is_sheet(entry.edge().face);
            };
            const auto first = std::ranges::find_if(faces, is_skin);
            for (const EdgeEntry& entry : faces)
                if (is_skin(entry)) bodies.join(part_at(*first), part_at(entry));
        });
        std::vector<std::uint32_t> numbers(triangles_.size(), none);
        for (std::uint32_t face = 0; face < triangles_.size(); ++face) {
            if (!is_walked(face) || is_sheet(face)) continue;
            std::uint32_t& number = numbers[bodies.root(parts_.part[face])];
            if (number == none) {
                number = static_cast<std::uint32_t>(bodies_.size());
                bodies_.emplace_back();
            }
            bodies_[number].faces.push_back(face);
        }
        is_inside_.assign(2 * triangles_.size(), false);
    }

    /// The faces of a body that are largest as seen along x: lines along x meet them.
    std::vector<std::uint32_t> largest_along_x(const Body& body, std::size_t most) const {
        const LocalFrame frame(mesh_);
        std::vector<std::pair<double, std::uint32_t>> faces;
        faces.reserve(body.faces.size());
        for (const std::uint32_t face : body.faces)
            faces.emplace_back(-std::abs(frame.normal(triangles_[face])[0]), face);
        const auto end = faces.begin() + static_cast<std::ptrdiff_t>(std::min(most, faces.size()));
        std::ranges::partial_sort(faces, end);
        std::vector<std::uint32_t> found;
        for (auto face = faces.begin(); face != end; ++face) found.push_back(face->second);
        return found;
    }

    /// The region from which a body is seen along x from afar; nothing if no line shows it clearly.
    std::optional<std::uint32_t> outer_region(const Body& body) {
        constexpr std::size_t most_lines = 64;
        for (const std::uint32_t met : largest_along_x(body, most_lines)) {
            Vec3 through{};
            for (const std::uint32_t vertex : triangles_[met])
                for (std::size_t axis = 0; axis < 3; ++axis) through[axis] += at(vertex)[axis] / 3;
            std::optional<std::uint32_t> nearest;
            int side_of_nearest = 0;
            bool is_clear = true;
            for (const std::uint32_t face : body.faces) {
                const std::array corners = corners_of(face);
                const int side = side_of_edges(corners[0], corners[1], corners[2], through);
                if (side == 0) continue;
                const int order = nearest ? compare_places(corners, corners_of(*nearest), through, {1, 0, 0}, {}) : -1;
                if (order <= 0) is_clear = order < 0;
                if (order >= 0) continue;
                nearest = face;
                side_of_nearest = side;
            }
            if (nearest && is_clear) return region(*nearest, side_of_nearest < 0);
        }
        return std::nullopt;
    }
    std::array<Vec3, 3> corners_of(std::uint32_t face) const {
        const Triangle& triangle = triangles_[face];
        return {at(triangle[0]), at(triangle[1]), at(triangle[2])};
    }

    void take_skin(Body& body, std::vector<FaceRole>& roles) {
        const std::optional<std::uint32_t> outer = outer_region(body);
        if (!outer) return;
        // Most of the skin decides whether it looks outwards.
        const LocalFrame frame(mesh_);
        double outwards = 0;
        for (const std::uint32_t face : body.faces)
            for (const bool is_front : {true, false})
                if (region(face, is_front) == *outer)
                    outwards += (is_front ? 1 : -1) * length_of(frame.normal(triangles_[face]));
        const bool looks_inwards = outwards < 0;
        // A cavity has no face to the outside, and all of its faces look into it, as those of a free shell do.
        for (const std::uint32_t face : body.faces)
            for (const bool is_front : {true, false})
                if (const std::uint32_t own = region(face, is_front); own != *outer)
                    is_inside_[own] = is_inside_[own] || region(face, !is_front) == *outer || is_front == looks_inwards;
        const auto is_out = [&](std::uint32_t face, bool is_front) {
            const std::uint32_t own = region(face, is_front);
            return own == *outer || !is_inside_[own];
        };
        for (const std::uint32_t face : body.faces) {
            const bool is_front_out = is_out(face, true);
            roles[face] = is_front_out == is_out(face, false) ? FaceRole::wall
                          : is_front_out == looks_inwards     ? FaceRole::backward
                                                              : FaceRole::forward;
        }
    }

    const Mesh& mesh_;
    std::span<const Triangle> triangles_;
    std::size_t first_closing_;
    OrientedParts parts_;
    DisjointSets sides_;           // 2 * part: its even side; 2 * part + 1: its odd side
    DisjointSets surfaces_;        // parts that are joined over edges
    std::vector<bool> is_kept_;    // by surface: its faces count as before
    std::vector<bool> is_inside_;  // by region
    std::vector<Body> bodies_;
    std::optional<OneRings> rings_;  // if a face without area needs them
};

}  // namespace

std::vector<FaceRole> roles_by_reach(const Mesh& mesh, std::span<const Triangle> triangles, std::size_t closing) {
    Regions regions(mesh, triangles, triangles.size() - closing);
    if (!regions.has_any()) return {};
    std::vector<FaceRole> roles = regions.roles();
    if (std::ranges::all_of(roles, [](FaceRole role) { return role == FaceRole::as_before; })) return {};
    return roles;
}

}  // namespace clsdf
