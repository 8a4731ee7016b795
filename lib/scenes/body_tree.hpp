#pragma once

#include "scenes/frame.hpp"

#include <clsdf/mesh.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace clsdf::scenes {

/// A binary tree of bodies' boxes.
class BodyTree {
public:
    BodyTree() = default;
    /// bodies: the number of each box's body.
    BodyTree(std::span<const Box> boxes, std::span<const std::uint32_t> bodies);

    /// Around all of them; empty without bodies.
    Box box() const { return nodes_.empty() ? Box{} : nodes_[0].box; }

    /// Calls visit(body) for the bodies whose boxes hold the point.
    template <typename Visit>
    void visit_holding(const Vec3& p, const Visit& visit) const {
        if (nodes_.empty()) return;
        std::array<std::uint32_t, most_waiting> waiting;
        std::size_t count = 0;
        waiting[count++] = 0;
        while (count > 0) {
            const std::uint32_t number = waiting[--count];
            const Node& node = nodes_[number];
            if (!holds(node.box, p)) continue;
            if (node.count == 0) {
                waiting[count++] = node.first;
                waiting[count++] = number + 1;
            }
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
                if (holds(boxes_[i], p)) visit(bodies_[i]);
        }
    }

    /// Calls visit(body), which returns the new bound, for the bodies whose boxes may be within the bound of the point:
    /// the nearer child of a node first.
    template <typename Visit>
    void visit_near(const Vec3& p, double bound, const Visit& visit) const {
        if (nodes_.empty()) return;
        std::array<std::pair<double, std::uint32_t>, most_waiting> waiting;
        std::size_t count = 0;
        waiting[count++] = {least_distance(nodes_[0].box, p), 0};
        while (count > 0) {
            const auto [distance, number] = waiting[--count];
            if (distance > bound) continue;
            const Node& node = nodes_[number];
            if (node.count == 0) {
                std::pair near{least_distance(nodes_[number + 1].box, p), number + 1};
                std::pair far{least_distance(nodes_[node.first].box, p), node.first};
                if (far.first < near.first) std::swap(near, far);
                waiting[count++] = far;
                waiting[count++] = near;
            }
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
                if (least_distance(boxes_[i], p) <= bound) bound = visit(bodies_[i]);
        }
    }

private:
    static constexpr std::uint32_t most_in_leaf = 4;
    static constexpr std::size_t most_waiting = 72;  // halving 2^32 bodies, twice

    struct Node {
        Box box;
        std::uint32_t first;  ///< of the leaf's bodies, or the second child; the first child is the next node
        std::uint32_t count;  ///< of the leaf's bodies; 0: there are two children
    };

    static bool holds(const Box& box, const Vec3& p) {
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (p[axis] < box.lower[axis] || p[axis] > box.upper[axis]) return false;
        return true;
    }
    /// Rounded down by more than what the search of the body rounds, beside the widening of the box.
    static double least_distance(const Box& box, const Vec3& p) { return distance_to(box, p) * (1 - 1e-13); }

    void divide(std::span<std::uint32_t> order, std::uint32_t first, std::span<const Box> boxes);

    std::vector<Node> nodes_;  // the root first
    std::vector<Box> boxes_;
    std::vector<std::uint32_t> bodies_;
};

}  // namespace clsdf::scenes
