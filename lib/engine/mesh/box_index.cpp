#include "mesh/box_index.hpp"

#include <cmath>
#include <numeric>

namespace clsdf {

Box widened(Box box, double margin) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] -= margin + 1e-12 * std::abs(box.lower[axis]);
        box.upper[axis] += margin + 1e-12 * std::abs(box.upper[axis]);
    }
    return box;
}

BoxIndex::BoxIndex(std::span<const Box> boxes) : boxes_(boxes.begin(), boxes.end()), order_(boxes.size()) {
    if (boxes.empty()) return;
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    nodes_.emplace_back();
    divide(0, 0, boxes.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) boxes_[i] = boxes[order_[i]];
}

// At the median of the upper limits along the axis on which these lie farthest apart.
void BoxIndex::divide(std::uint32_t number, std::size_t begin, std::size_t end) {
    Box all = boxes_[order_[begin]];
    Vec3 least = all.upper;
    for (std::size_t i = begin; i < end; ++i) {
        const Box& box = boxes_[order_[i]];
        add(all, box);
        for (std::size_t axis = 0; axis < 3; ++axis) least[axis] = std::min(least[axis], box.upper[axis]);
    }
    constexpr std::size_t leaf = 8;
    if (end - begin <= leaf) {
        nodes_[number] = {all, begin, end, 0};
        return;
    }
    std::size_t axis = 0;
    for (std::size_t other = 1; other < 3; ++other)
        if (all.upper[other] - least[other] > all.upper[axis] - least[axis]) axis = other;
    const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    const std::size_t middle = begin + (end - begin) / 2;
    std::nth_element(at(begin), at(middle), at(end),
                     [&](std::size_t a, std::size_t b) { return boxes_[a].upper[axis] < boxes_[b].upper[axis]; });
    const auto child = static_cast<std::uint32_t>(nodes_.size());
    nodes_[number] = {all, 0, 0, child};
    nodes_.resize(nodes_.size() + 2);
    divide(child, begin, middle);
    divide(child + 1, middle, end);
}

}  // namespace clsdf
