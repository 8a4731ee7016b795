#pragma once

#include "core/outputs.hpp"
#include "io/meshes/raw_values.hpp"

#include <clsdf/error.hpp>
#include <clsdf/field.hpp>
#include <clsdf/io.hpp>
#include <clsdf/sparse.hpp>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace clsdf {

/// Writes a field into files under temporary names. finish() gives them their final names, that of the distances last.
/// Without finish() the destructor removes them.
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

/// The same for a sparse field. finish() comes after the last layers.
class SparseFormatWriter {
public:
    SparseFormatWriter() = default;
    SparseFormatWriter(const SparseFormatWriter&) = delete;
    SparseFormatWriter& operator=(const SparseFormatWriter&) = delete;
    virtual ~SparseFormatWriter() = default;

    /// The next layers of bricks, in the order of z.
    virtual void append(const SparseSlab& slab) = 0;
    virtual void finish() = 0;
};

struct Format {
    const char* ending = nullptr;  ///< with its dot, in lower case
    /// Throws Error(unsupported) for a field that the format cannot store. The grid and the band are valid.
    std::unique_ptr<FormatWriter> (*writer)(const std::string& path, const FieldDescription& field,
                                            OutputSet outputs) = nullptr;
    /// The distance, and of the other outputs in the file those in `wanted`. Throws Error(unreadable_input), or
    /// Error(invalid_argument) if a value makes no sense.
    Field (*read)(const std::string& path, OutputSet wanted) = nullptr;
    /// Whether the format stores other outputs than the distance.
    bool has_extras = true;
    /// Throws Error(unsupported) if this build lacks the format, or if the format cannot have such a name.
    void (*check)(const std::string& path, OutputSet outputs) = nullptr;
    /// The names of the files of other outputs, by the names of the outputs, if the format has such files.
    std::map<std::string, std::string> (*files)(const std::string& path) = nullptr;
    /// Writes sparse fields. The grid is valid, and the band has ends. Throws as writer().
    std::unique_ptr<SparseFormatWriter> (*sparse_writer)(const std::string& path, const FieldDescription& field,
                                                         OutputSet outputs) = nullptr;
    /// The sparse field of a file, with the outputs as read(); nothing if it has a dense one. Throws as read().
    std::optional<SparseField> (*read_sparse)(const std::string& path, OutputSet wanted) = nullptr;
    /// Dense fields are stored as sparse ones.
    bool is_always_sparse = false;
    bool has_groups = false;
};

/// By the file's ending, in upper or lower case. Throws Error(code) that lists the endings.
const Format& format_of(const std::string& path, ErrorCode code);

/// Throws Error(unsupported) if this build lacks the format, or if the format cannot have such a name or store one of
/// the outputs.
void check_place_for(OutputSet outputs, const std::string& path, const Format& format);

std::unique_ptr<FormatWriter> nrrd_writer(const std::string& path, const FieldDescription& field, OutputSet outputs);
Field read_nrrd(const std::string& path, OutputSet wanted);
std::map<std::string, std::string> files_of_nrrd(const std::string& path);

std::unique_ptr<FormatWriter> npy_writer(const std::string& path, const FieldDescription& field, OutputSet outputs);
std::unique_ptr<SparseFormatWriter> sparse_npy_writer(const std::string& path, const FieldDescription& field,
                                                      OutputSet outputs);
Field read_npy(const std::string& path, OutputSet wanted);
std::optional<SparseField> read_sparse_npy(const std::string& path, OutputSet wanted);
void check_npy(const std::string& path, OutputSet outputs);
std::map<std::string, std::string> files_of_npy(const std::string& path);

std::unique_ptr<FormatWriter> vti_writer(const std::string& path, const FieldDescription& field, OutputSet outputs);
Field read_vti(const std::string& path, OutputSet wanted);
/// Throws Error(unsupported) for a grid with more samples on an axis than VTK counts.
void check_vtk_extent(const std::string& path, const Grid& grid);

std::unique_ptr<FormatWriter> vtkhdf_writer(const std::string& path, const FieldDescription& field, OutputSet outputs);
Field read_vtkhdf(const std::string& path, OutputSet wanted);

std::unique_ptr<FormatWriter> h5_writer(const std::string& path, const FieldDescription& field, OutputSet outputs);
std::unique_ptr<SparseFormatWriter> sparse_h5_writer(const std::string& path, const FieldDescription& field,
                                                     OutputSet outputs);
Field read_h5(const std::string& path, OutputSet wanted);
std::optional<SparseField> read_sparse_h5(const std::string& path, OutputSet wanted);
void check_h5(const std::string& path, OutputSet outputs);

/// Defined in vdb_write.cpp and vdb_read.cpp; in a build without OpenVDB in vdb_absent.cpp.
std::unique_ptr<FormatWriter> vdb_writer(const std::string& path, const FieldDescription& field, OutputSet outputs);
std::unique_ptr<SparseFormatWriter> sparse_vdb_writer(const std::string& path, const FieldDescription& field,
                                                      OutputSet outputs);
Field read_vdb(const std::string& path, OutputSet wanted);
std::optional<SparseField> read_sparse_vdb(const std::string& path, OutputSet wanted);
void check_vdb(const std::string& path, OutputSet outputs);

/// The same tree, so the same bytes, from slabs and from bricks.
std::unique_ptr<FormatWriter> nvdb_writer(const std::string& path, const FieldDescription& field, OutputSet outputs);
std::unique_ptr<SparseFormatWriter> sparse_nvdb_writer(const std::string& path, const FieldDescription& field,
                                                       OutputSet outputs);
Field read_nvdb(const std::string& path, OutputSet wanted);
std::optional<SparseField> read_sparse_nvdb(const std::string& path, OutputSet wanted);
void check_nvdb(const std::string& path, OutputSet outputs);

std::unique_ptr<FormatWriter> sdf_writer(const std::string& path, const FieldDescription& field, OutputSet outputs);
Field read_sdf(const std::string& path, OutputSet wanted);

/// The grid of a file, as a part of the lattice that the file states. A program that crops a field may move the first
/// sample and keep metadata that it does not understand. So the lattice counts only if it contains exactly this first
/// sample.
Grid with_lattice(const Grid& stated, const Vec3& lattice_origin, const Index3& lattice_first);

/// The file of another array beside a field: "bunny.nrrd" has "bunny_triangle.nrrd".
std::string extra_path(const std::string& path, const std::string& array);

/// The last part of a path.
std::string file_name(const std::string& path);

/// The path of a file in the folder of another file that names it. Throws Error(unreadable_input) if `name` is not a
/// plain name.
std::string path_beside(const std::string& path, const std::string& name);

/// Whether there is a file of that path. No system has one whose name it finds too long.
bool is_there(const std::string& path) noexcept;

/// The properties of a field for which most formats have no fields of their own, as the text of a JSON object. Its
/// members:
///   "origin", "spacing", "size"   of the samples: three numbers along x, y, z; the origin is the first sample
///   "lattice": {"origin", "first"}  if the samples are a part of a lattice, as in Grid
///   "band": {"inside", "outside"}   in the mesh's units; null if infinite
///   "sign", "mesh", "program"
///   "inside": "positive"            if distances and gradients are negated
///   "triangle"                      the name of the file beside it, if the output is in one; so for each output
///   "bricks", "inside_runs"         of a sparse field whose indices are in files beside it
struct Description {
    Field field;                               ///< without its arrays
    std::map<std::string, std::string> files;  ///< by the names of outputs and of indices
};

std::string description_text(const FieldDescription& field, const std::map<std::string, std::string>& files = {});

/// Throws Error(unsupported) if the file's name is not UTF-8; `reader` is what needs it.
void check_utf8(const std::string& path, std::string_view reader);

/// The sidecar of an .npy file, "bunny.npy.json". Only origin, spacing and size are needed.
/// Throws Error(unreadable_input), or Error(invalid_argument) if a value makes no sense.
Description read_description(const std::string& path);

/// The text in a file whose header states its grid: the members origin, spacing and size are ignored. `source` names
/// the file and the part of it that holds the text.
Description parse_description(const std::string& source, const std::string& text, const Grid& stated);

/// The same with the grid that the text states.
Description parse_description(const std::string& source, const std::string& text);

/// The band of these half widths. If both are 0, the field has signs alone.
Band band_of(double inside, double outside, bool has_exact_signs);

/// The rule of that name. Throws Error(invalid_argument) that lists the names.
SignRule sign_rule_of(const std::string& text);

/// Whether the word for the sign of distances inside is "positive"; nothing is "negative". Throws
/// Error(invalid_argument) for another word.
bool is_positive_inside(const std::string& text);

/// The first sample and the size of the block of the lattice that the text states; null if it states no size.
std::optional<Grid> described_block(const std::string& source, const std::string& text);

}  // namespace clsdf
