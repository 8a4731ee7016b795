#pragma once

#include "polyhedra/one_rings.hpp"
#include "polyhedra/triangle_frame.hpp"

#include <array>
#include <cstddef>

namespace clsdf::polyhedra {

/// Pairs of faces at an edge, as many at a time as a processor's vectors hold.
class PairBatch {
public:
    static constexpr std::size_t capacity = 8;

    struct Pair {
        Corner first;  ///< the edge, as each of the faces has it
        Corner second;
        bool oriented;  ///< the faces run along it in opposite directions
    };

    bool is_full() const { return size_ == capacity; }
    std::size_t size() const { return size_; }
    void clear() { size_ = 0; }

    void add(const Pair& pair, const TriangleFrame& first, const TriangleFrame& second) {
        const std::size_t i = size_++;
        pairs_[i] = pair;
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            inputs_.first[a][i] = first.inwards[pair.first.vertex][axis];
            inputs_.second[a][i] = second.inwards[pair.second.vertex][axis];
            inputs_.normal[a][i] = first.normal[axis];
        }
    }

    const Pair& pair(std::size_t i) const { return pairs_[i]; }

    struct Results {
        std::array<double, capacity> sine;           ///< of the second face's inward direction above the first's plane
        std::array<double, capacity> squared_apart;  ///< of the distance of their inward directions
        /// The tangent of half the angle by which the wedge between the faces exceeds a straight one, seen from the
        /// side where it does; both faces have the same. Of folded faces it means nothing.
        std::array<double, capacity> slope;
    };
    void measure(Results& results) const;

private:
    using Components = std::array<std::array<double, capacity>, 3>;

    struct Inputs {
        Components first;
        Components second;
        Components normal;
    };

    std::size_t size_ = 0;
    std::array<Pair, capacity> pairs_{};
    Inputs inputs_{};  // what lies beyond the size is measured too, and of no use
};

}  // namespace clsdf::polyhedra
