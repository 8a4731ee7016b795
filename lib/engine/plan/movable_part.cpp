#include "plan/movable_part.hpp"

#include "core/parallel.hpp"
#include "frusta/records.hpp"
#include "lists/surface_points.hpp"
#include "mesh/box_index.hpp"
#include "surface/topology.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace clsdf::engine {

namespace {

/// Beyond rounding, here and in the kernels (ClusterIndex).
constexpr double slack = 1e-3;

double distance_of(const Vec3& a, const Vec3& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// A box that holds the ball that the kernels put around a face, wherever its corners move.
Box box_within_margin(const std::array<Vec3, 3>& corners, double margin) {
    Box box = empty_box;
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        add(box, {corners[k], corners[k]});
        longest = std::max(longest, distance_of(corners[k], corners[(k + 1) % 3]));
    }
    return widened(box, (longest + 3 * margin) * (1 + slack));
}

/// Appends a range, or extends the last one if that ends at `begin`.
void append(std::vector<RecordRange>& ranges, std::size_t begin, std::size_t end) {
    if (!ranges.empty() && ranges.back().end == begin)
        ranges.back().end = end;
    else
        ranges.push_back({begin, end});
}

using Marks = std::vector<std::uint8_t>;

/// The face around a vertex that its point site has: the first in the caller's order.
std::uint32_t face_of_site(const MeshTopology& topology, std::size_t vertex) {
    std::uint32_t first = topology.rings.corner(vertex, 0).face;
    for (std::size_t i = 1; i < topology.rings.size(vertex); ++i) {
        const std::uint32_t face = topology.rings.corner(vertex, i).face;
        if (topology.order[face] < topology.order[first]) first = face;
    }
    return first;
}

/// Marks all faces around the vertices with a mark.
void mark_around(const MeshTopology& topology, const Marks& vertices, Marks& faces) {
    for (std::size_t vertex = 0; vertex < vertices.size(); ++vertex)
        for (std::size_t i = 0; vertices[vertex] != 0 && i < topology.rings.size(vertex); ++i)
            faces[topology.rings.corner(vertex, i).face] = 1;
}

/// The indices with a mark, ascending.
std::vector<std::uint32_t> marked(const Marks& marks) {
    std::vector<std::uint32_t> indices;
    indices.reserve(static_cast<std::size_t>(std::ranges::count(marks, 1)));
    for (std::size_t i = 0; i < marks.size(); ++i)
        if (marks[i] != 0) indices.push_back(static_cast<std::uint32_t>(i));
    return indices;
}

/// For each index its place among those with a mark.
std::vector<std::uint32_t> places_of(const std::vector<std::uint32_t>& indices, std::size_t count) {
    std::vector<std::uint32_t> places(count, MovablePart::no_place);
    for (std::size_t i = 0; i < indices.size(); ++i) places[indices[i]] = static_cast<std::uint32_t>(i);
    return places;
}

}  // namespace

std::size_t MovablePart::host_bytes() const {
    return mesh.vertices().size() * sizeof(Vec3) + mesh.triangles().size() * sizeof(Triangle) +
           (order.size() + numbers.size() + vertices.size() + faces.size() + places.size()) * sizeof(order[0]) +
           sample.size() * sizeof(sample[0]) + loops.host_bytes();
}

NearWithinMargin near_within_margin(const Restriction::NearBoxes& near, const MeshTopology& topology,
                                    const Frusta& frusta, double margin) {
    constexpr std::size_t cluster = ClusterIndex::cluster;
    const BoxIndex boxes(near.boxes), rows(near.rows);
    const std::size_t face_count = topology.order.size(), vertex_count = frusta.positions.size();
    NearWithinMargin found;
    Marks clusters(chunk_count(face_count, cluster)), of_boxes(clusters.size());
    for_each_chunk(face_count, cluster, [&](std::size_t number, std::size_t begin, std::size_t end) {
        Box box = empty_box;
        for (std::size_t face = begin; face < end; ++face) {
            const auto& [a, b, c] = topology.faces.triangles[face];
            add(box, box_within_margin({frusta.positions[a], frusta.positions[b], frusta.positions[c]}, margin));
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double rounding = 1e-4 * (box.upper[axis] - box.lower[axis]);
            box.lower[axis] -= rounding;
            box.upper[axis] += rounding;
        }
        of_boxes[number] = boxes.any(box) ? 1 : 0;
        clusters[number] = of_boxes[number] != 0 || rows.any(box) ? 1 : 0;
    });
    found.blocks.resize(chunk_count(vertex_count, site_block));
    for_each_chunk(vertex_count, site_block, [&](std::size_t number, std::size_t begin, std::size_t end) {
        Box box = empty_box;
        for (std::size_t vertex = begin; vertex < end; ++vertex)
            add(box, {frusta.positions[vertex], frusta.positions[vertex]});
        const double side = box.longest_side();
        found.blocks[number] = boxes.any(widened(box, margin * (1 + slack) + 1e-4 * side)) ? 1 : 0;
    });
    for (std::size_t vertex = 0; vertex < vertex_count; ++vertex)
        if (found.blocks[vertex / site_block] != 0) clusters[face_of_site(topology, vertex) / cluster] = 1;
    if (std::ranges::count(clusters, 1) == 0) clusters[0] = 1;  // a mesh has a triangle

    NearRecords& records = found.records;
    for (std::size_t number = 0; number < clusters.size(); ++number) {
        const std::size_t begin = number * cluster, end = std::min(begin + cluster, face_count);
        if (clusters[number] != 0) append(records.faces, begin, end);
        if (of_boxes[number] != 0) records.face_count += end - begin;
    }
    for (std::size_t site = 0; site < frusta.sites.size(); site += record_group)
        if (found.blocks[frusta.sites[site].vertex / site_block] != 0) {
            append(records.sites, site, site + record_group);
            records.site_count += record_group;
        }
    return found;
}

MovablePart make_movable(const WholeMesh& whole, const MeshPart& part, const NearWithinMargin& near, double margin) {
    const MeshTopology& topology = whole.topology;
    const std::size_t face_count = topology.order.size(), vertex_count = topology.faces.vertices.size();
    const std::vector<Vec3>& positions = whole.mesh.vertices();

    Marks own(face_count), faces(face_count);  // of the part; all
    {
        Marks triangles(whole.mesh.triangles().size());
        for (const std::uint32_t triangle : part.triangles) triangles[triangle] = 1;
        for (std::size_t face = 0; face < face_count; ++face) own[face] = triangles[topology.order[face]];
    }
    Marks decided(vertex_count), at_faces(vertex_count);
    for (std::size_t vertex = 0; vertex < vertex_count; ++vertex) decided[vertex] = near.blocks[vertex / site_block];
    // First the faces whose slopes are asked for, then all around them.
    faces = own;
    mark_around(topology, decided, faces);
    for (std::size_t face = 0; face < face_count; ++face)
        if (faces[face] != 0)
            for (const std::uint32_t vertex : topology.faces.triangles[face]) at_faces[vertex] = 1;
    mark_around(topology, at_faces, faces);

    Marks kept(positions.size());  // vertices of the mesh
    for (std::size_t face = 0; face < face_count; ++face)
        if (faces[face] != 0)
            for (const std::uint32_t vertex : topology.faces.triangles[face]) kept[topology.faces.vertices[vertex]] = 1;
    for (const std::uint32_t vertex : part.vertices) kept[vertex] = 1;
    const std::vector<Triangle> sample = sample_triangles(topology);
    for (const Triangle& triangle : sample)
        for (const std::uint32_t vertex : triangle) kept[topology.faces.vertices[vertex]] = 1;
    if (whole.loops != nullptr)
        for (const std::uint32_t vertex : whole.loops->vertices) kept[vertex] = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double lower = whole.mesh.box().lower[axis], upper = whole.mesh.box().upper[axis];
        const double way = 2 * margin * (1 + slack) + 1e-12 * std::max(std::abs(lower), std::abs(upper));
        for (const std::uint32_t vertex : topology.faces.vertices)
            if (const double x = positions[vertex][axis]; !(x > lower + way && x < upper - way)) kept[vertex] = 1;
    }

    const std::vector<std::uint32_t> all = marked(kept);  // vertices
    const std::vector<std::uint32_t> vertex_places = places_of(all, positions.size());
    Marks kept_triangles(whole.mesh.triangles().size());
    for (std::size_t face = 0; face < face_count; ++face)
        if (faces[face] != 0) kept_triangles[topology.order[face]] = 1;
    const std::vector<std::uint32_t> triangles = marked(kept_triangles);
    const std::vector<std::uint32_t> triangle_places = places_of(triangles, kept_triangles.size());

    std::vector<Vec3> first(all.size());
    for_each_index(all.size(), [&](std::size_t i) { first[i] = positions[all[i]]; });
    std::vector<Triangle> of_part(triangles.size());
    for_each_index(triangles.size(), [&](std::size_t i) {
        for (std::size_t k = 0; k < 3; ++k) of_part[i][k] = vertex_places[whole.mesh.triangles()[triangles[i]][k]];
    });
    MovablePart movable{.margin = margin,
                        .mesh = Mesh(std::move(first), std::move(of_part), whole.mesh.name()),
                        .order = UninitializedVector<std::uint32_t>(triangles.size()),
                        .numbers = whole.vertices.callers_numbers(positions.size()),
                        .vertices = part.vertices,
                        .faces = {},
                        .places = std::vector<std::uint32_t>(all.size(), MovablePart::no_place),
                        .sample = sample};
    std::uint32_t place = 0;
    for (std::size_t face = 0; face < face_count; ++face) {
        if (faces[face] == 0) continue;
        if (own[face] != 0) movable.faces.push_back(place);
        movable.order[place++] = triangle_places[topology.order[face]];
    }
    for (std::size_t i = 0; i < all.size(); ++i) movable.numbers[i] = movable.numbers[all[i]];
    movable.numbers.resize(all.size());
    movable.numbers.shrink_to_fit();
    for (std::uint32_t& vertex : movable.vertices) vertex = vertex_places[vertex];
    for (std::size_t vertex = 0; vertex < vertex_count; ++vertex)
        if (decided[vertex] != 0)
            movable.places[vertex_places[topology.faces.vertices[vertex]]] = static_cast<std::uint32_t>(vertex);
    for (Triangle& triangle : movable.sample)
        for (std::uint32_t& vertex : triangle) vertex = vertex_places[topology.faces.vertices[vertex]];
    if (whole.loops != nullptr) {
        movable.loops = *whole.loops;
        for (std::uint32_t& vertex : movable.loops.vertices) vertex = vertex_places[vertex];
    }
    movable.encloses_negative_volume = clsdf::encloses_negative_volume(whole.mesh, whole.surface, margin);
    return movable;
}

}  // namespace clsdf::engine
