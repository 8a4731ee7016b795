#include "polyhedra/complete_frusta.hpp"

#include "core/parallel.hpp"
#include "polyhedra/edge_slopes.hpp"
#include "polyhedra/gaps.hpp"
#include "polyhedra/records.hpp"
#include "polyhedra/side_of_plane.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace clsdf::polyhedra {

namespace {

using Numbers = std::vector<std::uint32_t>;

void sort_and_unite(Numbers& numbers) {
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

/// Collects f(part, begin, end), lists of numbers of sub-ranges, one after the other.
template <typename Function>
Numbers collected(std::size_t count, const Function& f) {
    constexpr std::size_t stretch = 1U << 16;
    std::vector<Numbers> parts(stretch_count(count, stretch));
    for_each_stretch(count, stretch,
                     [&](std::size_t part, std::size_t begin, std::size_t end) { f(begin, end, parts[part]); });
    if (parts.size() == 1) return std::move(parts.front());
    Numbers all;
    for (const Numbers& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

/// The faces with an answer.
Numbers answered_faces(std::span<const std::uint8_t> answers) {
    return collected(answers.size(), [&](std::size_t begin, std::size_t end, Numbers& found) {
        const std::uint8_t* const first = answers.data();
        for (std::size_t face = begin; face < end;) {
            constexpr std::size_t step = 64;
            const std::size_t last = std::min(end, face + step);
            if (std::any_of(first + face, first + last, [](std::uint8_t answer) { return answer != 0; }))
                for (std::size_t i = face; i < last; ++i)
                    if (first[i] != 0) found.push_back(static_cast<std::uint32_t>(i));
            face = last;
        }
    });
}

class Completion {
public:
    Completion(const MeshTopology& topology, const KernelTopology& of_kernels, const KernelAnswers& answers,
               const FirstRecords* first, CompletionMemory& memory, Frusta& frusta)
        : topology_(topology),
          of_kernels_(of_kernels),
          answers_(answers),
          first_(first),
          memory_(memory),
          frusta_(frusta),
          lattice_(first != nullptr ? first->lattice : view_of(frusta.positions)),
          faces_{frusta.positions, topology.faces.triangles, lattice_} {
        memory.edges.faces.resize(topology.order.size());
        memory.edges.non_manifold_ends = topology.edges.non_manifold_ends;
        memory.edges.non_manifold_corners = topology.edges.non_manifold_corners;
        memory.vertex_marks.resize(topology.rings.vertex_count());
    }

    bool run() {
        awkward_ = answered_faces(answers_.faces);
        for (const std::uint32_t face : awkward_)
            if ((answers_.faces[face] & CLSDF_FACE_IS_SLIVER) != 0) frusta_.slivers.push_back(face);
        awkward_.insert(awkward_.end(), of_kernels_.awkward_faces.begin(), of_kernels_.awkward_faces.end());
        sort_and_unite(awkward_);
        if (!are_few(awkward_.size(), topology_.order.size())) return false;
        measure_awkward_faces();

        Numbers left = of_kernels_.awkward_vertices;
        std::size_t saddles = look_at_fans(left);
        const Numbers faces = faces_around(left);
        std::vector<FramePlanes::Directions> directions(faces.size());
        for_each_index(faces.size(), [&](std::size_t i) { directions[i] = look_at_face(faces[i]); });
        find_gaps(faces_, memory_.edges.faces, topology_.rings, FramePlanes(directions, frusta_.slopes, faces),
                  rejection_margin, left, memory_.vertex_marks);
        std::sort(left.begin(), left.end());
        Numbers gaps;
        for (const std::uint32_t vertex : left) {
            saddles += (memory_.vertex_marks[vertex] & vertex_saddle) != 0 ? 1U : 0U;
            if ((memory_.vertex_marks[vertex] & vertex_gap) != 0) gaps.push_back(vertex);
        }
        frusta_.saddle_vertices = saddles + border_saddles();
        frusta_.sites.resize(gaps.size());
        for_each_index(gaps.size(), [&](std::size_t i) {
            frusta_.sites[i] = point_site(faces_, topology_.order, topology_.faces.vertices, topology_.rings, gaps[i]);
        });
        return true;
    }

private:
    /// By the host's own way, a sub-range of one face at a time.
    void measure_awkward_faces() {
        if (awkward_.empty()) return;
        for (const std::uint32_t face : awkward_) memory_.edges.faces[face] = topology_.edges.faces[face];
        const std::vector<EdgeSlope> of_non_manifold =
            non_manifold_slopes(faces_, topology_.rings, memory_.edges, CLSDF_OPEN_SLOPE);
        tbb::enumerable_thread_specific<EdgeSlopes> measures(
            [&] { return EdgeSlopes(faces_, memory_.edges.faces, of_non_manifold, CLSDF_OPEN_SLOPE); });
        std::atomic<std::size_t> boxes = 0;
        for_each_range(awkward_.size(), [&](std::size_t begin, std::size_t end) {
            EdgeSlopes& measure = measures.local();
            for (std::size_t i = begin; i < end; ++i) {
                const std::uint32_t face = awkward_[i];
                measure.measure(face, face + 1);
                const TriangleFrame& frame = measure.frame(face);
                lean(frame, measure.slopes(face));
                if (frame.is_box) ++boxes;
                frusta_.slopes[face] = measure.slopes(face);
                if (first_ != nullptr)
                    write_face_record(topology_, frusta_, lattice_, face, frame, first_->records[face]);
            }
        });
        frusta_.boxes = boxes;
    }

    /// Adds the vertices of fans that are left to the host, and counts saddle vertices among the others.
    std::size_t look_at_fans(Numbers& left) const {
        std::atomic<std::size_t> saddles = 0;
        const Numbers open =
            collected(of_kernels_.fan_items.size(), [&](std::size_t begin, std::size_t end, Numbers& found) {
                std::size_t saddles_here = 0;
                for (std::size_t number = begin; number < end; ++number) {
                    const FanItem& item = of_kernels_.fan_items[number];
                    const std::uint8_t* const answers = &answers_.fan_vertices[number * CLSDF_FAN_ITEM];
                    for (std::uint32_t i = 0; i < item.count; ++i) {
                        saddles_here += answers[i] == CLSDF_VERTEX_IS_SADDLE ? 1U : 0U;
                        if ((answers[i] & CLSDF_VERTEX_IS_OPEN) != 0) found.push_back(vertex_of(item, i));
                    }
                }
                saddles += saddles_here;
            });
        left.insert(left.end(), open.begin(), open.end());
        return saddles;
    }

    std::uint32_t vertex_of(const FanItem& item, std::uint32_t i) const {
        const std::uint32_t block = CLSDF_FAN_STRIDE * (1 + 2 * item.faces);
        return of_kernels_.fan_words[item.offset + i / CLSDF_FAN_STRIDE * block + i % CLSDF_FAN_STRIDE];
    }

    /// All faces around the vertices, ascending.
    Numbers faces_around(const Numbers& vertices) const {
        Numbers faces;
        for (const std::uint32_t vertex : vertices)
            for (std::size_t i = 0; i < topology_.rings.size(vertex); ++i)
                faces.push_back(topology_.rings.corner(vertex, i).face);
        sort_and_unite(faces);
        return faces;
    }

    /// The directions of a face's frame. Sets the marks of its edges.
    FramePlanes::Directions look_at_face(std::uint32_t face) {
        const TriangleFrame frame = faces_.frame(face);
        if (!std::binary_search(awkward_.begin(), awkward_.end(), face)) {
            FaceEdges& edges = memory_.edges.faces[face] = topology_.edges.faces[face];
            edges.base = static_cast<std::uint8_t>(frame.base_edge);
            for (std::uint32_t k = 0; k < 3; ++k) edges.marks[k] |= mark_of(face, k);
        }
        return {frame.normal, frame.inwards};
    }

    /// The mark of an edge that follows from the positions.
    std::uint8_t mark_of(std::uint32_t face, std::uint32_t k) const {
        const FaceEdges& edges = topology_.edges.faces[face];
        if (edges.marks[k] != 0) return 0;
        const float sign = answers_.signs[3 * std::size_t{face} + k];
        if (std::isinf(sign)) return edge_open | edge_folded;
        int side = (sign < 0 ? 1 : 0) - (sign > 0 ? 1 : 0);
        if (side == 0) side = side_of_plane(OppositeVertex(faces_, face, Corner::unpack(edges.across[k])));
        if (side == 0) return 0;
        return side < 0 ? edge_convex : edge_concave;
    }

    /// Saddle vertices at open edges.
    std::size_t border_saddles() const {
        std::atomic<std::size_t> saddles = 0;
        const Numbers& vertices = of_kernels_.border_vertices;
        for_each_range(vertices.size(), [&](std::size_t begin, std::size_t end) {
            std::size_t saddles_here = 0;
            for (std::size_t n = begin; n < end; ++n) {
                bool convex = false, concave = false;
                for (std::size_t i = 0; i < topology_.rings.size(vertices[n]); ++i) {
                    const Corner corner = topology_.rings.corner(vertices[n], i);
                    for (const std::uint32_t k : {corner.vertex, previous_of_three(corner.vertex)}) {
                        const float sign = answers_.signs[3 * std::size_t{corner.face} + k];
                        convex |= sign > 0 && !std::isinf(sign);
                        concave |= sign < 0;
                    }
                }
                saddles_here += convex && concave ? 1U : 0U;
            }
            saddles += saddles_here;
        });
        return saddles;
    }

    const MeshTopology& topology_;
    const KernelTopology& of_kernels_;
    const KernelAnswers& answers_;
    const FirstRecords* first_;
    CompletionMemory& memory_;
    Frusta& frusta_;
    LatticeView lattice_;
    MeshFaces faces_;
    Numbers awkward_;  // faces, ascending
};

}  // namespace

bool complete_frusta(const MeshTopology& topology, const KernelTopology& of_kernels, const KernelAnswers& answers,
                     const FirstRecords* first, CompletionMemory& memory, Frusta& frusta) {
    return Completion(topology, of_kernels, answers, first, memory, frusta).run();
}

}  // namespace clsdf::polyhedra
