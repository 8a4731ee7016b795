#pragma once

#include <clsdf/field.hpp>

#include <string>

namespace clsdf {

// Each writer writes everything under temporary names before the first file gets its own; each reader throws
// Error(unreadable_input).
void write_nrrd(const Field& field, const std::string& path);
Field read_nrrd(const std::string& path);

void write_npy(const Field& field, const std::string& path);
Field read_npy(const std::string& path);

/// The grid that a file states by its first sample, as the part of the lattice that the file says it is. Programs that
/// crop a field may keep what they do not understand but move the first sample, so the lattice counts only where it has
/// that very sample.
Grid with_lattice(const Grid& stated, const Vec3& lattice_origin, const Index3& lattice_first);

/// The file of the nearest triangles beside a field: "bunny.nrrd" has "bunny_triangle.nrrd".
std::string triangle_path(const std::string& path);

/// A file that another one in the same folder names. Throws Error(unreadable_input) where `name` is not a plain name.
std::string path_beside(const std::string& path, const std::string& name);

}  // namespace clsdf
