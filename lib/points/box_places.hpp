#pragma once

#include "tree/wide_tree.hpp"

#include <clsdf/calls.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include <span>

namespace clsdf::points {

/// Throws Error(invalid_argument) if the box is not finite or has its corners exchanged. name: for the message.
void check_box(const Box& box, const std::string& name);
/// Throws Error(invalid_argument) that names the first box that is not finite or has its corners exchanged.
void check_boxes(std::span<const Box> boxes);

/// The place of each box: see DistanceTransform::classify().
void find_places(const engine::SearchedMesh& searched, SignRule rule, std::span<const Box> boxes, double half_width,
                 std::span<BoxPlace> places);

}  // namespace clsdf::points
