#include "field/formats.hpp"
#include "field/nrrd_header.hpp"

#include <clsdf/version.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <deque>

namespace clsdf {
namespace {

const char* name_of(ValueType type) {
    return type == ValueType::uint32 ? "unsigned int" : "float";
}

// What every reader of NRRD needs; fmt writes the shortest text that reads back as the same double. The components of a
// sample are an axis of their own, the fastest.
std::string basic_header(const Grid& grid, const OutputKind& kind) {
    const Vec3 origin = grid.position(0, 0, 0);
    const bool is_vector = kind.components > 1;
    return fmt::format(
        "NRRD0005\n"
        "# Complete NRRD file format specification at:\n"
        "# http://teem.sourceforge.net/nrrd/format.html\n"
        "content: {}\n"
        "type: {}\n"
        "dimension: {}\n"
        "space dimension: 3\n"
        "sizes: {}{} {} {}\n"
        "space directions: {}({},0,0) (0,{},0) (0,0,{})\n"
        "kinds: {}domain domain domain\n"
        "endian: little\n"
        "encoding: raw\n"
        "space origin: ({},{},{})\n",
        kind.content, name_of(kind.type), is_vector ? 4 : 3, is_vector ? fmt::format("{} ", kind.components) : "",
        grid.size[0], grid.size[1], grid.size[2], is_vector ? "none " : "", grid.spacing[0], grid.spacing[1],
        grid.spacing[2], is_vector ? "vector " : "", origin[0], origin[1], origin[2]);
}

std::string pairs(const FieldDescription& field) {
    return fmt::format(
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

class NrrdWriter : public FormatWriter {
public:
    NrrdWriter(const std::string& path, const FieldDescription& field, const Outputs& outputs)
        : kinds_(kinds_of(outputs)) {
        std::string header = basic_header(field.grid, kinds_.front()) + pairs(field);
        files_.emplace_back(path);
        for (std::size_t i = 1; i < kinds_.size(); ++i) {
            const std::string beside = extra_path(path, kinds_[i]);
            header += fmt::format("clsdf_{}_file:={}\n", kinds_[i].name, escaped(file_name(beside)));
            files_.emplace_back(beside);
            files_.back().write(basic_header(field.grid, kinds_[i]) + '\n');
        }
        files_.front().write(header + '\n');
    }

    void append(const FieldSlab& slab, std::int64_t) override {
        for (std::size_t i = 0; i < kinds_.size(); ++i)
            write_little_endian(files_[i], kinds_[i].bytes(slab), width_of(kinds_[i].type));
    }

    void finish() override {
        for (std::size_t i = files_.size(); i-- > 0;) files_[i].commit();
    }

private:
    std::vector<OutputKind> kinds_;
    std::deque<AtomicFile> files_;  // the distances' first
};

}  // namespace

std::unique_ptr<FormatWriter> nrrd_writer(const std::string& path, const FieldDescription& field,
                                          const Outputs& outputs) {
    return std::make_unique<NrrdWriter>(path, field, outputs);
}

}  // namespace clsdf
