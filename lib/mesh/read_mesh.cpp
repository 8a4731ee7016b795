#include <clsdf/error.hpp>
#include <clsdf/mesh.hpp>

#include "mesh/file_ending.hpp"
#include "mesh/mesh_readers.hpp"

#include <fmt/format.h>

#include <new>
#include <utility>

namespace clsdf {

namespace {

MeshArrays read_arrays(const FileContent& file, MeshFormat format) {
    switch (format) {
        case MeshFormat::off:
            return read_off(file);
        case MeshFormat::obj:
            return read_obj(file);
        case MeshFormat::stl:
            return read_stl(file);
        case MeshFormat::ply:
            break;
    }
    return read_ply(file);
}

}  // namespace

Mesh read_mesh(const std::string& path) try {
    const MeshFormat format = format_of_ending(path);
    MeshArrays arrays = read_arrays(FileContent(path), format);
    Mesh mesh(std::move(arrays.vertices), std::move(arrays.triangles), path);
    return format == MeshFormat::stl ? weld(mesh) : mesh;
} catch (const std::bad_alloc&) {
    throw Error(ErrorCode::out_of_memory, fmt::format("there is not enough memory to read '{}'", path));
}

}  // namespace clsdf
