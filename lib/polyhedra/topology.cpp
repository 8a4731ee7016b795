#include "polyhedra/topology.hpp"

#include "core/parallel.hpp"

#include <algorithm>
#include <array>
#include <mutex>
#include <utility>
#include <vector>

namespace clsdf::polyhedra {

/// Each part of the faces has vertices of its own, a range of their numbers, and files the corners there, so that no
/// two parts write to one ring. Corners that its faces have at other parts' vertices it sets aside for those.
class OneRings::Filing {
public:
    /// The beginning of a part: its first face and its first vertex.
    struct Border {
        std::size_t face, vertex;
    };

    /// The last border is the end of both.
    Filing(std::span<const Triangle> triangles, std::vector<Border> borders, OneRings& rings)
        : triangles_(triangles), borders_(std::move(borders)), rings_(rings), parts_(borders_.size() - 1) {}

    void run() {
        rings_.start_[0] = 0;
        for_each_part([&](std::size_t part) { count(part); });
        for_each_part([&](std::size_t part) { count_set_aside(part); });
        std::uint32_t corners = 0;
        for (Part& part : parts_) {
            part.first_corner = corners;
            corners += part.corner_count;
        }
        for_each_part([&](std::size_t part) { file(part); });
    }

private:
    /// A corner at a vertex of another part.
    struct SetAside {
        std::uint32_t vertex;
        std::uint32_t corner;

        friend bool operator<(const SetAside& a, const SetAside& b) {
            return a.vertex != b.vertex ? a.vertex < b.vertex : a.corner < b.corner;
        }
    };

    struct Part {
        std::vector<SetAside> set_aside;
        std::uint32_t corner_count = 0;  ///< at its vertices
        std::uint32_t first_corner = 0;  ///< the place of the first of them
    };

    template <typename Function>
    void for_each_part(const Function& f) {
        for_each_chunk(parts_.size(), 1, [&](std::size_t part, std::size_t, std::size_t) { f(part); });
    }

    /// Calls own(vertex, corner) for corners of the part's faces at its own vertices, other(vertex, corner) elsewhere.
    template <typename Own, typename Other>
    void for_each_corner(std::size_t part, const Own& own, const Other& other) const {
        const auto first = static_cast<std::uint32_t>(borders_[part].vertex);
        const auto count = static_cast<std::uint32_t>(borders_[part + 1].vertex) - first;
        for (std::size_t face = borders_[part].face; face < borders_[part + 1].face; ++face)
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t vertex = triangles_[face][k];
                const std::uint32_t corner = Corner{static_cast<std::uint32_t>(face), k}.packed();
                if (vertex - first < count) {
                    own(vertex, corner);
                } else {
                    other(vertex, corner);
                }
            }
    }

    /// The corners that one part has set aside for another, by vertex and face.
    std::span<const SetAside> set_aside(std::size_t from, std::size_t part) const {
        const std::vector<SetAside>& all = parts_[from].set_aside;
        const auto place = [&](std::size_t vertex) {
            return std::lower_bound(all.begin(), all.end(), vertex,
                                    [](const SetAside& a, std::size_t v) { return a.vertex < v; });
        };
        return {place(borders_[part].vertex), place(borders_[part + 1].vertex)};
    }

    void count(std::size_t part) {
        std::uint32_t* const start = rings_.start_.data();
        // Counted one place further on, so that filing turns each ring's start into the next one's.
        std::fill(start + borders_[part].vertex + 1, start + borders_[part + 1].vertex + 1, 0U);
        std::vector<SetAside> aside;
        for_each_corner(
            part, [&](std::uint32_t vertex, std::uint32_t) { ++start[vertex + 1]; },
            [&](std::uint32_t vertex, std::uint32_t corner) {
                aside.push_back({vertex, corner});
            });
        std::sort(aside.begin(), aside.end());
        const std::size_t faces = borders_[part + 1].face - borders_[part].face;
        parts_[part].corner_count = static_cast<std::uint32_t>(3 * faces - aside.size());
        parts_[part].set_aside = std::move(aside);
    }

    void count_set_aside(std::size_t part) {
        for (std::size_t from = 0; from < parts_.size(); ++from)
            for (const SetAside& aside : set_aside(from, part)) {
                ++rings_.start_[aside.vertex + 1];
                ++parts_[part].corner_count;
            }
    }

    void file(std::size_t part) {
        std::uint32_t* const start = rings_.start_.data();
        std::uint32_t* const corners = rings_.corners_.data();
        std::uint32_t next = parts_[part].first_corner;
        for (std::size_t vertex = borders_[part].vertex; vertex < borders_[part + 1].vertex; ++vertex)
            next += std::exchange(start[vertex + 1], next);
        const auto take = [&](std::uint32_t vertex, std::uint32_t corner) { corners[start[vertex + 1]++] = corner; };
        const auto take_from = [&](std::size_t from) {
            for (const SetAside& aside : set_aside(from, part)) take(aside.vertex, aside.corner);
        };
        for (std::size_t from = 0; from < part; ++from) take_from(from);
        for_each_corner(part, take, [](std::uint32_t, std::uint32_t) {});
        for (std::size_t from = part + 1; from < parts_.size(); ++from) take_from(from);
    }

    std::span<const Triangle> triangles_;
    std::vector<Border> borders_;
    OneRings& rings_;
    std::vector<Part> parts_;
};

OneRings::OneRings(std::span<const Triangle> triangles, std::size_t vertex_count)
    : start_(vertex_count + 1), corners_(3 * checked_face_count(triangles.size())) {
    const std::size_t size = chunk_for_all_cores(triangles.size(), OrderedFaces::chunk);
    const std::size_t parts = std::max<std::size_t>(1, chunk_count(triangles.size(), size));
    std::vector<Filing::Border> borders;
    for (std::size_t part = 0; part <= parts; ++part)
        borders.push_back({std::min(triangles.size(), part * size), vertex_count * part / parts});
    Filing(triangles, std::move(borders), *this).run();
}

OneRings::OneRings(const OrderedFaces& faces)
    : start_(faces.vertices.size() + 1), corners_(3 * faces.triangles.size()) {
    const std::size_t count = faces.triangles.size();
    const std::size_t size = chunk_for_all_cores(count, OrderedFaces::chunk);
    std::vector<Filing::Border> borders;
    for (std::size_t face = 0; face < count; face += size)
        borders.push_back({face, faces.first_vertices[face / OrderedFaces::chunk]});
    borders.push_back({count, faces.vertices.size()});
    Filing(faces.triangles, std::move(borders), *this).run();
}

namespace {

/// So many faces are compared with each other.
constexpr std::size_t few_faces = 16;

using OfFewFaces = std::array<std::uint32_t, few_faces>;
using FewCorners = std::array<Corner, few_faces>;

/// Faces around a vertex: the vertices at the ends of their edges that leave it, and that arrive there.
struct Spokes {
    OfFewFaces next;
    OfFewFaces previous;
};

/// To each edge that leaves the vertex, those that run along it.
struct Matches {
    OfFewFaces other;  ///< the last of the edges that arrive
    OfFewFaces arriving;
    OfFewFaces leaving;
};

CLSDF_SEVERAL_TARGETS Matches match(const Spokes& spokes, std::size_t count) {
    Matches matches{};
    for (std::size_t j = 0; j < count; ++j) {
        const std::uint32_t next = spokes.next[j];
        const std::uint32_t previous = spokes.previous[j];
        for (std::size_t i = 0; i < few_faces; ++i) {
            matches.other[i] = spokes.next[i] == previous ? static_cast<std::uint32_t>(j) : matches.other[i];
            matches.arriving[i] += spokes.next[i] == previous ? 1U : 0U;
            matches.leaving[i] += spokes.next[i] == next ? 1U : 0U;
        }
    }
    return matches;
}

/// Sets the edges that leave one vertex after the other: those of all vertices are all there are.
class EdgePairing {
public:
    EdgePairing(std::span<const Triangle> triangles, const OneRings& rings, std::span<FaceEdges> faces)
        : triangles_(triangles), rings_(rings), faces_(faces) {}

    void set_leaving(std::uint32_t vertex) {
        if (!set_pairs(vertex)) set_any(vertex);
    }

    /// The ends among the vertices so far.
    const std::vector<std::uint32_t>& non_manifold_ends() const { return non_manifold_ends_; }

private:
    /// Sets the pairs of a vertex whose edges all have two faces that run along them in opposite directions. Returns
    /// false for any other vertex, and if it has many faces.
    bool set_pairs(std::uint32_t vertex) {
        const std::size_t count = rings_.size(vertex);
        if (count > few_faces) return false;
        FewCorners corners;  // not cleared: this is done for every vertex
        Spokes spokes{};
        for (std::size_t i = 0; i < count; ++i) {
            corners[i] = rings_.corner(vertex, i);
            const Triangle& triangle = triangles_[corners[i].face];
            spokes.next[i] = triangle[next_of_three(corners[i].vertex)];
            spokes.previous[i] = triangle[previous_of_three(corners[i].vertex)];
        }
        const Matches matches = match(spokes, count);
        bool paired = true;
        for (std::size_t i = 0; i < count; ++i) {
            const Corner& across = corners[matches.other[i]];
            // A face with a vertex twice arrives along the edge that it leaves by.
            paired &= matches.arriving[i] == 1 && matches.leaving[i] == 1 && across.face != corners[i].face;
            set(corners[i], Corner{across.face, previous_of_three(across.vertex)}.packed(), 0);
        }
        return paired;
    }

    void set_any(std::uint32_t vertex) {
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
    }

    std::span<const Triangle> triangles_;
    const OneRings& rings_;
    std::span<FaceEdges> faces_;
    std::vector<std::uint32_t> non_manifold_ends_;
    std::vector<EdgeEntry> entries_;
};

}  // namespace

PairedEdges pair_edges(std::span<const Triangle> triangles, const OneRings& rings) {
    PairedEdges result;
    result.faces = UninitializedVector<FaceEdges>(triangles.size());
    // One after the other first: those around vertices would be waited for, as memory that is far.
    for_each_index(triangles.size(), [&](std::size_t face) { result.faces[face] = {}; });
    std::mutex mutex;
    for_each_range(rings.vertex_count(), [&](std::size_t begin, std::size_t end) {
        EdgePairing pairing(triangles, rings, result.faces);
        for (std::size_t vertex = begin; vertex != end; ++vertex)
            pairing.set_leaving(static_cast<std::uint32_t>(vertex));
        if (pairing.non_manifold_ends().empty()) return;
        const std::lock_guard lock(mutex);
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

MeshTopology::MeshTopology(const Mesh& mesh, UninitializedVector<std::uint32_t> order_in)
    : order(std::move(order_in)),
      faces(ordered_faces(mesh, order)),
      rings(faces),
      edges(pair_edges(faces.triangles, rings)) {}

std::size_t MeshTopology::bytes() const {
    return order.size() * sizeof(order[0]) + faces.triangles.size() * sizeof(Triangle) +
           faces.vertices.size() * sizeof(std::uint32_t) + rings.bytes() + edges.faces.size() * sizeof(FaceEdges);
}

}  // namespace clsdf::polyhedra
