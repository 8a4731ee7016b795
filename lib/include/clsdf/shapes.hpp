#pragma once

#include <clsdf/mesh.hpp>

namespace clsdf {

/// The names make_shape() knows, each with one line on what it is.
struct ShapeName {
    std::string name;
    std::string description;
};
std::vector<ShapeName> shape_names();

/// Meshes made by code, by the names that shape_names() lists: sphere0 to sphere9 (sphere6 is the paper's, 16,386
/// vertices), torus, knot, stairs and others. Throws Error(invalid_argument) that names the nearest one.
Mesh make_shape(const std::string& name);

}  // namespace clsdf
