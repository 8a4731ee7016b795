#pragma once

#include <clsdf/mesh.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace clsdf {

inline constexpr double infinite_length = std::numeric_limits<double>::infinity();
/// Around nothing, so that add() makes it the box of what is added.
inline constexpr Box empty_box{{infinite_length, infinite_length, infinite_length},
                               {-infinite_length, -infinite_length, -infinite_length}};

/// Widens a box to hold another one; limits of the other one that are not a number do not count.
inline void add(Box& box, const Box& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] = std::min(box.lower[axis], other.lower[axis]);
        box.upper[axis] = std::max(box.upper[axis], other.upper[axis]);
    }
}

/// Whether the boxes have a point in common; their limits belong to them.
inline bool overlap(const Box& a, const Box& b) {
    bool result = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
        result &= a.lower[axis] <= b.upper[axis] && b.lower[axis] <= a.upper[axis];
    return result;
}

/// The box widened by `margin`, in the mesh's units, and by the rounding of its coordinates.
Box widened(Box box, double margin);

/// Finds the boxes of a list that overlap another one, without a look at all of them.
class BoxIndex {
public:
    /// Lower limits may be infinite.
    explicit BoxIndex(std::span<const Box> boxes);

    /// Whether `holds` is true for the index of a box that overlaps `box`. Asks in no particular order.
    template <typename Predicate>
    bool any(const Box& box, const Predicate& holds) const {
        std::vector<std::uint32_t> open;
        if (!nodes_.empty()) open.push_back(0);
        while (!open.empty()) {
            const Node& node = nodes_[open.back()];
            open.pop_back();
            if (!overlap(node.box, box)) continue;
            for (std::size_t i = node.begin; i < node.end; ++i)
                if (overlap(boxes_[i], box) && holds(order_[i])) return true;
            if (node.begin == node.end) {
                open.push_back(node.child);
                open.push_back(node.child + 1);
            }
        }
        return false;
    }
    bool any(const Box& box) const {
        return any(box, [](std::size_t) { return true; });
    }

private:
    struct Node {
        Box box;                         ///< around all boxes below
        std::size_t begin = 0, end = 0;  ///< a leaf's range of order_; equal if the node has children
        std::uint32_t child = 0;         ///< the first of two
    };
    void divide(std::uint32_t number, std::size_t begin, std::size_t end);

    std::vector<Box> boxes_;  // in the order of leaves
    std::vector<std::size_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace clsdf
