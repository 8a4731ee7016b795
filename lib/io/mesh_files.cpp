#include "io/mesh_files.hpp"

#include "core/descriptor.hpp"
#include "core/parallel_read.hpp"
#include "io/text_scanner.hpp"

#include <clsdf/error.hpp>
#include <clsdf/io.hpp>

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <cerrno>
#include <filesystem>
#include <new>
#include <span>
#include <system_error>
#include <utility>

namespace clsdf {

namespace {

[[noreturn]] void fail(const std::string& path, const std::string& reason) {
    throw Error(ErrorCode::unreadable_input, fmt::format("cannot read '{}': {}", path, reason));
}

[[noreturn]] void fail(const std::string& path, int error) {
    fail(path, std::generic_category().message(error));
}

}  // namespace

FileContent::FileContent(std::string path) : path_(std::move(path)) {
    // Not blocking: opening a pipe would wait for its writer.
    const Descriptor file(::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (file.number() < 0) fail(path_, errno);
    struct stat status {};
    if (::fstat(file.number(), &status) != 0) fail(path_, errno);
    if (S_ISDIR(status.st_mode)) fail(path_, EISDIR);
    if (!S_ISREG(status.st_mode)) fail(path_, "it is a device or a pipe, not a file");

    // The file is read, not mapped: a mapped file that another process truncates ends the program with a signal. All
    // cores read, into memory on huge pages, because fresh memory and copying take most of the time.
    bytes_.resize(static_cast<std::size_t>(status.st_size));
    const ReadResult result =
        read_in_parallel(file, 0, std::as_writable_bytes(std::span(bytes_.data(), bytes_.size())));
    if (result.error != 0) fail(path_, result.error);
    if (result.bytes != bytes_.size())
        fail(path_, fmt::format("it became shorter, {} instead of {} bytes", result.bytes, bytes_.size()));
}

MeshFormat format_of_ending(const std::string& path) {
    const std::string ending = std::filesystem::path(path).extension().string();
    if (equals_ignoring_case(ending, ".off")) return MeshFormat::off;
    if (equals_ignoring_case(ending, ".obj")) return MeshFormat::obj;
    if (equals_ignoring_case(ending, ".stl")) return MeshFormat::stl;
    if (equals_ignoring_case(ending, ".ply")) return MeshFormat::ply;
    throw Error(ErrorCode::unsupported,
                fmt::format("'{}' does not end like a mesh file; the endings are .off, .obj, .stl and .ply", path));
}

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
