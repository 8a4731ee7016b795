#include "surface/surface_search.hpp"

#include "mesh/join_vertices.hpp"
#include "surface/corners_in_edges.hpp"
#include "surface/double_sided.hpp"
#include "surface/parts.hpp"
#include "surface/regions.hpp"
#include "surface/topology.hpp"

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

}  // namespace

SurfaceSearch::SurfaceSearch(const Mesh& mesh, std::span<const Triangle> triangles, EdgeCounts edges)
    : mesh_(&mesh), given_(triangles), triangles_(triangles.begin(), triangles.end()), edges_(std::move(edges)) {}

void SurfaceSearch::join_noise() {
    std::vector<std::uint32_t> ends;
    for (const UnbalancedEdge& edge : edges_.unbalanced) {
        ends.push_back(edge.lower);
        ends.push_back(edge.higher);
    }
    std::ranges::sort(ends);
    const auto repeated = std::ranges::unique(ends);
    ends.erase(repeated.begin(), repeated.end());
    const Box& box = mesh_->box();
    double half_side = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        half_side = std::max(half_side, 0.5 * box.upper[axis] - 0.5 * box.lower[axis]);
    const std::vector<JoinedVertex> joined =
        join_vertices(mesh_->vertices(), std::move(ends), 2 * joining_tolerance * half_side);
    if (joined.empty()) return;
    joined_ = joined.size();
    surface_.vertices.resize(mesh_->vertices().size());
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
        if (const SubSurface* const cancelled = cancelled_faces(doubled))
            for (const std::uint32_t face : close_with(*cancelled)) uses[face] = SignSurface::forward;
    const bool is_opened = edges_before.open() == 0 && !is_closed() && has_odd_face(before, doubled);
    if (is_opened || edges_.unbalanced.size() > edges_before.unbalanced.size()) {
        triangles_ = before;
        edges_ = std::move(edges_before);
        return;
    }
    surface_.faces = std::move(uses);
}

void SurfaceSearch::count_bodies_once(const std::vector<DoubledFace>& doubled, bool may_open) {
    const SubSurface* const cancelled = cancelled_faces(doubled);
    if (cancelled == nullptr) return;
    double volume = 0;
    std::vector<CountedFace> counted =
        double_sided_bodies(*mesh_, *cancelled, triangles_, loops_of(edges_), may_open, volume);
    if (counted.empty()) return;
    // Both ways are there, so the bodies look as the rest of the mesh does.
    if (volume != 0 && (volume < 0) != encloses_negative_volume(*mesh_, surface_))
        for (CountedFace& one : counted) one.is_turned = !one.is_turned;
    if (surface_.faces.empty()) surface_.faces.assign(triangles_.size(), SignSurface::forward);
    std::vector<bool> is_counted(triangles_.size());
    for (const auto& [face, is_turned] : counted) {
        is_counted[face] = true;
        surface_.faces[face] = is_turned ? SignSurface::backward : SignSurface::forward;
        triangles_[face] = given(face);
        if (is_turned) turn(face);
    }
    for (const DoubledFace& one : doubled) {
        if (!is_counted[one.first]) continue;
        surface_.faces[one.face] = (surface_.faces[one.first] > 0) != one.is_reversed ? SignSurface::unused_forward
                                                                                      : SignSurface::unused_backward;
        drop(one.face);
    }
    double_sided_ = counted.size();
    count();
}

void SurfaceSearch::orient_parts(const std::vector<DoubledFace>& doubled) {
    const bool was_closed = is_closed();
    // Turning faces balances no edge of an odd number of them.
    if (std::ranges::all_of(edges_.unbalanced, &UnbalancedEdge::is_open)) return;
    const std::vector<std::uint32_t> faces = faces_to_turn(*mesh_, triangles_, was_closed);
    if (faces.empty()) return;
    const std::vector<Triangle> triangles_before = triangles_;
    for (const std::uint32_t face : faces) turn(face);
    EdgeCounts before = std::move(edges_);
    count();
    // A body that turning closes has few of the points, so their doubt alone would leave it as it is.
    const auto is_clear_or_no_more_in_doubt = [&] {
        const WindingTest& test = winding_test();
        if (test.is_clear()) return true;
        WindingTally tally;
        tally.add(WindingView(*mesh_, triangles_before, loops_of(before)).at(test.points));
        return test.all.doubtful <= tally.doubtful;
    };
    const bool is_kept = was_closed
                             ? is_balanced()
                             : edges_.unbalanced.size() < before.unbalanced.size() && is_clear_or_no_more_in_doubt();
    if (!is_kept) {
        triangles_ = triangles_before;
        edges_ = std::move(before);
        test_.reset();
        return;
    }
    take_turned(faces, doubled);
}

Sheets SurfaceSearch::leave_out_walls(const std::vector<DoubledFace>& doubled) {
    if (edges_.non_manifold == 0) return {};
    // Faces of the same three vertices are one face, as given.
    std::vector<Triangle> faces(given_.size());
    for (std::uint32_t face = 0; face < faces.size(); ++face) faces[face] = given(face);
    for (const DoubledFace& one : doubled) faces[one.face] = {};
    // A corner of faces that lies in an edge of another one is no hole.
    const std::size_t given_count = faces.size();
    const std::vector<Triangle> closing = corners_in_edges_of_walls(*mesh_, faces);
    faces.insert(faces.end(), closing.begin(), closing.end());
    std::vector<FaceRole> roles = roles_by_reach(*mesh_, faces, closing.size());
    if (roles.empty()) return {};
    roles.resize(given_count);
    if (surface_.faces.empty()) surface_.faces.assign(triangles_.size(), SignSurface::forward);
    if (is_turned_.empty()) is_turned_.resize(triangles_.size());
    Sheets sheets;
    for (std::uint32_t face = 0; face < roles.size(); ++face) {
        const FaceRole role = roles[face];
        if (role == FaceRole::as_before) continue;
        if (role == FaceRole::wall || role == FaceRole::sheet) {
            if (SignSurface::count_of(surface_.faces[face]) == 0) continue;
            sheets.left_out.push_back(face);
            (role == FaceRole::wall ? sheets.walls : sheets.open).push_back(face);
            is_turned_[face] = false;
            continue;
        }
        triangles_[face] = faces[face];
        is_turned_[face] = role == FaceRole::backward;
        surface_.faces[face] = is_turned_[face] ? SignSurface::backward : SignSurface::forward;
        if (is_turned_[face]) turn(face);
    }
    leave_out(sheets.left_out);
    direct_equal_faces(doubled);
    count();
    return sheets;
}

Sheets SurfaceSearch::leave_out_sheets(const std::vector<DoubledFace>& doubled) {
    Sheets sheets = find_sheets(*mesh_, triangles_);
    if (sheets.left_out.empty()) return sheets;
    if (are_beside_cancelled_faces(sheets.left_out, doubled)) return {};
    if (surface_.faces.empty()) surface_.faces.assign(triangles_.size(), SignSurface::forward);
    for (const std::uint32_t face : sheets.turned) turn(face);
    take_turned(sheets.turned, doubled);
    leave_out(sheets.left_out);
    count();
    return sheets;
}

void SurfaceSearch::leave_out(std::span<const std::uint32_t> faces) {
    if (is_left_out_.empty()) is_left_out_.resize(triangles_.size());
    for (const std::uint32_t face : faces) {
        is_left_out_[face] = true;
        drop(face);
        SignSurface::Use& use = surface_.faces[face];
        use = use > 0 ? SignSurface::unused_forward : SignSurface::unused_backward;
    }
}

bool SurfaceSearch::are_beside_cancelled_faces(std::span<const std::uint32_t> faces,
                                               const std::vector<DoubledFace>& doubled) const {
    using Edge = std::pair<std::uint32_t, std::uint32_t>;
    const auto edge_of = [](const Triangle& triangle, std::uint32_t k) {
        const std::uint32_t from = triangle[k], to = triangle[next_of_three(k)];
        return Edge{std::min(from, to), std::max(from, to)};
    };
    std::vector<Edge> edges;
    for (const DoubledFace& one : doubled)
        if (!surface_.faces.empty() && SignSurface::count_of(surface_.faces[one.first]) == 0)
            for (std::uint32_t k = 0; k < 3; ++k) edges.push_back(edge_of(given(one.first), k));
    std::ranges::sort(edges);
    return std::ranges::any_of(faces, [&](std::uint32_t face) {
        const Triangle triangle = given(face);
        bool is_beside = false;
        for (std::uint32_t k = 0; k < 3; ++k)
            is_beside = is_beside || std::ranges::binary_search(edges, edge_of(triangle, k));
        return is_beside;
    });
}

const WindingTest& SurfaceSearch::winding_test() {
    if (!test_) test_ = test_winding_number(*mesh_, triangles_, loops_of(edges_));
    return *test_;
}

const WindingTest& SurfaceSearch::winding_test_with_covered_parts() {
    if (winding_test().has_clear_parts) test_ = test_winding_number(*mesh_, triangles_, loops_of(edges_), true);
    return *test_;
}

void SurfaceSearch::take_turned(std::span<const std::uint32_t> faces, const std::vector<DoubledFace>& doubled) {
    const bool has_uses = !surface_.faces.empty();
    if (!has_uses) surface_.faces.assign(triangles_.size(), SignSurface::forward);
    if (is_turned_.empty()) is_turned_.resize(triangles_.size());
    for (const std::uint32_t face : faces) {
        surface_.faces[face] = surface_.faces[face] > 0 ? SignSurface::backward : SignSurface::forward;
        is_turned_[face] = !is_turned_[face];
    }
    if (has_uses) direct_equal_faces(doubled);
}

void SurfaceSearch::direct_equal_faces(const std::vector<DoubledFace>& doubled) {
    for (const DoubledFace& one : doubled)
        if (SignSurface::count_of(surface_.faces[one.first]) != 0 &&
            SignSurface::count_of(surface_.faces[one.face]) == 0)
            surface_.faces[one.face] = (surface_.faces[one.first] > 0) != one.is_reversed
                                           ? SignSurface::unused_forward
                                           : SignSurface::unused_backward;
}

Triangle SurfaceSearch::given(std::uint32_t face) const {
    Triangle triangle = given_[face];
    for (std::uint32_t& index : triangle) index = surface_.vertex(index);
    return triangle;
}

std::size_t SurfaceSearch::reoriented() const {
    std::size_t count = 0;
    for (std::size_t face = 0; face < is_turned_.size(); ++face)
        count += is_turned_[face] && (is_left_out_.empty() || !is_left_out_[face]) ? 1U : 0U;
    return count;
}

std::size_t SurfaceSearch::uncounted() const {
    std::size_t count = 0;
    for (std::size_t face = 0; face < surface_.faces.size(); ++face)
        count +=
            SignSurface::count_of(surface_.faces[face]) == 0 && (is_left_out_.empty() || !is_left_out_[face]) ? 1U : 0U;
    return count;
}

const SubSurface* SurfaceSearch::cancelled_faces(const std::vector<DoubledFace>& doubled) {
    std::vector<int> net(triangles_.size());
    for (const DoubledFace& one : doubled) net[one.first] += one.is_reversed ? -1 : 1;
    std::vector<std::uint32_t> faces;
    for (const DoubledFace& one : doubled) {
        // The sum of a group is that of its later faces, and the first.
        if (net[one.first] != -1 || (!surface_.faces.empty() && SignSurface::count_of(surface_.faces[one.first]) != 0))
            continue;
        net[one.first] = 0;
        faces.push_back(one.first);
    }
    if (faces.empty()) return nullptr;
    std::ranges::sort(faces);
    if (!cancelled_ || cancelled_->faces != faces) {
        std::vector<Triangle> triangles;
        triangles.reserve(faces.size());
        for (const std::uint32_t face : faces) triangles.push_back(given(face));
        cancelled_.emplace(*mesh_, triangles, std::move(faces));
    }
    return &*cancelled_;
}

std::vector<std::uint32_t> SurfaceSearch::close_with(const SubSurface& other) {
    const OrientedParts& parts = other.parts;
    std::vector<std::uint8_t> has_rim(other.faces.size()), fits(other.faces.size(), 1);  // by the lowest face of a part
    for (std::size_t i = 0; i + 1 < parts.edges.size(); ++i) {
        if ((parts.edges[i + 1] - parts.edges[i]) % 2 == 0) continue;
        for (std::size_t n = parts.edges[i]; n < parts.edges[i + 1]; ++n) {
            const Corner corner = parts.entries[n].edge();
            const std::uint32_t part = parts.part[corner.face];
            const Triangle face = given(other.faces[corner.face]);
            has_rim[part] = 1;
            if (!is_open(face[corner.vertex], face[next_of_three(corner.vertex)])) fits[part] = 0;
        }
    }
    std::vector<std::uint32_t> added;
    for (std::size_t i = 0; i < other.faces.size(); ++i)
        if (has_rim[parts.part[i]] != 0 && fits[parts.part[i]] != 0) added.push_back(other.faces[i]);
    if (added.empty()) return {};
    EdgeCounts before = edges_;
    for (const std::uint32_t face : added) triangles_[face] = given(face);
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
