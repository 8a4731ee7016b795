#include "frusta/cluster_index.hpp"

#include "core/parallel.hpp"
#include "mesh/box_index.hpp"
#include "mesh/mesh_arrays.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace clsdf::detail {

/// Sets what need not be found from a mesh's triangles.
struct MeshAccess {
    static Mesh without_arrays(std::string name, const Box& box) {
        Mesh mesh;
        mesh.name_ = std::move(name);
        mesh.box_ = box;
        return mesh;
    }
    static void set_triangles(Mesh& mesh, std::vector<Triangle> triangles) { mesh.triangles_ = std::move(triangles); }
    static void set_box(Mesh& mesh, const Box& box) { mesh.box_ = box; }
    static void set_positions(Mesh& mesh, std::vector<Vec3> positions) { mesh.vertices_ = std::move(positions); }
};

}  // namespace clsdf::detail

namespace clsdf::engine {

namespace {

/// Around the foot of the altitude on the longest edge: the ball that the kernels put around a face. The kernel
/// cluster_boxes has the same.
Box box_of(const std::array<Vec3, 3>& corners) {
    std::array<Vector, 3> at{to_vector(corners[0]), to_vector(corners[1]), to_vector(corners[2])};
    std::size_t base = 0;
    double squared = -1;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vector side = at[(k + 1) % 3] - at[k];
        const double length = dot(side, side);
        if (length > squared) {
            squared = length;
            base = k;
        }
    }
    const Vector edge = at[(base + 1) % 3] - at[base];
    const double length = std::abs(edge.x()) + std::abs(edge.y()) + std::abs(edge.z());
    // Squares of very long and very short edges leave a double's range.
    const bool has_square = squared > 1e-280 && squared < 1e280;
    const double along = has_square ? std::clamp(dot(at[(base + 2) % 3] - at[base], edge) / squared, 0.0, 1.0) : 0;
    // An altitude on the longest edge is at most sqrt(3) / 2 of it.
    const double extent =
        has_square ? std::sqrt(squared) * std::max({along, 1 - along, 0.8661}) * (1 + 1e-6) : 2 * length;
    const Vector foot = at[base] + along * edge;
    Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double x = foot[static_cast<int>(axis)];
        const double rounding = 1e-15 * std::abs(x);
        box.lower[axis] = x - extent - rounding;
        box.upper[axis] = x + extent + rounding;
    }
    for (const Vec3& corner : corners) add(box, {corner, corner});
    return box;
}

/// Kernels compute the box in float, relative to the cluster's first face. This covers their rounding.
void widen(Box& box) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double rounding = 4e-5 * (box.upper[axis] - box.lower[axis]);
        box.lower[axis] -= rounding;
        box.upper[axis] += rounding;
    }
}

/// Appends a range, or extends the last one if that ends at `begin`.
void append(std::vector<RecordRange>& ranges, std::size_t begin, std::size_t end) {
    if (!ranges.empty() && ranges.back().end == begin)
        ranges.back().end = end;
    else
        ranges.push_back({begin, end});
}

}  // namespace

std::vector<Box> cluster_boxes(std::span<const Triangle> triangles, std::span<const Vec3> positions) {
    std::vector<Box> boxes(chunk_count(triangles.size(), ClusterIndex::cluster), empty_box);
    for_each_chunk(triangles.size(), ClusterIndex::cluster,
                   [&](std::size_t number, std::size_t begin, std::size_t end) {
                       for (const auto& [a, b, c] : triangles.subspan(begin, end - begin))
                           add(boxes[number], box_of({positions[a], positions[b], positions[c]}));
                   });
    return boxes;
}

ClusterIndex::ClusterIndex(std::size_t face_count, std::vector<Box> clusters, const Frusta& of_sites)
    : face_count_(face_count),
      site_count_(of_sites.sites.size()),
      clusters_(std::move(clusters)),
      superclusters_(chunk_count(clusters_.size(), supercluster), empty_box),
      sites_(chunk_count(site_count_, record_group), empty_box) {
    for (std::size_t number = 0; number < clusters_.size(); ++number) {
        widen(clusters_[number]);
        add(superclusters_[number / supercluster], clusters_[number]);
    }
    for (std::size_t site = 0; site < site_count_; ++site) {
        const Vec3 at = of_sites.positions[of_sites.sites[site].vertex];
        add(sites_[site / record_group], box_of({at, at, at}));
    }
    for (Box& box : sites_) widen(box);
}

NearRecords ClusterIndex::near(std::span<const Box> boxes) const {
    const BoxIndex given(boxes);
    const auto is_near = [&](const Box& box) { return given.any(box); };
    NearRecords found;
    for (std::size_t b = 0; b < superclusters_.size(); ++b) {
        if (!is_near(superclusters_[b])) continue;
        for (std::size_t c = b * supercluster; c < std::min((b + 1) * supercluster, clusters_.size()); ++c)
            if (is_near(clusters_[c])) append(found.faces, c * cluster, std::min((c + 1) * cluster, face_count_));
    }
    for (std::size_t s = 0; s < sites_.size(); ++s)
        if (is_near(sites_[s])) append(found.sites, s * record_group, std::min((s + 1) * record_group, site_count_));
    for (const RecordRange& range : found.faces) found.face_count += range.end - range.begin;
    for (const RecordRange& range : found.sites) found.site_count += range.end - range.begin;
    return found;
}

namespace {

constexpr std::uint32_t absent = 0xFFFFFFFFU;

/// The faces of clusters that are wanted, ascending.
std::vector<std::uint32_t> faces_of(const Frusta& frusta, const NearRecords& near, std::size_t face_count) {
    std::vector<bool> is_wanted(chunk_count(face_count, ClusterIndex::cluster));
    for (const RecordRange& range : near.faces)
        for (std::size_t face = range.begin; face < range.end; face += ClusterIndex::cluster)
            is_wanted[face / ClusterIndex::cluster] = true;
    for (const RecordRange& range : near.sites)
        for (std::size_t site = range.begin; site < range.end; ++site)
            is_wanted[frusta.sites[site].face / ClusterIndex::cluster] = true;
    const auto clusters = static_cast<std::size_t>(std::count(is_wanted.begin(), is_wanted.end(), true));
    std::vector<std::uint32_t> faces;
    faces.reserve(clusters * ClusterIndex::cluster);
    for (std::size_t face = 0; face < face_count; ++face)
        if (is_wanted[face / ClusterIndex::cluster]) faces.push_back(static_cast<std::uint32_t>(face));
    return faces;
}

/// For each of `count` numbers its place in an ascending list, or `absent`.
UninitializedVector<std::uint32_t> places_in(const std::vector<std::uint32_t>& list, std::size_t count) {
    UninitializedVector<std::uint32_t> places(count);
    for_each_index(count, [&](std::size_t i) { places[i] = absent; });
    for_each_index(list.size(), [&](std::size_t i) { places[list[i]] = static_cast<std::uint32_t>(i); });
    return places;
}

/// The part may lack faces of an edge. The edge stays non-manifold: records need the mark.
void keep_non_manifold(const PairedEdges& whole, const std::vector<std::uint32_t>& faces, MeshTopology& part) {
    if (whole.non_manifold_ends.empty()) return;
    std::vector<std::uint32_t>& ends = part.edges.non_manifold_ends;
    for (std::size_t i = 0; i < faces.size(); ++i)
        for (std::uint32_t k = 0; k < 3; ++k) {
            if (!has_mark(whole.faces, {faces[i], k}, edge_non_manifold)) continue;
            part.edges.faces[i].marks[k] |= edge_non_manifold;
            const Triangle& triangle = part.faces.triangles[i];
            ends.push_back(std::min(triangle[k], triangle[next_of_three(k)]));
        }
    std::sort(ends.begin(), ends.end());
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
}

}  // namespace

MeshPart part_of(const Mesh& mesh, const SignSurface& surface, const MeshTopology& topology, const Frusta& frusta,
                 const NearRecords& near) {
    const std::vector<std::uint32_t> faces = faces_of(frusta, near, topology.order.size());
    // The lists are kept: their memory has just their size.
    std::vector<std::uint32_t> triangles(faces.size()), vertices;
    for_each_index(faces.size(), [&](std::size_t i) { triangles[i] = topology.order[faces[i]]; });
    std::sort(triangles.begin(), triangles.end());
    std::vector<bool> is_used(mesh.vertices().size());
    for (const std::uint32_t triangle : triangles)
        for (const std::uint32_t vertex : mesh.triangles()[triangle])
            is_used[vertex] = is_used[surface.vertex(vertex)] = true;
    vertices.reserve(static_cast<std::size_t>(std::count(is_used.begin(), is_used.end(), true)));
    for (std::size_t vertex = 0; vertex < is_used.size(); ++vertex)
        if (is_used[vertex]) vertices.push_back(static_cast<std::uint32_t>(vertex));
    std::vector<Vec3> positions(vertices.size());
    for_each_index(vertices.size(), [&](std::size_t i) { positions[i] = mesh.vertices()[vertices[i]]; });
    const auto vertex_places = places_in(vertices, mesh.vertices().size());
    const auto triangle_places = places_in(triangles, mesh.triangles().size());
    std::vector<Triangle> of_part(triangles.size());
    for_each_index(triangles.size(), [&](std::size_t i) {
        for (std::size_t k = 0; k < 3; ++k) of_part[i][k] = vertex_places[mesh.triangles()[triangles[i]][k]];
    });
    UninitializedVector<std::uint32_t> order(faces.size());
    for_each_index(faces.size(), [&](std::size_t i) { order[i] = triangle_places[topology.order[faces[i]]]; });

    SignSurface of_surface;
    if (!surface.vertices.empty())
        for (const std::uint32_t vertex : vertices)
            of_surface.vertices.push_back(vertex_places[surface.vertex(vertex)]);
    if (!surface.faces.empty())
        for (const std::uint32_t triangle : triangles) of_surface.faces.push_back(surface.faces[triangle]);

    MeshPart part{Mesh(std::move(positions), std::move(of_part), mesh.name()),
                  std::move(of_surface),
                  std::move(triangles),
                  nullptr,
                  {}};
    clsdf::detail::MeshAccess::set_box(part.mesh, mesh.box());
    auto made = std::make_shared<MeshTopology>(part.mesh, std::move(order));
    keep_non_manifold(topology.edges, faces, *made);
    part.topology = std::move(made);
    const OrderedFaces& ordered = part.topology->faces;

    Frusta& result = part.frusta;
    result.positions.resize(ordered.vertices.size());
    UninitializedVector<std::uint32_t> numbers(part.mesh.vertices().size());  // of the part's vertices, in its topology
    for_each_index(ordered.vertices.size(), [&](std::size_t i) {
        result.positions[i] = part.mesh.vertices()[ordered.vertices[i]];
        numbers[ordered.vertices[i]] = static_cast<std::uint32_t>(i);
    });
    result.slopes.resize(faces.size());
    for_each_index(faces.size(), [&](std::size_t i) { result.slopes[i] = frusta.slopes[faces[i]]; });
    const auto face_place = [&](std::uint32_t face) { return std::lower_bound(faces.begin(), faces.end(), face); };
    for (const RecordRange& range : near.sites)
        for (std::size_t i = range.begin; i < range.end; ++i) {
            SiteFrustum site = frusta.sites[i];
            site.vertex = numbers[vertex_places[topology.faces.vertices[site.vertex]]];
            site.face = static_cast<std::uint32_t>(face_place(site.face) - faces.begin());
            result.sites.push_back(site);
        }
    for (const std::uint32_t sliver : frusta.slivers)
        if (const auto place = face_place(sliver); place != faces.end() && *place == sliver)
            result.slivers.push_back(static_cast<std::uint32_t>(place - faces.begin()));
    result.saddle_vertices = frusta.saddle_vertices;
    result.boxes = frusta.boxes;
    return part;
}

Mesh mesh_without_arrays(const Box& box) {
    return clsdf::detail::MeshAccess::without_arrays("mesh", box);
}

void set_arrays(Mesh& mesh, MeshArrays arrays) {
    clsdf::detail::MeshAccess::set_positions(mesh, std::move(arrays.vertices));
    clsdf::detail::MeshAccess::set_triangles(mesh, std::move(arrays.triangles));
}

void move(Mesh& mesh, const MeshTopology& topology, std::vector<Vec3> positions) {
    const UninitializedVector<std::uint32_t>& used = topology.faces.vertices;
    Extent all;
    if (positions.size() == mesh.vertices().size()) {
        constexpr std::size_t grain = 4096;
        all = reduce_ranges(
            used.size(), grain, all,
            [&](std::size_t begin, std::size_t end, Extent extent) {
                for (std::size_t i = begin; i != end; ++i) extent.add(positions[used[i]]);
                return extent;
            },
            [](Extent a, const Extent& b) {
                a.add(b);
                return a;
            });
    } else {
        all.zero = std::numeric_limits<double>::quiet_NaN();
    }
    if (!all.is_finite()) {
        mesh.set_positions(std::move(positions));  // which finds what is wrong
        return;
    }
    move(mesh, without_negative_zeros(all.box), std::move(positions));
}

void move(Mesh& mesh, const Box& box, std::vector<Vec3> positions) {
    clsdf::detail::MeshAccess::set_positions(mesh, std::move(positions));
    move(mesh, box);
}

void move(Mesh& mesh, const Box& box) {
    clsdf::detail::MeshAccess::set_box(mesh, box);
}

void set_ordered_positions(Mesh& mesh, const MeshTopology& topology, std::span<const Vec3> ordered) {
    std::vector<Vec3> positions = mesh.vertices();
    for_each_index(ordered.size(), [&](std::size_t i) { positions[topology.faces.vertices[i]] = ordered[i]; });
    clsdf::detail::MeshAccess::set_positions(mesh, std::move(positions));
}

}  // namespace clsdf::engine
