#include "mesh/box_index.hpp"

#include "core/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace clsdf {

Box widened(Box box, double margin) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] -= margin + 1e-12 * std::abs(box.lower[axis]);
        box.upper[axis] += margin + 1e-12 * std::abs(box.upper[axis]);
    }
    return box;
}

BoxIndex::BoxIndex(std::span<const Box> boxes) : boxes_(boxes.size()), order_(boxes.size()) {
    if (boxes.empty()) return;
    std::vector<Key> keys(boxes.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) keys[i].index = i;
    // Halves of a node differ by one box at most.
    std::size_t levels = 1;
    while (chunk_count(boxes.size(), std::size_t{1} << (levels - 1)) > most_in_leaf) ++levels;
    nodes_.resize((std::size_t{1} << levels) - 1);
    nodes_[0].end = boxes.size();
    for (std::size_t level = 0; level < levels; ++level) {
        const std::size_t first = (std::size_t{1} << level) - 1, boxes_each = boxes.size() >> level;
        for_each_index(
            first + 1, [&](std::size_t i) { divide(first + i, boxes, keys); }, 1 + usual_grain / 4 / (1 + boxes_each));
    }
    for_each_index(boxes.size(), [&](std::size_t i) {
        order_[i] = keys[i].index;
        boxes_[i] = boxes[order_[i]];
    });
    for (std::size_t number = 0; number < nodes_.size(); ++number)
        if (nodes_[number].begin != nodes_[number].end && is_leaf(nodes_[number])) leaves_.push_back(number);
    std::ranges::sort(leaves_, {}, [&](std::size_t number) { return nodes_[number].begin; });
}

// At the median of the upper limits along the axis on which these lie farthest apart.
void BoxIndex::divide(std::size_t number, std::span<const Box> boxes, std::span<Key> keys) {
    Node& node = nodes_[number];
    if (node.begin == node.end) return;  // below a leaf
    const std::span<Key> own = keys.subspan(node.begin, node.end - node.begin);
    Vec3 least = boxes[own.front().index].upper;
    for (const Key& key : own) {
        const Box& box = boxes[key.index];
        add(node.box, box);
        for (std::size_t axis = 0; axis < 3; ++axis) least[axis] = std::min(least[axis], box.upper[axis]);
    }
    if (is_leaf(node)) return;
    std::size_t axis = 0;
    for (std::size_t other = 1; other < 3; ++other)
        if (node.box.upper[other] - least[other] > node.box.upper[axis] - least[axis]) axis = other;
    for (Key& key : own) key.value = boxes[key.index].upper[axis];
    const std::size_t half = own.size() / 2;
    std::ranges::nth_element(own, own.begin() + static_cast<std::ptrdiff_t>(half), {}, &Key::value);
    Node &low = nodes_[2 * number + 1], &high = nodes_[2 * number + 2];
    low.begin = node.begin;
    low.end = high.begin = node.begin + half;
    high.end = node.end;
}

}  // namespace clsdf
