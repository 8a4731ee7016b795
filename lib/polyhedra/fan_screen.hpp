#pragma once

#include "polyhedra/face_edges.hpp"
#include "polyhedra/fan_batch.hpp"
#include "polyhedra/one_rings.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::polyhedra {

/// The faces around a vertex from its first one on, in the order in which they share edges. Each edge has two faces
/// there, of one orientation.
inline void walk_first_fan(std::span<const FaceEdges> edges, const OneRings& rings, std::size_t vertex,
                           std::vector<Corner>& fan) {
    const Corner first = rings.corner(vertex, 0);
    fan.clear();
    Corner corner = first;
    do {
        fan.push_back(corner);
        corner = Corner::unpack(edges[corner.face].across[previous_of_three(corner.vertex)]);
    } while (corner.face != first.face);
}

/// Takes vertices out whose normals their faces surely cover, by a quick test: nearly all.
class FanScreen {
public:
    FanScreen(std::span<const FaceEdges> edges, const OneRings& rings, double margin)
        : edges_(edges), rings_(rings), margin_(margin) {}

    /// A vertex all of whose edges have two faces, of one orientation. `planes` has plane(edge) of those faces' edges.
    template <typename Planes>
    void add(const Planes& planes, std::uint32_t vertex) {
        walk_first_fan(edges_, rings_, vertex, fan_);
        if (fan_.size() > FanBatch::most_faces) {
            left_.push_back(vertex);
            return;
        }
        FanBatch& batch = batches_[fan_.size()];
        batch.add(planes, vertex, fan_);
        if (batch.is_full()) test(batch);
    }

    /// To be left in any case.
    void leave(std::uint32_t vertex) { left_.push_back(vertex); }

    /// Ends with what has been added. Returns the vertices that are left.
    const std::vector<std::uint32_t>& finish() {
        for (FanBatch& batch : batches_) test(batch);
        return left_;
    }

private:
    void test(FanBatch& batch) {
        if (batch.size() == 0) return;
        FanBatch::Answers are_covered;
        batch.ask(margin_, are_covered);
        for (std::size_t i = 0; i < batch.size(); ++i)
            if (are_covered[i] == 0) left_.push_back(batch.vertex(i));
        batch.clear();
    }

    std::span<const FaceEdges> edges_;
    const OneRings& rings_;
    double margin_;
    std::array<FanBatch, FanBatch::most_faces + 1> batches_;  // by number of faces
    std::vector<Corner> fan_;
    std::vector<std::uint32_t> left_;
};

}  // namespace clsdf::polyhedra
