#include "scenes/body_tree.hpp"

#include <algorithm>
#include <numeric>

namespace clsdf::scenes {

BodyTree::BodyTree(std::span<const Box> boxes, std::span<const std::uint32_t> bodies) {
    if (boxes.empty()) return;
    std::vector<std::uint32_t> order(boxes.size());
    std::iota(order.begin(), order.end(), 0U);
    divide(order, 0, boxes);
    for (const std::uint32_t i : order) {
        boxes_.push_back(boxes[i]);
        bodies_.push_back(bodies[i]);
    }
}

void BodyTree::divide(std::span<std::uint32_t> order, std::uint32_t first, std::span<const Box> boxes) {
    Box box = boxes[order[0]];
    for (const std::uint32_t i : order)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            box.lower[axis] = std::min(box.lower[axis], boxes[i].lower[axis]);
            box.upper[axis] = std::max(box.upper[axis], boxes[i].upper[axis]);
        }
    const auto count = static_cast<std::uint32_t>(order.size());
    const std::size_t number = nodes_.size();
    nodes_.push_back({box, first, count <= most_in_leaf ? count : 0});
    if (count <= most_in_leaf) return;
    std::size_t longest = 0;
    for (std::size_t axis = 1; axis < 3; ++axis)
        if (box.upper[axis] - box.lower[axis] > box.upper[longest] - box.lower[longest]) longest = axis;
    // The body's number decides between equal middles, so that the tree depends on the bodies alone.
    const auto middle_of = [&](std::uint32_t i) {
        return std::pair(boxes[i].lower[longest] / 2 + boxes[i].upper[longest] / 2, i);
    };
    const std::uint32_t half = count / 2;
    std::ranges::nth_element(order, order.begin() + half, {}, middle_of);
    divide(order.first(half), first, boxes);
    nodes_[number].first = static_cast<std::uint32_t>(nodes_.size());
    divide(order.subspan(half), first + half, boxes);
}

}  // namespace clsdf::scenes
