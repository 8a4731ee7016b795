#include "plan/part_mover.hpp"

#include <clsdf/error.hpp>

#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "mesh/mesh_arrays.hpp"
#include "surface/terrain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ranges>
#include <utility>

namespace clsdf::engine {

Box PartMover::checked_box(std::span<const Vec3> positions) const {
    const MovablePart& part = *movable_;
    const std::string& name = part.mesh.name();
    const std::vector<Vec3>& first = part.mesh.vertices();
    if (positions.size() != first.size())
        refuse(
            "the part of {} has {} vertices, and {} positions are given; give one for each number "
            "of part_vertices()",
            name, first.size(), positions.size());
    Box box = empty_box;
    for (std::size_t vertex = 0; vertex < first.size(); ++vertex) {
        const Vec3 &from = first[vertex], &to = positions[vertex];
        if (!is_finite(to))
            throw Error(ErrorCode::invalid_mesh,
                        fmt::format("{}: vertex {}, counted from 0, moves to ({}, {}, {}), which is not finite", name,
                                    part.numbers[vertex], to[0], to[1], to[2]));
        const double way = std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
        if (!(way <= part.margin))
            refuse(
                "vertex {} of {}, counted from 0, moves by {} from ({}, {}, {}) to ({}, {}, {}), "
                "and the part has the margin {}; restrict the whole transform at positions "
                "nearby, or with a larger margin",
                part.numbers[vertex], name, way, from[0], from[1], from[2], to[0], to[1], to[2], part.margin);
        add(box, {to, to});
    }
    return without_negative_zeros(box);
}

MovedPart PartMover::moved(std::span<const Vec3> positions, const MeshTopology& topology, const SignSurface& surface) {
    const MovablePart& part = *movable_;
    MovedPart moved;
    moved.box = checked_box(positions);
    if (part.loops.floor) check_floor(*part.loops.floor, moved.box, part.mesh.name());
    moved.positions.resize(part.vertices.size());
    for_each_index(moved.positions.size(), [&](std::size_t i) { moved.positions[i] = positions[part.vertices[i]]; });
    check_joined(part.mesh.name(), moved.box, surface, moved.positions,
                 [&](std::uint32_t vertex) { return part.numbers[part.vertices[vertex]]; });

    if (!faces_)
        faces_ = std::make_unique<HomedMesh>(kept_, tools_, part.mesh,
                                             std::make_shared<const MeshTopology>(part.mesh, part.order));
    faces_->move({positions.begin(), positions.end()}, moved.box);
    moved.frusta = part_of(faces_->frusta(), topology, moved.positions);
    // The next move makes these again.
    for (KeptValue* value : std::views::reverse(kept_)) {
        if (value->made_of == MadeOf::positions) value->forget();
        value->leave_device();
    }

    moved.sample.resize(part.sample.size());
    for (std::size_t i = 0; i < part.sample.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) moved.sample[i][k] = positions[part.sample[i][k]];
    if (!part.loops.empty()) moved.boundary = std::make_shared<const OpenBoundary>(part.loops, positions);
    moved.encloses_negative_volume = part.encloses_negative_volume;
    return moved;
}

Frusta PartMover::part_of(const Frusta& all, const MeshTopology& topology, std::span<const Vec3> positions) const {
    const MovablePart& part = *movable_;
    const auto place_in = [](const std::vector<std::uint32_t>& list, std::uint32_t value) {
        return static_cast<std::uint32_t>(std::ranges::lower_bound(list, value) - list.begin());
    };
    // Bytes that were made by something else may have a site that the part has no face or vertex of.
    const auto place_of = [&](const std::vector<std::uint32_t>& list, std::uint32_t value) {
        const std::uint32_t place = place_in(list, value);
        if (place == list.size() || list[place] != value)
            refuse(
                "the part of {} has a point site at a vertex or face that it does not have; make "
                "it again, of the whole transform",
                part.mesh.name());
        return place;
    };
    Frusta frusta;
    frusta.positions = ordered_positions(topology, positions);
    frusta.slopes.resize(part.faces.size());
    for_each_index(part.faces.size(), [&](std::size_t i) { frusta.slopes[i] = all.slopes[part.faces[i]]; });
    for (const std::uint32_t sliver : all.slivers)
        if (const std::uint32_t place = place_in(part.faces, sliver);
            place < part.faces.size() && part.faces[place] == sliver)
            frusta.slivers.push_back(place);
    frusta.saddle_vertices = all.saddle_vertices;
    frusta.boxes = all.boxes;

    std::vector<std::uint32_t> numbers(positions.size());  // of the part's vertices, in its topology
    for (std::size_t i = 0; i < topology.faces.vertices.size(); ++i)
        numbers[topology.faces.vertices[i]] = static_cast<std::uint32_t>(i);
    /// A site that the part decides, by the numbers of the whole's topology.
    struct Decided {
        std::uint32_t place;
        SiteFrustum site;
    };
    std::vector<Decided> decided;
    const KeptArray<std::uint32_t>& vertices = faces_->topology().faces.vertices;
    for (const SiteFrustum& site : all.sites) {
        const std::uint32_t vertex = vertices[site.vertex], place = part.places[vertex];
        if (place == MovablePart::no_place || is_filling(site)) continue;
        decided.push_back({place, site});
        decided.back().site.vertex = numbers[place_of(part.vertices, vertex)];
        decided.back().site.face = place_of(part.faces, site.face);
    }
    std::ranges::sort(decided, {}, &Decided::place);
    std::vector<std::uint32_t> blocks;
    for (const auto& [place, site] : decided) {
        blocks.push_back(place / site_block);
        frusta.sites.push_back(site);
    }
    frusta.sites = in_groups(frusta.sites, blocks);
    return frusta;
}

KeptMemory PartMover::memory() const {
    KeptMemory sum{.host_bytes = movable_->host_bytes()};
    for (const KeptValue* value : kept_) {
        const KeptMemory memory = value->memory();
        sum.host_bytes += memory.host_bytes;
        sum.device_bytes += memory.device_bytes;
    }
    return sum;
}

}  // namespace clsdf::engine
