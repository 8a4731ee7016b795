#include "topology/topology.hpp"

#include "core/parallel.hpp"

#include <algorithm>
#include <iterator>
#include <mutex>
#include <utility>
#include <vector>

namespace clsdf::engine {

namespace {

/// Sets the edges that leave one vertex after the other: those of all vertices are all there are.
class EdgePairing {
public:
    EdgePairing(std::span<const Triangle> triangles, const OneRings& rings, std::span<FaceEdges> faces)
        : triangles_(triangles), rings_(rings), faces_(faces) {}

    void set_leaving(std::uint32_t vertex) {
        const auto set_pair = [this](const Corner& edge, const Corner& other) {
            set(edge, Corner{other.face, previous_of_three(other.vertex)}.packed(), 0);
        };
        if (!pair_ring(triangles_, rings_, vertex, set_pair)) set_irregular(vertex);
    }

    /// The ends among the vertices so far.
    const std::vector<std::uint32_t>& non_manifold_ends() const { return non_manifold_ends_; }
    /// Whether an edge that leaves one of the vertices so far has a mark.
    bool has_marks() const { return has_marks_; }

private:
    void set_irregular(std::uint32_t vertex) {
        for (std::size_t i = 0; i < rings_.size(vertex); ++i) {
            const Corner corner = rings_.corner(vertex, i);
            if (start(corner) == triangles_[corner.face][next_of_three(corner.vertex)]) set(corner, 0, edge_at_box);
        }
        bool is_end = false;
        edges_at(triangles_, rings_, vertex, entries_);
        for_each_edge(entries_, [&](std::span<const EdgeEntry> faces) {
            const Corner first = faces.front().edge();
            const Corner last = faces.back().edge();
            if (is_non_manifold(faces)) {
                for (const EdgeEntry& entry : faces)
                    if (start(entry.edge()) == vertex) set(entry.edge(), 0, edge_non_manifold);
                is_end = is_end || vertex < faces[0].other_vertex();
            } else if (faces.size() == 1) {
                if (start(first) == vertex) set(first, 0, edge_open);
            } else {
                const std::uint8_t marks = start(first) == start(last) ? edge_unoriented : 0;
                if (start(first) == vertex) set(first, last.packed(), marks);
                if (start(last) == vertex) set(last, first.packed(), marks);
            }
        });
        if (is_end) non_manifold_ends_.push_back(vertex);
    }

    std::uint32_t start(const Corner& edge) const { return triangles_[edge.face][edge.vertex]; }

    void set(const Corner& edge, std::uint32_t across, std::uint8_t marks) {
        faces_[edge.face].across[edge.vertex] = across;
        faces_[edge.face].marks[edge.vertex] = marks;
        has_marks_ = has_marks_ || marks != 0;
    }

    std::span<const Triangle> triangles_;
    const OneRings& rings_;
    std::span<FaceEdges> faces_;
    std::vector<std::uint32_t> non_manifold_ends_;
    bool has_marks_ = false;
    std::vector<EdgeEntry> entries_;
};

std::uint32_t opposite_word(const MeshTopology& topology, const FaceEdges& edges, std::size_t k) {
    if (edges.marks[k] == edge_open) return CLSDF_NO_VERTEX;
    if (edges.marks[k] != 0) return CLSDF_UNPAIRED_EDGE;
    const Corner across = Corner::unpack(edges.across[k]);
    return topology.faces.triangles[across.face][previous_of_three(across.vertex)] | across.vertex
                                                                                         << CLSDF_OPPOSITE_EDGE;
}

}  // namespace

PairedEdges pair_edges(std::span<const Triangle> triangles, const OneRings& rings) {
    PairedEdges result;
    result.faces = UninitializedVector<FaceEdges>(triangles.size());
    // One after the other first: those around vertices would be waited for, as memory that is far.
    for_each_index(triangles.size(), [&](std::size_t face) { result.faces[face] = {}; });
    result.are_paired = true;
    std::mutex mutex;
    for_each_range(rings.vertex_count(), [&](std::size_t begin, std::size_t end) {
        EdgePairing pairing(triangles, rings, result.faces);
        for (std::size_t vertex = begin; vertex != end; ++vertex)
            pairing.set_leaving(static_cast<std::uint32_t>(vertex));
        if (!pairing.has_marks()) return;
        const std::lock_guard lock(mutex);
        result.are_paired = false;
        result.non_manifold_ends.insert(result.non_manifold_ends.end(), pairing.non_manifold_ends().begin(),
                                        pairing.non_manifold_ends().end());
    });
    std::sort(result.non_manifold_ends.begin(), result.non_manifold_ends.end());
    return result;
}

void VertexFans::build(std::span<const Triangle> triangles, std::span<const FaceEdges> faces, const OneRings& rings,
                       std::size_t vertex) {
    const std::size_t count = rings.size(vertex);
    faces_.clear();
    starts_ = {0};
    walk(triangles, faces, vertex, rings.corner(vertex, 0));
    if (faces_.size() == count) return;

    walked_.assign(count, 0);
    std::size_t known = 0;
    for (std::size_t place = 0; place < count; ++place) {
        for (; known < faces_.size(); ++known) walked_[rings.place(vertex, faces_[known].corner)] = 1;
        if (!walked_[place]) walk(triangles, faces, vertex, rings.corner(vertex, place));
    }
}

void VertexFans::walk(std::span<const Triangle> triangles, std::span<const FaceEdges> faces, std::size_t vertex,
                      Corner first) {
    Corner corner = first;
    bool forward = true;
    do {
        const Triangle& triangle = triangles[corner.face];
        const std::uint32_t next = next_of_three(corner.vertex);
        const std::uint32_t previous = previous_of_three(corner.vertex);
        faces_.push_back({corner, triangle[forward ? next : previous], forward});
        const Corner across = Corner::unpack(faces[corner.face].across[forward ? previous : corner.vertex]);
        forward = triangles[across.face][across.vertex] == vertex;
        corner = {across.face, forward ? across.vertex : next_of_three(across.vertex)};
    } while (corner.face != first.face);
    starts_.push_back(faces_.size());
}

MeshTopology::MeshTopology(const Mesh& mesh) : MeshTopology(mesh, morton_order(mesh)) {}

MeshTopology::MeshTopology(const Mesh& mesh, KeptArray<std::uint32_t> order_in)
    : order(std::move(order_in)),
      faces(ordered_faces(mesh, order)),
      rings(faces.triangles, faces.vertices.size()),
      edges(pair_edges(faces.triangles, rings)) {}

std::uint32_t MeshTopology::original(std::uint32_t face) const {
    if (joined.empty()) return face;
    const auto next = std::ranges::upper_bound(joined, face, {}, &JoinedPart::face_begin);
    return std::min(face, std::prev(next)->face_end - 1);
}

std::size_t MeshTopology::host_bytes() const {
    return order.host_bytes() + faces.triangles.host_bytes() + faces.vertices.host_bytes() + rings.host_bytes() +
           edges.faces.host_bytes();
}

UninitializedVector<std::uint32_t> opposite_words(const MeshTopology& topology) {
    UninitializedVector<std::uint32_t> opposite(3 * topology.order.size());
    for_each_index(topology.order.size(), [&](std::size_t face) {
        for (std::size_t k = 0; k < 3; ++k) {
            opposite[3 * face + k] = opposite_word(topology, topology.edges.faces[face], k);
        }
    });
    return opposite;
}

}  // namespace clsdf::engine
