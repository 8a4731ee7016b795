#include "cutting/plane_patches.hpp"

#include "core/vectors.hpp"
#include "mesh/disjoint_sets.hpp"
#include "mesh/one_rings.hpp"
#include "mesh/predicates.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace clsdf::cutting {

namespace {

/// Whether two faces that run along a common edge in opposite directions lie in one plane, side by side.
bool are_side_by_side(std::span<const Vec3> vertices, const Triangle& one, const Triangle& other) {
    const std::array corners{vertices[one[0]], vertices[one[1]], vertices[one[2]]};
    const auto normal_of = [&](const Triangle& face) {
        return cross(difference(vertices[face[1]], vertices[face[0]]),
                     difference(vertices[face[2]], vertices[face[0]]));
    };
    const Vec3 first = normal_of(one), second = normal_of(other);
    if (!(dot(first, second) > 0.999 * length(first) * length(second))) return false;
    return std::ranges::all_of(other, [&](std::uint32_t v) {
        return std::ranges::find(one, v) != one.end() ||
               orientation(corners[0], corners[1], corners[2], vertices[v]) == 0;
    });
}

}  // namespace

void PlanePatches::find() const {
    within_.assign(triangles_.size(), 0);
    const OneRings rings(triangles_, vertices_.size());
    DisjointSets sets(triangles_.size());
    std::vector<EdgeEntry> entries;
    for (std::uint32_t vertex = 0; vertex < vertices_.size(); ++vertex) {
        edges_above(triangles_, rings, vertex, entries);
        for_each_edge(entries, [&](std::span<const EdgeEntry> faces) {
            if (faces.size() != 2) return;
            const Corner one = faces[0].edge(), other = faces[1].edge();
            if ((triangles_[one.face][one.vertex] == vertex) == (triangles_[other.face][other.vertex] == vertex) ||
                surface_.count(one.face) != surface_.count(other.face) ||
                !are_side_by_side(vertices_, triangles_[one.face], triangles_[other.face]))
                return;
            within_[one.face] = static_cast<std::uint8_t>(within_[one.face] | 1U << one.vertex);
            within_[other.face] = static_cast<std::uint8_t>(within_[other.face] | 1U << other.vertex);
            sets.join(one.face, other.face);
        });
    }
    lowest_.resize(triangles_.size());
    for (std::uint32_t face = 0; face < lowest_.size(); ++face) lowest_[face] = sets.root(face);
}

}  // namespace clsdf::cutting
