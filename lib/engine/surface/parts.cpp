#include "surface/parts.hpp"

#include "core/parallel.hpp"
#include "mesh/box_index.hpp"
#include "mesh/disjoint_sets.hpp"
#include "mesh/predicates.hpp"
#include "surface/local_frame.hpp"
#include "surface/ray_side.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

namespace clsdf {

namespace {

/// Twice the area of a face, in the frame's lengths.
double area_of(const LocalFrame& frame, const Triangle& triangle) {
    const Vec3 normal = frame.normal(triangle);
    return std::hypot(normal[0], normal[1], normal[2]);
}

/// Sets of faces, each with an orientation relative to a root of its set.
class OrientedSets {
public:
    explicit OrientedSets(std::size_t count) : parents_(count), sizes_(count, 1), is_odd_(count), is_mixed_(count) {
        std::iota(parents_.begin(), parents_.end(), std::uint32_t{0});
    }

    struct Place {
        std::uint32_t root;
        bool is_odd;
    };
    Place find(std::uint32_t face) const {
        Place place{face, false};
        for (; parents_[place.root] != place.root; place.root = parents_[place.root])
            place.is_odd = place.is_odd != is_odd_[place.root];
        return place;
    }

    /// are_odd: the two faces are oriented differently.
    void join(std::uint32_t a, std::uint32_t b, bool are_odd) {
        Place one = find(a), other = find(b);
        are_odd = are_odd != (one.is_odd != other.is_odd);
        if (one.root == other.root) {
            is_mixed_[one.root] = is_mixed_[one.root] || are_odd;
            return;
        }
        // The smaller set goes to the larger one, so paths are at most as long as the logarithm of the count.
        if (sizes_[one.root] < sizes_[other.root]) std::swap(one, other);
        parents_[other.root] = one.root;
        sizes_[one.root] += sizes_[other.root];
        is_odd_[other.root] = are_odd;
        is_mixed_[one.root] = is_mixed_[one.root] || is_mixed_[other.root];
    }
    /// Whether a face of the root's set would need both orientations.
    bool is_mixed(std::uint32_t root) const { return is_mixed_[root]; }

private:
    std::vector<std::uint32_t> parents_, sizes_;
    std::vector<bool> is_odd_;  // relative to the parent
    std::vector<bool> is_mixed_;
};

}  // namespace

OrientedParts::OrientedParts(std::span<const Triangle> triangles, std::size_t vertex_count)
    : part(triangles.size()), is_turned(triangles.size()), is_orientable(triangles.size(), true) {
    const OneRings rings(triangles, vertex_count);
    OrientedSets sets(triangles.size());
    std::vector<EdgeEntry> at_vertex;
    const auto starts_at = [&](const EdgeEntry& entry) { return triangles[entry.edge().face][entry.edge().vertex]; };
    for (std::uint32_t vertex = 0; vertex < vertex_count; ++vertex) {
        edges_above(triangles, rings, vertex, at_vertex);
        std::erase_if(at_vertex,
                      [&](const EdgeEntry& entry) { return has_repeated_vertex(triangles[entry.edge().face]); });
        for_each_edge(at_vertex, [&](std::span<const EdgeEntry> faces) {
            if (faces.size() == 2) {
                sets.join(faces[0].edge().face, faces[1].edge().face, starts_at(faces[0]) == starts_at(faces[1]));
            } else {
                edges.push_back(entries.size());
                entries.insert(entries.end(), faces.begin(), faces.end());
            }
        });
    }
    edges.push_back(entries.size());
    // The lowest face of each set names it.
    constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> lowest(triangles.size(), none);
    std::vector<bool> is_lowest_odd(triangles.size());
    for (std::uint32_t face = 0; face < triangles.size(); ++face) {
        const auto [root, is_odd] = sets.find(face);
        if (lowest[root] == none) {
            lowest[root] = face;
            is_lowest_odd[root] = is_odd;
            is_orientable[face] = !sets.is_mixed(root);
        }
        part[face] = lowest[root];
        is_turned[face] = is_odd != is_lowest_odd[root];
    }
}

std::vector<std::uint32_t> faces_to_turn(const Mesh& mesh, std::span<const Triangle> triangles, bool are_all_wanted) {
    const OrientedParts parts(triangles, mesh.vertices().size());
    struct Areas {
        double kept = 0, turned = 0;
    };
    const LocalFrame frame(mesh);
    std::vector<Areas> areas(triangles.size());  // by the lowest face
    for (std::uint32_t face = 0; face < triangles.size(); ++face) {
        if (has_repeated_vertex(triangles[face])) continue;
        if (are_all_wanted && !parts.is_orientable[parts.part[face]]) return {};
        Areas& own = areas[parts.part[face]];
        (parts.is_turned[face] ? own.turned : own.kept) += area_of(frame, triangles[face]);
    }
    const double rounding = static_cast<double>(triangles.size() + 16) * std::numeric_limits<double>::epsilon();
    std::vector<std::uint32_t> turned;
    for (std::uint32_t face = 0; face < triangles.size(); ++face) {
        if (has_repeated_vertex(triangles[face]) || !parts.is_orientable[parts.part[face]]) continue;
        const Areas& own = areas[parts.part[face]];
        const bool is_most_turned = own.turned - own.kept > rounding * (own.turned + own.kept);
        if (parts.is_turned[face] != is_most_turned) turned.push_back(face);
    }
    return turned;
}

std::vector<std::uint32_t> inner_walls(const Mesh& mesh, std::span<const Triangle> triangles) {
    const OrientedParts parts(triangles, mesh.vertices().size());
    /// A part at edges of more than two faces.
    struct Wall {
        double area = 0;
        bool is_left_out = false;
        std::vector<std::uint32_t> edges;  ///< an edge as often as the part has faces there
    };
    const std::size_t edge_count = parts.edges.size() - 1;
    std::vector<std::uint8_t> is_odd(edge_count);
    std::vector<Wall> walls(triangles.size());
    for (std::uint32_t edge = 0; edge < edge_count; ++edge)
        for (std::size_t i = parts.edges[edge]; i < parts.edges[edge + 1]; ++i) {
            is_odd[edge] ^= 1U;
            walls[parts.part[parts.entries[i].edge().face]].edges.push_back(edge);
        }
    const LocalFrame frame(mesh);
    for (std::uint32_t face = 0; face < triangles.size(); ++face) {
        Wall& wall = walls[parts.part[face]];
        if (wall.edges.empty()) continue;
        wall.area += area_of(frame, triangles[face]);
    }
    std::vector<std::uint32_t> order;
    for (std::uint32_t part = 0; part < walls.size(); ++part)
        if (!walls[part].edges.empty()) order.push_back(part);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t part) { return walls[part].area; });
    // Leaves out what makes fewer edges odd, whatever the directions of the faces.
    for (const std::uint32_t part : order) {
        Wall& wall = walls[part];
        std::ptrdiff_t change = 0;
        const auto flip = [&](std::uint32_t edge) { change += (is_odd[edge] ^= 1U) != 0 ? 1 : -1; };
        std::ranges::for_each(wall.edges, flip);
        wall.is_left_out = change < 0;
        if (!wall.is_left_out) std::ranges::for_each(wall.edges, flip);
    }
    if (std::ranges::any_of(is_odd, [](std::uint8_t odd) { return odd != 0; })) return {};
    std::vector<std::uint32_t> faces;
    for (std::uint32_t face = 0; face < triangles.size(); ++face)
        if (walls[parts.part[face]].is_left_out) faces.push_back(face);
    return faces;
}

bool is_one_part(std::span<const Triangle> triangles, std::size_t vertex_count) {
    SharedDisjointSets sets(vertex_count);
    std::vector<std::uint8_t> used(vertex_count);
    const std::size_t joined = reduce_ranges(
        triangles.size(), 2048, std::size_t{0},
        [&](std::size_t begin, std::size_t end, std::size_t count) {
            for (std::size_t face = begin; face != end; ++face) {
                const auto& [a, b, c] = triangles[face];
                for (const std::uint32_t vertex : {a, b, c})
                    std::atomic_ref(used[vertex]).store(1, std::memory_order_relaxed);
                count += (sets.join(a, b) ? 1U : 0U) + (sets.join(b, c) ? 1U : 0U);
            }
            return count;
        },
        std::plus<>());
    return joined + 1 >= static_cast<std::size_t>(std::count(used.begin(), used.end(), 1));
}

namespace {

/// A part of a balanced surface that shares no vertex with others.
struct Part {
    std::uint32_t first = 0;  ///< face
    std::size_t faces = 0;
    Box box = empty_box;
    double volume = 0, magnitude = 0;
    int side = 0;  ///< 1: it looks as most of the mesh does; -1: the other way; 0: it encloses nothing
};

/// A ray along -x from a point of a part.
struct Probe {
    Vec3 from;
    std::uint32_t part;
};

/// Rays from a part, at most as many; fewer if there are many parts, and none beyond the last number of them.
constexpr std::size_t most_probes = 128, most_probes_of_all = std::size_t{1} << 20, probes_of_face = 5;

/// The direction in which a ray along -x crosses a face: 1 if it leaves the surface by it, -1 if it enters, 0 if it
/// does not meet it. A ray through an edge or a vertex counts as moved by (e, e^2) in (y, z). Nothing if it begins on
/// the face.
std::optional<int> crossing_of(const Vec3& from, const std::array<Vec3, 3>& corners) {
    const auto& [a, b, c] = corners;
    const int side = side_of_edges(a, b, c, from);
    if (side == 0) return 0;
    const int front = orientation(a, b, c, from);
    if (front == 0) return std::nullopt;
    return front == side ? -side : 0;
}

/// The parts of the mesh, by their lowest faces.
class Parts {
public:
    Parts(const Mesh& mesh, std::span<const Triangle> triangles)
        : mesh_(mesh), triangles_(triangles), part_of_(triangles.size()) {
        DisjointSets sets(mesh.vertices().size());
        for (const auto& triangle : triangles)
            if (!has_repeated_vertex(triangle)) {
                sets.join(triangle[0], triangle[1]);
                sets.join(triangle[0], triangle[2]);
            }
        constexpr std::uint32_t none = 0xFFFFFFFFU;
        std::vector<std::uint32_t> numbers(mesh.vertices().size(), none);
        const LocalFrame frame(mesh);
        for (std::uint32_t face = 0; face < triangles.size(); ++face) {
            const Triangle& triangle = triangles[face];
            part_of_[face] = none;
            if (has_repeated_vertex(triangle)) continue;
            std::uint32_t& number = numbers[sets.root(triangle[0])];
            if (number == none) {
                number = static_cast<std::uint32_t>(parts.size());
                parts.push_back({.first = face});
            }
            part_of_[face] = number;
            Part& part = parts[number];
            ++part.faces;
            for (const std::uint32_t vertex : triangle) add(part.box, {at(vertex), at(vertex)});
            frame.add_volume(triangle, part.volume, part.magnitude);
        }
    }

    std::vector<Part> parts;

    /// The winding numbers of the other parts at points of a part: the least and the greatest at those looked at.
    struct Windings {
        int least = std::numeric_limits<int>::max(), most = std::numeric_limits<int>::min();
    };
    std::vector<Windings> windings(int outward) const {
        const std::vector<Probe> probes = this->probes();
        std::vector<Windings> result(parts.size());
        if (probes.empty()) return result;
        std::vector<Box> rays;
        rays.reserve(probes.size());
        for (const Probe& probe : probes)
            rays.push_back({{-infinite_length, probe.from[1], probe.from[2]}, probe.from});
        const BoxIndex index(rays);
        std::vector<int> counts(probes.size());
        std::vector<char> are_on_surface(probes.size());
        for_each_index(triangles_.size(), [&](std::size_t face) {
            if (part_of_[face] == 0xFFFFFFFFU) return;
            const Triangle& triangle = triangles_[face];
            const std::array corners{at(triangle[0]), at(triangle[1]), at(triangle[2])};
            Box box = empty_box;
            for (const Vec3& corner : corners) add(box, {corner, corner});
            index.any(box, [&](std::size_t number) {
                const Probe& probe = probes[number];
                if (probe.part == part_of_[face]) return false;
                const std::optional<int> crossing = crossing_of(probe.from, corners);
                if (!crossing)
                    std::atomic_ref(are_on_surface[number]).store(1, std::memory_order_relaxed);
                else if (*crossing != 0)
                    std::atomic_ref(counts[number]).fetch_add(*crossing, std::memory_order_relaxed);
                return false;
            });
        });
        for (std::size_t n = 0; n < probes.size(); ++n) {
            if (are_on_surface[n] != 0) continue;
            Windings& own = result[probes[n].part];
            own.least = std::min(own.least, outward * counts[n]);
            own.most = std::max(own.most, outward * counts[n]);
        }
        return result;
    }

private:
    void add_points_of(const Triangle& triangle, std::uint32_t part, std::vector<Probe>& probes) const {
        const Vec3 &a = at(triangle[0]), &b = at(triangle[1]), &c = at(triangle[2]);
        probes.push_back({a, part});
        Vec3 middle{};
        for (std::size_t axis = 0; axis < 3; ++axis) middle[axis] = a[axis] / 3 + b[axis] / 3 + c[axis] / 3;
        probes.push_back({middle, part});
        for (const auto& [from, to] : {std::pair(a, b), {b, c}, {c, a}}) {
            for (std::size_t axis = 0; axis < 3; ++axis) middle[axis] = from[axis] / 2 + to[axis] / 2;
            probes.push_back({middle, part});
        }
    }

    const Vec3& at(std::uint32_t vertex) const { return mesh_.vertices()[vertex]; }

    /// Of parts whose boxes overlap another one: a vertex of some of their faces, the middle and those of the edges,
    /// and the vertices that are farthest out.
    std::vector<Probe> probes() const {
        std::vector<Box> boxes;
        for (const Part& part : parts) boxes.push_back(part.box);
        const std::size_t most = std::min(most_probes, 6 + most_probes_of_all / parts.size()) - 6;
        const BoxIndex index(boxes);
        std::vector<std::size_t> steps(parts.size()), seen(parts.size());
        for_each_index(parts.size(), [&](std::size_t n) {
            const bool is_near = index.any(boxes[n], [n](std::size_t other) { return other != n; });
            if (is_near && parts[n].side != 0)
                steps[n] = chunk_count(parts[n].faces, std::max<std::size_t>(most / probes_of_face, 1));
        });
        std::vector<Probe> result;
        std::vector<std::array<bool, 6>> is_found(parts.size());
        for (std::size_t face = 0; face < triangles_.size(); ++face) {
            const std::uint32_t number = part_of_[face];
            if (number == 0xFFFFFFFFU || steps[number] == 0) continue;
            const Part& part = parts[number];
            if (seen[number]++ % steps[number] == 0) add_points_of(triangles_[face], number, result);
            for (const std::uint32_t vertex : triangles_[face])
                for (std::size_t limit = 0; limit < 6; ++limit) {
                    const std::size_t axis = limit / 2;
                    if (at(vertex)[axis] != (limit % 2 == 0 ? part.box.lower : part.box.upper)[axis]) continue;
                    if (std::exchange(is_found[number][limit], true)) continue;
                    result.push_back({at(vertex), number});
                }
        }
        return result;
    }

    const Mesh& mesh_;
    std::span<const Triangle> triangles_;
    std::vector<std::uint32_t> part_of_;  // by face
};

}  // namespace

void describe_parts(const Mesh& mesh, std::span<const Triangle> triangles, Topology& report) {
    Parts all(mesh, triangles);
    report.parts = all.parts.size();
    if (report.parts < 2 || report.parts > most_probes_of_all) return;
    const int outward = report.inside_out ? -1 : 1;
    const double rounding = static_cast<double>(triangles.size() + 16) * std::numeric_limits<double>::epsilon();
    for (Part& part : all.parts) {
        const double volume = outward * part.volume, least = rounding * part.magnitude;
        part.side = volume > least ? 1 : volume < -least ? -1 : 0;
    }
    const std::vector<Parts::Windings> windings = all.windings(outward);
    std::vector<Box> boxes;
    for (const Part& part : all.parts) boxes.push_back(part.box);
    const BoxIndex index(boxes);
    const auto is_in_another = [&](std::size_t n) {
        return index.any(boxes[n], [&](std::size_t other) {
            if (other == n) return false;
            for (std::size_t axis = 0; axis < 3; ++axis)
                if (boxes[n].lower[axis] < boxes[other].lower[axis] || boxes[n].upper[axis] > boxes[other].upper[axis])
                    return false;
            return true;
        });
    };
    for (std::size_t n = 0; n < all.parts.size(); ++n) {
        const auto [least, most] = windings[n];
        const Part& part = all.parts[n];
        const bool is_judged = least <= most;
        if (is_judged && least < 1 && most >= 1 && report.overlapping_parts++ == 0)
            report.first_overlapping_face = part.first;
        if (part.side < 0 && (!is_judged || least < 1)) {
            if (report.inward_parts++ == 0) report.first_inward_face = part.first;
        } else if (part.side > 0 && is_judged && least > 0 && is_in_another(n)) {  // else a bar between two parts
            if (report.nested_parts++ == 0) report.first_nested_face = part.first;
        }
    }
}

}  // namespace clsdf
