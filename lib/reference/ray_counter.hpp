#pragma once

#include "triangle_tree.hpp"

#include <span>

namespace clsdf::reference {

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
