#pragma once

#include "field/outputs.hpp"
#include "io/raw_values.hpp"

#include <clsdf/error.hpp>
#include <clsdf/io.hpp>

#include <memory>
#include <string>

namespace clsdf {

/// A field on its way into files. Everything is written under temporary names, and the files get their own names in
/// finish(), the distances' last; without it the destructor removes them.
class FormatWriter {
public:
    FormatWriter() = default;
    FormatWriter(const FormatWriter&) = delete;
    FormatWriter& operator=(const FormatWriter&) = delete;
    virtual ~FormatWriter() = default;

    /// Whole slices of every output, the first of them being slice `first_slice` of the field.
    virtual void append(const FieldSlab& slab, std::int64_t first_slice) = 0;
    virtual void finish() = 0;
};

struct Format {
    const char* ending = nullptr;  ///< with its dot, in lower case
    /// Throws Error(unsupported) for what the format has no place for. The grid and the band are valid.
    std::unique_ptr<FormatWriter> (*writer)(const std::string& path, const FieldDescription& field,
                                            const Outputs& outputs) = nullptr;
    /// Throws Error(unreadable_input), or Error(invalid_argument) where a value makes no sense.
    Field (*read)(const std::string& path) = nullptr;
    /// Whether it has a place for other outputs than the distance.
    bool has_extras = true;
    /// Throws Error(unsupported) where this build lacks the format.
    void (*check_build)(const std::string& path) = nullptr;
};

/// By the file's ending, in any case of letters. Throws Error(code) that names the endings there are.
const Format& format_of(const std::string& path, ErrorCode code);

/// Throws Error(unsupported) where this build lacks the format, or the format a place for one of the outputs.
void check_place_for(const Outputs& outputs, const std::string& path, const Format& format);

std::unique_ptr<FormatWriter> nrrd_writer(const std::string& path, const FieldDescription& field,
                                          const Outputs& outputs);
Field read_nrrd(const std::string& path);

std::unique_ptr<FormatWriter> npy_writer(const std::string& path, const FieldDescription& field,
                                         const Outputs& outputs);
Field read_npy(const std::string& path);

std::unique_ptr<FormatWriter> vti_writer(const std::string& path, const FieldDescription& field,
                                         const Outputs& outputs);
Field read_vti(const std::string& path);

std::unique_ptr<FormatWriter> h5_writer(const std::string& path, const FieldDescription& field, const Outputs& outputs);
Field read_h5(const std::string& path);

/// Of vdb_write.cpp and vdb_read.cpp, or of vdb_absent.cpp in a build without OpenVDB.
std::unique_ptr<FormatWriter> vdb_writer(const std::string& path, const FieldDescription& field,
                                         const Outputs& outputs);
Field read_vdb(const std::string& path);
void check_vdb(const std::string& path);

std::unique_ptr<FormatWriter> sdf_writer(const std::string& path, const FieldDescription& field,
                                         const Outputs& outputs);
Field read_sdf(const std::string& path);

/// The grid that a file states by its first sample, as the part of the lattice that the file says it is. Programs that
/// crop a field may keep what they do not understand but move the first sample, so the lattice counts only where it has
/// that very sample.
Grid with_lattice(const Grid& stated, const Vec3& lattice_origin, const Index3& lattice_first);

/// The file of another output beside a field: "bunny.nrrd" has "bunny_triangle.nrrd".
std::string extra_path(const std::string& path, const OutputKind& kind);

/// The last part of a path.
std::string file_name(const std::string& path);

/// A file that another one in the same folder names. Throws Error(unreadable_input) where `name` is not a plain name.
std::string path_beside(const std::string& path, const std::string& name);

}  // namespace clsdf
