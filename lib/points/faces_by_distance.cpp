#include "points/faces_by_distance.hpp"

#include "points/one_lane.hpp"

#include <algorithm>
#include <tuple>

namespace clsdf::points {

namespace {

/// Above the rounding of heights over a face, in units.
constexpr double rounding_of_height = 1e-9;

/// A lower bound of the squared distance between a point and a child of a node, whatever is rounded.
double least_squared(const PointNode& node, std::uint32_t child, const Vec3& p) {
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double apart =
            std::max({double{node.lower[axis][child]} - p[axis], p[axis] - double{node.upper[axis][child]}, 0.0});
        squared += apart * apart;
    }
    return squared * (1 - 1e-12);
}

}  // namespace

FacesByDistance::FacesByDistance(const PointInputs& inputs, const Vec3& in_units, double most, double rounding)
    : inputs_(inputs), point_(in_units), most_(most), most_in_front_(rounding_of_height + rounding) {
    const PointTree& shape = inputs.leaves->tree->shape;
    if (shape.levels > 0) add({0, false, shape.levels - 1, 0, 0});
}

FacesByDistance::Face FacesByDistance::next() {
    const auto is_later = [](const Entry& a, const Entry& b) {
        return std::tuple(a.squared, a.is_face, a.triangle) > std::tuple(b.squared, b.is_face, b.triangle);
    };
    while (!heap_.empty()) {
        std::ranges::pop_heap(heap_, is_later);
        const Entry entry = heap_.back();
        heap_.pop_back();
        if (entry.is_face) return {entry.number, entry.squared};
        const std::size_t before = heap_.size();
        if (entry.level == 0)
            add_faces(entry.number);
        else
            open(entry.level, entry.number);
        for (std::size_t end = before + 1; end <= heap_.size(); ++end)
            std::push_heap(heap_.begin(), heap_.begin() + static_cast<std::ptrdiff_t>(end), is_later);
    }
    return {CLSDF_NO_FACE, 0};
}

void FacesByDistance::open(std::uint32_t level, std::uint32_t number) {
    const engine::WideTree& tree = *inputs_.leaves->tree;
    const PointNode& node = tree.nodes[tree.shape.first[level] + number];
    const std::uint32_t first = number * CLSDF_TREE_WIDTH,
                        count = std::min<std::uint32_t>(CLSDF_TREE_WIDTH, tree.shape.count[level - 1] - first);
    for (std::uint32_t child = 0; child < count; ++child)
        add({least_squared(node, child, point_), false, level - 1, first + child, 0});
}

void FacesByDistance::add_faces(std::uint32_t leaf) {
    const engine::WideTree& tree = *inputs_.leaves->tree;
    const PointNode& node = tree.nodes[leaf];
    const auto* const records = static_cast<const Polyhedron*>(inputs_.mesh->polyhedra->on_host());
    const auto* const faces = static_cast<const PointFace*>(inputs_.mesh->faces->on_host());
    const std::uint32_t first = leaf * CLSDF_TREE_WIDTH,
                        count = std::min<std::uint32_t>(CLSDF_TREE_WIDTH, tree.shape.faces - first);
    const auto& [x, y, z] = point_;
    for (std::uint32_t face = first; face < first + count; ++face) {
        if (least_squared(node, face - first, point_) > most_) continue;
        const Polyhedron& record = records[face];
        const double height = record.exact_gradient_x[2] * x + record.exact_gradient_y[2] * y +
                              record.exact_gradient_z[2] * z + faces[face].offset[2];
        if (height > most_in_front_) continue;
        add({one_lane::face_distance(records + face, faces + face, x, y, z).squared, true, 0, face,
             faces[face].triangle});
    }
}

void FacesByDistance::add(const Entry& entry) {
    if (entry.squared <= most_) heap_.push_back(entry);
}

}  // namespace clsdf::points
