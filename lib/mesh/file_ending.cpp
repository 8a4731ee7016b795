#include "mesh/file_ending.hpp"

#include "mesh/text_scanner.hpp"

#include <fmt/format.h>

#include <filesystem>

namespace clsdf {

MeshFormat format_of_ending(const std::string& path) {
    const std::string ending = std::filesystem::path(path).extension().string();
    if (equals_ignoring_case(ending, ".off")) return MeshFormat::off;
    if (equals_ignoring_case(ending, ".obj")) return MeshFormat::obj;
    if (equals_ignoring_case(ending, ".stl")) return MeshFormat::stl;
    if (equals_ignoring_case(ending, ".ply")) return MeshFormat::ply;
    throw Error(ErrorCode::unsupported,
                fmt::format("'{}' does not end like a mesh file; the endings are .off, .obj, .stl and .ply", path));
}

}  // namespace clsdf
