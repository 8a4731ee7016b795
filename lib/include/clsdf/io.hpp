#pragma once

/// Files of meshes and fields. A target of its own, clsdf::io: it links HDF5, expat and, if it is built in, OpenVDB,
/// which the library proper has no use for.
#include <clsdf/export.hpp>
#include <clsdf/field.hpp>
#include <clsdf/mesh.hpp>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace clsdf {

/// Reads .off, .obj, .stl (ASCII and binary) or .ply (ASCII and binary, both byte orders); polygons are triangulated as
/// fans, and a soup (STL) is welded by equal coordinates. Throws Error(unreadable_input or invalid_mesh) that names the
/// file, the line or element and the value; Error(unsupported) for an unknown ending.
CLSDF_EXPORT Mesh read_mesh(const std::string& path);

/// Red, green and blue, sRGB.
using FaceColour = std::array<std::uint8_t, 3>;

/// Writes .off, .obj, .stl (binary) or .ply (binary, little endian) by the file's ending; complete or not at all.
/// `colours`: of each triangle, or none; .ply keeps them, the others have no place for them. Throws
/// Error(invalid_argument) for another number of them, Error(unsupported) for an unknown ending, Error(output_failure).
CLSDF_EXPORT void write_mesh(const Mesh& mesh, const std::string& path, std::span<const FaceColour> colours = {});

/// Reads what write() wrote, with the very same grid, and such files of other programs if they say enough: float or
/// double of either byte order, raw, on a grid parallel to the axes. A band that they do not state is without end, and
/// a sign rule `automatic`. An output is empty if its file is not there.
/// Throws Error(unsupported) for an unknown ending, Error(unreadable_input) that names the file, the field and the
/// value, or Error(out_of_memory).
CLSDF_EXPORT Field read_field(const std::string& path);

/// Writes a field by the file's ending: .nrrd, .npy, .vti, .h5, .sdf or, if OpenVDB is built in, .vdb; docs/formats.md
/// says what each of them holds. Beside .nrrd and .npy each other output has a file of its own, FILE_triangle.nrrd
/// or FILE_closest.npy. Nothing appears under its final name before everything has been written; the distances appear
/// last.
/// Throws Error(output_failure), Error(unsupported) for an unknown ending, or Error(invalid_argument) if the arrays do
/// not fit the grid.
CLSDF_EXPORT void write(const Field& field, const std::string& path);

/// Throws what write() would throw for the ending, for outputs that the format has no place for, or for a folder that
/// is missing or write-protected, so that nothing is computed in vain. Leaves nothing behind.
CLSDF_EXPORT void check_output(const std::string& path, const Outputs& outputs = {});

class FormatWriter;

/// Writes a field that is never whole in memory, slab by slab, by the file's ending as write() does and with the same
/// bytes however it is cut into slabs. Nothing appears under its final name before finish(); without it, nothing is
/// left behind. A .vdb keeps the samples of the band in memory until finish(), every other format only what the
/// operating system has not yet written.
class CLSDF_EXPORT FieldWriter {
public:
    /// Throws Error(unsupported) for an unknown ending, or for a grid or outputs that the format has no place for,
    /// Error(invalid_argument) for a grid or a band that makes no sense, or Error(output_failure).
    FieldWriter(const std::string& path, const FieldDescription& field, const Outputs& outputs = {});
    FieldWriter(FieldWriter&&) noexcept;
    FieldWriter& operator=(FieldWriter&&) noexcept;
    ~FieldWriter();

    /// The next slices, in ascending z. Throws Error(output_failure), or Error(invalid_argument) if the arrays are not
    /// whole slices of just the outputs that were announced, or more than there are; nothing can be appended then.
    void append(const FieldSlab& slab);

    /// Gives the files their names, the distances' last. Throws Error(output_failure), or Error(invalid_argument) if
    /// slices are missing.
    void finish();

private:
    FieldDescription field_;
    Outputs outputs_;
    std::int64_t slices_ = 0;
    std::unique_ptr<FormatWriter> format_;  // null after the end or a failure
};

/// For a program that is about to end in the middle of its work, on Ctrl-C for instance: removes what the files that
/// are being written have under temporary names, in every thread, and lets none of them get its own name any more. A
/// thread that goes on to write waits for ever, so the program must end now. May be called from any thread, but not
/// from a signal handler.
///
/// A process that is killed leaves such files, ".clsdf-PID-N.part" in the folder of the final one. The first file that
/// another process writes in the folder removes those that no process holds locked, if they belong to the same user and
/// the file system is known to belong to one machine (docs/formats.md lists which). Elsewhere, on NFS above all, they
/// stay.
CLSDF_EXPORT void abandon_unfinished_files() noexcept;

}  // namespace clsdf
