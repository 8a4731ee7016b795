#pragma once

#include <clsdf/field.hpp>

#include <string>

namespace clsdf {

/// What an .npy file cannot say about its field: a JSON object beside it, "bunny.npy.json". Its members:
///   "origin", "spacing", "size"   of the samples: three numbers along x, y, z; the origin is the first sample
///   "lattice": {"origin", "first"}  where the samples are a part of a grid, as of Grid
///   "band": {"inside", "outside"}   in the mesh's units; null where infinite
///   "sign", "mesh", "program", "triangle" (the file of the nearest triangles, where there is one)
/// Only origin, spacing and size are needed to read a field.
std::string sidecar_path(const std::string& path);

/// `triangle_file` is empty where there is none.
std::string sidecar_text(const Field& field, const std::string& triangle_file);

struct Sidecar {
    Field field;  ///< without its arrays
    std::string triangle_file;
};

/// Throws Error(unreadable_input), or Error(invalid_argument) where a value makes no sense.
Sidecar read_sidecar(const std::string& path);

}  // namespace clsdf
