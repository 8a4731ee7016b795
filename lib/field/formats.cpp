#include "field/formats.hpp"

#include "core/quoted.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

namespace clsdf {
namespace {

namespace fs = std::filesystem;

constexpr std::array formats{
    Format{".nrrd", nrrd_writer, read_nrrd},
    Format{".npy", npy_writer, read_npy},
    Format{".vti", vti_writer, read_vti},
    Format{".h5", h5_writer, read_h5},
    Format{".vdb", vdb_writer, read_vdb, true, check_vdb},
    Format{".sdf", sdf_writer, read_sdf, false},
};

std::string endings() {
    std::string text;
    for (std::size_t i = 0; i < formats.size(); ++i)
        text.append(i == 0 ? "" : i + 1 < formats.size() ? ", " : " or ").append(formats[i].ending);
    return text;
}

}  // namespace

const Format& format_of(const std::string& path, ErrorCode code) {
    std::string ending = fs::path(path).extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(), [](char letter) {
        return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter + 32) : letter;
    });
    for (const Format& format : formats)
        if (format.ending == ending) return format;
    throw Error(code, fmt::format("{}: no field format ends in \"{}\"; choose {}", path, ending, endings()));
}

void check_place_for(const Outputs& outputs, const std::string& path, const Format& format) {
    if (format.check_build != nullptr) format.check_build(path);
    if (format.has_extras) return;
    for (const OutputKind& kind : extra_kinds())
        if (kind.wanted(outputs))
            throw Error(ErrorCode::unsupported,
                        fmt::format("{}: {} has no place for the output {}; choose another format, or do without", path,
                                    format.ending, kind.name));
}

Grid with_lattice(const Grid& stated, const Vec3& lattice_origin, const Index3& lattice_first) {
    const Grid part{lattice_origin, stated.spacing, stated.size, lattice_first};
    part.validate();
    return part.position(0, 0, 0) == stated.position(0, 0, 0) ? part : stated;
}

std::string extra_path(const std::string& path, const OutputKind& kind) {
    const fs::path file(path);
    return (file.parent_path() / (file.stem().string() + "_" + kind.name + file.extension().string())).string();
}

std::string file_name(const std::string& path) {
    return fs::path(path).filename().string();
}

std::string path_beside(const std::string& path, const std::string& name) {
    const fs::path file(name);
    if (name.empty() || file.filename() != file || name == "." || name == "..")
        throw Error(ErrorCode::unreadable_input,
                    fmt::format("{}: {} is not the name of a file in the same folder", path, quoted(name, 80)));
    return (fs::path(path).parent_path() / file).string();
}

}  // namespace clsdf
