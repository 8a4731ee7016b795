#pragma once

#include <clsdf/mesh.hpp>

namespace clsdf {

/// The names make_shape() knows, each with one line on what it is.
struct ShapeName {
    std::string name;
    std::string description;
};
std::vector<ShapeName> shape_names();

/// Meshes made by code: sphere0 ... sphere9 (subdivided octahedra; sphere6 is the paper's, 16,386 vertices), torus,
/// knot, seashell, stairs, plate, needle, tetrahedron, noisy, nested. Throws Error(invalid_argument) that names the
/// nearest one.
Mesh make_shape(const std::string& name);

}  // namespace clsdf
