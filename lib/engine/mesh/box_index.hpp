#pragma once

#include <clsdf/mesh.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
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

/// Finds the boxes of a list that overlap another one, or each other, without a look at all of them.
class BoxIndex {
public:
    /// Lower limits may be infinite.
    explicit BoxIndex(std::span<const Box> boxes);

    /// Whether `holds` is true for the index of a box that overlaps `box`. Asks in no particular order.
    template <typename Predicate>
    bool any(const Box& box, const Predicate& holds) const {
        return any_leaf(box, 0, [&](const Node& leaf) {
            for (std::size_t i = leaf.begin; i < leaf.end; ++i)
                if (overlap(boxes_[i], box) && holds(order_[i])) return true;
            return false;
        });
    }
    bool any(const Box& box) const {
        return any(box, [](std::size_t) { return true; });
    }

    /// Boxes are in leaves, a few in each.
    std::size_t leaf_count() const { return leaves_.size(); }
    /// Calls f(a, b) for the indices of boxes that overlap, a < b: for all leaves each pair once, in no particular
    /// order.
    template <typename Function>
    void for_each_pair(std::size_t leaf, const Function& f) const {
        const Node& own = nodes_[leaves_[leaf]];
        any_leaf(own.box, own.begin, [&](const Node& other) {
            for (std::size_t i = own.begin; i < own.end; ++i)
                for (std::size_t k = std::max(i + 1, other.begin); k < other.end; ++k)
                    if (overlap(boxes_[i], boxes_[k]))
                        f(std::min(order_[i], order_[k]), std::max(order_[i], order_[k]));
            return false;
        });
    }

private:
    /// The children of node n are 2 n + 1 and 2 n + 2.
    struct Node {
        Box box = empty_box;             ///< around all boxes below
        std::size_t begin = 0, end = 0;  ///< of these boxes
    };
    static constexpr std::size_t most_in_leaf = 8;
    static bool is_leaf(const Node& node) { return node.end - node.begin <= most_in_leaf; }

    struct Key {
        double value;
        std::size_t index;
    };
    void divide(std::size_t number, std::span<const Box> boxes, std::span<Key> keys);

    /// Calls visit(node) for the leaves around `box` that have boxes from `first` on, until it returns true. Returns
    /// whether it did.
    template <typename Visit>
    bool any_leaf(const Box& box, std::size_t first, const Visit& visit) const {
        std::array<std::size_t, 64> open;  // NOLINT(*-member-init): more than the levels; set up to the count
        std::size_t count = 0;
        if (!nodes_.empty()) open[count++] = 0;
        while (count > 0) {
            const std::size_t number = open[--count];
            const Node& node = nodes_[number];
            if (node.end <= first || !overlap(node.box, box)) continue;
            if (!is_leaf(node)) {
                open[count++] = 2 * number + 1;
                open[count++] = 2 * number + 2;
            } else if (visit(node)) {
                return true;
            }
        }
        return false;
    }

    std::vector<Box> boxes_;  // in the order of leaves
    std::vector<std::size_t> order_;
    std::vector<Node> nodes_;          // by levels
    std::vector<std::size_t> leaves_;  // nodes, by their boxes
};

}  // namespace clsdf
