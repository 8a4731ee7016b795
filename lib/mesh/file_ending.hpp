#pragma once

#include <string>

namespace clsdf {

enum class MeshFormat { off, obj, stl, ply };

/// The format that the file's ending stands for, in upper or lower case. Throws Error(unsupported) that lists the
/// endings there are.
MeshFormat format_of_ending(const std::string& path);

}  // namespace clsdf
