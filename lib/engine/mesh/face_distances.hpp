#pragma once

#include <clsdf/mesh.hpp>

#include "mesh/box_index.hpp"

#include <span>
#include <vector>

namespace clsdf {

/// Distances from points to some faces over a mesh's vertices, up to rounding.
class FaceDistances {
public:
    FaceDistances(const Mesh& mesh, std::span<const Triangle> faces);

    /// The distance to the nearest face, in units of `most`; 1 if none is nearer than `most`.
    double at(const Vec3& point, double most) const;

private:
    const Mesh& mesh_;
    std::vector<Triangle> faces_;
    BoxIndex boxes_;
};

}  // namespace clsdf
