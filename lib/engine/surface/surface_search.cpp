#include "surface/surface_search.hpp"

#include "mesh/join_vertices.hpp"
#include "surface/parts.hpp"

#include <algorithm>
#include <functional>
#include <numeric>

namespace clsdf {

namespace {

/// Whether a face comes an odd number of times, by itself for instance.
bool has_odd_face(std::span<const Triangle> triangles, std::span<const DoubledFace> doubled) {
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
std::vector<Triangle> cancelled_faces(std::span<const Triangle> triangles, std::span<const DoubledFace> doubled,
                                      std::span<const int> net) {
    std::vector<Triangle> result(triangles.size());
    for (const DoubledFace& one : doubled)
        if (net[one.first] == 0) result[one.first] = triangles[one.first];
    return result;
}

}  // namespace

SurfaceSearch::SurfaceSearch(const Mesh& mesh, std::span<const Triangle> triangles, EdgeCounts edges)
    : mesh_(mesh), triangles_(triangles.begin(), triangles.end()), edges_(std::move(edges)) {}

void SurfaceSearch::join_noise() {
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

void SurfaceSearch::count_doubled_once(const std::vector<DoubledFace>& doubled) {
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

void SurfaceSearch::orient_parts(const std::vector<DoubledFace>& doubled) {
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

std::size_t SurfaceSearch::uncounted() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(surface_.faces, [](SignSurface::Use use) { return SignSurface::count_of(use) == 0; }));
}

std::vector<std::uint32_t> SurfaceSearch::close_with(const std::vector<Triangle>& other) {
    const OrientedParts parts(other, mesh_.vertices().size());
    std::vector<std::uint8_t> has_rim(other.size()), fits(other.size(), 1);  // by the lowest face of a part
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

bool SurfaceSearch::is_open(std::uint32_t a, std::uint32_t b) const {
    const UnbalancedEdge edge{std::min(a, b), std::max(a, b)};
    const auto found = std::ranges::lower_bound(edges_.unbalanced, edge, std::less<>());
    return found != edges_.unbalanced.end() && !(edge < *found) && found->is_open;
}

}  // namespace clsdf
