#pragma once

#include "mesh/file_content.hpp"
#include "mesh/mesh_arrays.hpp"

namespace clsdf {

/// One reader per format. Each throws Error(unreadable_input) where the file is truncated or malformed, with the line
/// or the element and what was found there, and Error(invalid_mesh) where an index is out of range. Counts in a header
/// are held against the file's size before anything is allocated by them.
MeshArrays read_off(const FileContent& file);
MeshArrays read_obj(const FileContent& file);
MeshArrays read_ply(const FileContent& file);

/// Three vertices of its own for every triangle.
MeshArrays read_stl(const FileContent& file);

}  // namespace clsdf
