#pragma once

#include "exact_geometry.hpp"
#include "triangle_frame.hpp"

#include <clsdf/reference.hpp>

#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace clsdf::reference {

/// CGAL's AABB tree over a mesh's triangles. The tree only selects triangles; its box tests are widened by their
/// rounding, and TriangleFrame computes the distance. So the result is that of looking at every triangle. Constant
/// functions may be called from several threads at once.
class TriangleTree {
public:
    /// The mesh must outlive the tree.
    explicit TriangleTree(const Mesh& mesh);
    ~TriangleTree();

    /// The nearest triangle if its distance is at most `bound`, the lowest index among equals.
    std::optional<Nearest> nearest(const ExactPosition& query,
                                   double bound = std::numeric_limits<double>::infinity()) const;

    /// The closest point of one triangle, and the distance to it.
    TriangleFrame::Closest closest_on(std::uint32_t triangle, const ExactPosition& query) const;
    double distance_to(std::uint32_t triangle, const ExactPosition& query) const;

    /// The triangles whose box meets the line parallel to x through (y, z), from x on; in no particular order.
    void meet_ray(double x, double y, double z, std::vector<std::uint32_t>& triangles) const;

    const Mesh& mesh() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace clsdf::reference
