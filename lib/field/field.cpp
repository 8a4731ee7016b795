#include "core/atomic_file.hpp"
#include "field/formats.hpp"

#include <clsdf/error.hpp>
#include <clsdf/field.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <new>

namespace clsdf {
namespace {

namespace fs = std::filesystem;

struct Format {
    std::string ending;
    void (*write)(const Field& field, const std::string& path);
    Field (*read)(const std::string& path);
};

const Format& format_of(const std::string& path, ErrorCode code) {
    static const Format formats[] = {{".nrrd", write_nrrd, read_nrrd}, {".npy", write_npy, read_npy}};
    std::string ending = fs::path(path).extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(), [](char letter) {
        return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter + 32) : letter;
    });
    for (const Format& format : formats)
        if (format.ending == ending) return format;
    throw Error(code, fmt::format("{}: no field format ends in \"{}\"; choose .nrrd or .npy", path, ending));
}

void check_count(std::size_t values, std::size_t samples, const char* name) {
    if (values != samples)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("field: {} has {} values, but the grid {} samples", name, values, samples));
}

}  // namespace

Grid with_lattice(const Grid& stated, const Vec3& lattice_origin, const Index3& lattice_first) {
    const Grid part{lattice_origin, stated.spacing, stated.size, lattice_first};
    part.validate();
    return part.position(0, 0, 0) == stated.position(0, 0, 0) ? part : stated;
}

std::string triangle_path(const std::string& path) {
    const fs::path file(path);
    return (file.parent_path() / (file.stem().string() + "_triangle" + file.extension().string())).string();
}

std::string path_beside(const std::string& path, const std::string& name) {
    const fs::path file(name);
    if (name.empty() || file.filename() != file || name == "." || name == "..")
        throw Error(ErrorCode::unreadable_input,
                    fmt::format("{}: '{}' is not the name of a file in the same folder", path, name));
    return (fs::path(path).parent_path() / file).string();
}

void Field::check_output(const std::string& path) {
    format_of(path, ErrorCode::unsupported);
    std::error_code ignored;
    const fs::file_status status = fs::status(path, ignored);
    if (!fs::exists(status) || fs::is_regular_file(status) || fs::is_directory(status))
        AtomicFile(std::string(path));  // without commit() it leaves nothing
}

void Field::write(const std::string& path) const {
    const Format& format = format_of(path, ErrorCode::unsupported);
    grid.validate();
    band.validate();
    const std::size_t samples = grid.sample_count();
    check_count(distance.size(), samples, "distance");
    if (!triangle.empty()) check_count(triangle.size(), samples, "triangle");
    format.write(*this, path);
}

Field Field::read(const std::string& path) {
    const Format& format = format_of(path, ErrorCode::unreadable_input);
    try {
        return format.read(path);
    } catch (const Error& error) {
        // A grid, band or sign rule of the file that makes no sense is the file's fault, not the caller's.
        if (error.code() != ErrorCode::invalid_argument) throw;
        throw Error(ErrorCode::unreadable_input, fmt::format("{}: {}", path, error.what()));
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::out_of_memory, fmt::format("{}: the field does not fit the memory", path));
    }
}

}  // namespace clsdf
