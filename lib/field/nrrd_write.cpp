#include "field/formats.hpp"
#include "field/nrrd_header.hpp"

#include <clsdf/version.hpp>

#include <fmt/format.h>

#include <filesystem>
#include <iterator>

namespace clsdf {
namespace {

// What every reader of NRRD needs; fmt writes the shortest text that reads back as the same double.
std::string basic_header(const Grid& grid, const std::string& content, const char* type) {
    const Vec3 origin = grid.position(0, 0, 0);
    std::string text;
    fmt::format_to(std::back_inserter(text),
                   "NRRD0005\n"
                   "# Complete NRRD file format specification at:\n"
                   "# http://teem.sourceforge.net/nrrd/format.html\n"
                   "content: {}\n"
                   "type: {}\n"
                   "dimension: 3\n"
                   "space dimension: 3\n"
                   "sizes: {} {} {}\n"
                   "space directions: ({},0,0) (0,{},0) (0,0,{})\n"
                   "kinds: domain domain domain\n"
                   "endian: little\n"
                   "encoding: raw\n"
                   "space origin: ({},{},{})\n",
                   content, type, grid.size[0], grid.size[1], grid.size[2], grid.spacing[0], grid.spacing[1],
                   grid.spacing[2], origin[0], origin[1], origin[2]);
    return text;
}

void append_pairs(std::string& text, const Field& field) {
    fmt::format_to(std::back_inserter(text),
                   "clsdf_version:={}\n"
                   "clsdf_mesh:={}\n"
                   "clsdf_sign:={}\n"
                   "clsdf_band_inside:={}\n"
                   "clsdf_band_outside:={}\n"
                   "clsdf_lattice_origin:={}\n"
                   "clsdf_lattice_first:={}\n",
                   version(), escaped(field.mesh_name), name_of(field.sign), field.band.inside, field.band.outside,
                   fmt::join(field.grid.origin, " "), fmt::join(field.grid.first, " "));
}

}  // namespace

void write_nrrd(const Field& field, const std::string& path) {
    std::string header = basic_header(field.grid, "distance", "float");
    append_pairs(header, field);

    std::optional<AtomicFile> triangles;
    if (!field.triangle.empty()) {
        const std::string beside = triangle_path(path);
        fmt::format_to(std::back_inserter(header), "clsdf_triangle_file:={}\n",
                       escaped(std::filesystem::path(beside).filename().string()));
        triangles.emplace(beside);
        triangles->write(basic_header(field.grid, "nearest triangle", "unsigned int") + '\n');
        write_little_endian(*triangles, field.triangle);
    }

    AtomicFile distances(path);
    distances.write(header + '\n');
    write_little_endian(distances, field.distance);
    if (triangles) triangles->commit();
    distances.commit();
}

}  // namespace clsdf
