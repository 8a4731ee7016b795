#pragma once

#include "triangle.hpp"

#include <clsdf/reference.hpp>

#include <limits>
#include <memory>
#include <optional>
#include <span>
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

/// Counts what rays along +x cross, exactly. Constant functions may be called from several threads at once.
class RayCounter {
public:
    /// The tree must outlive the counter.
    explicit RayCounter(const TriangleTree& tree) : tree_(tree) {}

    /// For each point (x[i], y, z), x ascending: the crossings of the ray from there along +x; nullopt on the surface.
    std::vector<std::optional<RayCount>> count_along_row(std::span<const double> x, double y, double z) const;

private:
    const TriangleTree& tree_;
};

}  // namespace clsdf::reference
