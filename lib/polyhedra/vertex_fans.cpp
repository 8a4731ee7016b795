#include "polyhedra/vertex_fans.hpp"

#include <algorithm>

namespace clsdf::polyhedra {

void VertexFans::build(std::span<const Triangle> triangles, const OneRings& rings, std::size_t vertex) {
    const auto count = static_cast<std::uint32_t>(rings.size(vertex));
    const auto after = [&](const Corner& corner) { return triangles[corner.face][next_of_three(corner.vertex)]; };
    const auto before = [&](const Corner& corner) { return triangles[corner.face][previous_of_three(corner.vertex)]; };

    spokes_.clear();
    for (std::uint32_t place = 0; place < count; ++place) {
        const Corner corner = rings.corner(vertex, place);
        spokes_.push_back({after(corner), place});
        spokes_.push_back({before(corner), place});
    }
    std::sort(spokes_.begin(), spokes_.end(), [](const Spoke& a, const Spoke& b) {
        return a.neighbour != b.neighbour ? a.neighbour < b.neighbour : a.place < b.place;
    });

    faces_.clear();
    starts_ = {0};
    used_.assign(count, 0);
    for (std::uint32_t start = 0; start < count; ++start) {
        if (used_[start]) continue;
        std::uint32_t place = start;
        std::uint32_t neighbour = after(rings.corner(vertex, start));
        while (!used_[place]) {
            used_[place] = 1;
            const Corner corner = rings.corner(vertex, place);
            const bool forward = after(corner) == neighbour;
            faces_.push_back({corner, neighbour, forward});
            neighbour = forward ? before(corner) : after(corner);
            place = other_place(neighbour, place);
        }
        starts_.push_back(faces_.size());
    }
}

std::uint32_t VertexFans::other_place(std::uint32_t neighbour, std::uint32_t place) const {
    const auto first = std::lower_bound(spokes_.begin(), spokes_.end(), neighbour,
                                        [](const Spoke& spoke, std::uint32_t n) { return spoke.neighbour < n; });
    return first->place == place ? std::next(first)->place : first->place;
}

}  // namespace clsdf::polyhedra
