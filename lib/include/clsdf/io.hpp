#pragma once

/// Files of fields, in a separate target, clsdf::io, which has the files of meshes and points, too. It links HDF5,
/// expat, zlib and, if it is built in, OpenVDB, which the core library and clsdf::meshes do not need.
#include <clsdf/export.hpp>
#include <clsdf/field.hpp>
#include <clsdf/fractions.hpp>
#include <clsdf/mesh_files.hpp>
#include <clsdf/outputs.hpp>
#include <clsdf/segments.hpp>
#include <clsdf/sparse.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace clsdf {

/// Reads a file that write_field() wrote, with the same grid, or a file of another program with float or double values
/// of either byte order, raw, on a grid parallel to the axes. If the file states no band, the band has no end; if it
/// states no sign rule, the rule is `automatic`. An output is empty if its file does not exist. Throws
/// Error(unsupported) for an unknown ending, Error(unreadable_input) that names the file, the field and the value, or
/// Error(out_of_memory).
CLSDF_EXPORT Field read_field(const std::string& path);

/// The same without the outputs that are not wanted, which may be damaged. The distance is always read.
CLSDF_EXPORT Field read_field(const std::string& path, OutputSet wanted);

/// The files of outputs that the field's file names but that do not exist, for example after only one file was copied.
/// read_field() leaves these outputs empty. Throws as read_field().
CLSDF_EXPORT std::vector<std::string> missing_field_files(const std::string& path);

/// Writes a field by the file's ending: .nrrd, .npy, .vti, .vtkhdf, .h5, .nvdb, .sdf or, if OpenVDB is built in, .vdb.
/// docs/formats.md describes their contents. With .nrrd and .npy each other output has a separate file,
/// FILE_triangle.nrrd or FILE_closest.npy. No file gets its final name before all are written; the distances appear
/// last. Throws Error(output_failure), Error(unsupported) for an unknown ending, or Error(invalid_argument) if the
/// arrays do not fit the grid.
CLSDF_EXPORT void write_field(const Field& field, const std::string& path);

/// Throws the error that write_field() would throw for the ending, for outputs that the format cannot store, or for a
/// folder that is missing or write-protected: a check before a long computation. Leaves no file.
CLSDF_EXPORT void check_field_path(const std::string& path, OutputSet outputs = {});

class FormatWriter;

/// Writes a field slab by slab, so it need never be whole in memory. The format follows from the file's ending, as with
/// write_field(), and the bytes do not depend on the slabs. No file gets its final name before finish(); without it, no
/// file stays. A .vdb keeps the samples of the band in memory until finish(), a .nvdb in an unfinished file; the other
/// formats write each slab in append(). One thread at a time.
class CLSDF_EXPORT FieldWriter {
public:
    /// Throws Error(unsupported) for an unknown ending, or for a grid, outputs or a sign of the inside that the format
    /// cannot store, Error(invalid_argument) for an invalid grid or band, a field of signs alone or without a sign
    /// that is to be positive inside, or a floor of another rule than `below`; or Error(output_failure). The values
    /// are written as they are.
    FieldWriter(const std::string& path, const FieldDescription& field, OutputSet outputs = {});
    FieldWriter(FieldWriter&&) noexcept;
    FieldWriter& operator=(FieldWriter&&) noexcept;
    ~FieldWriter();

    /// The next slices, in ascending z. Throws Error(output_failure), or Error(invalid_argument) if the arrays are not
    /// whole slices of exactly the announced outputs, or have too many slices. After an error no slice can be appended.
    void append(const FieldSlab& slab);

    /// Gives the files their names, the distances' last. Throws Error(output_failure), or Error(invalid_argument) if
    /// slices are missing.
    void finish();

private:
    FieldDescription field_;
    OutputSet outputs_;
    std::int64_t slices_ = 0;
    std::unique_ptr<FormatWriter> format_;  // null after the end or a failure
};

class SparseFormatWriter;

/// Whether the file's format, by its ending, stores sparse fields: .nvdb, .vdb, .npy and .h5. Throws Error(unsupported)
/// for an unknown ending.
CLSDF_EXPORT bool stores_sparse_fields(const std::string& path);
/// Whether it stores dense fields as sparse ones, too: .nvdb and .vdb.
CLSDF_EXPORT bool stores_sparse_fields_only(const std::string& path);

/// Whether it stores the group of each sample, if the field has triangles and groups: .vti, .vtkhdf.
CLSDF_EXPORT bool stores_groups(const std::string& path);

/// Reads the sparse field of a file, with the outputs that are wanted and in the file. Nothing if the file has a dense
/// field, which read_field() reads; that function also makes a sparse field dense. The bricks of .nvdb and .vdb are
/// their leaves; samples beyond the grid have the background. Throws as read_field().
CLSDF_EXPORT std::optional<SparseField> read_sparse_field(const std::string& path, OutputSet wanted = Output::distance);

/// The dense field of a sparse one: the same values, bit for bit. Throws Error(out_of_memory), or
/// Error(invalid_argument) for a grid that makes no sense.
CLSDF_EXPORT Field to_dense(const SparseField& field);

/// Writes a sparse field: see SparseFieldWriter.
CLSDF_EXPORT void write_field(const SparseField& field, const std::string& path);

/// Writes a sparse field, layers of bricks at a time: the sink of a sparse computation can append its argument. The
/// format follows from the file's ending: .nvdb, .vdb, .npy or .h5 (docs/sparse.md). The bytes do not depend on how the
/// layers are divided; those of .nvdb and .vdb are the dense field's. A .vdb keeps the bricks in memory until finish(),
/// .nvdb and .h5 in an unfinished file in the folder of the final one; .npy writes them in append(). Without finish()
/// no file stays. One thread at a time.
class CLSDF_EXPORT SparseFieldWriter {
public:
    /// Throws as FieldWriter, and Error(unsupported) for a format that stores no sparse fields, or
    /// Error(invalid_argument) for a band without end or of signs alone.
    SparseFieldWriter(const std::string& path, const FieldDescription& field, OutputSet outputs = {});
    SparseFieldWriter(SparseFieldWriter&&) noexcept;
    SparseFieldWriter& operator=(SparseFieldWriter&&) noexcept;
    ~SparseFieldWriter();

    /// The next layers, in ascending z. Throws Error(output_failure), or Error(invalid_argument) if they do not follow
    /// the layers before, or if a brick or a run is out of order or not in them, or if the values are not those of
    /// exactly the announced outputs. After an error nothing can be appended.
    void append(const SparseSlab& slab);

    /// Gives the file its name. Throws Error(output_failure), or Error(invalid_argument) if layers are missing.
    void finish();

private:
    FieldDescription field_;
    OutputSet outputs_;
    std::int64_t next_ = 0;                       // the lattice's z of the next layers
    std::unique_ptr<SparseFormatWriter> format_;  // null after the end or a failure
};

/// Cells of a level of a refined mesh: the samples of the grid are their centres. A field's are {field.grid,
/// field.slab()}; the values are not copied.
struct CellBox {
    Grid grid;
    FieldSlab values;
};

/// Writes boxes of refined levels as VTK's OverlappingAMR (.vtkhdf), with the outputs as data of cells: ParaView and
/// VTK show coarse cells where no finer box covers them. Boxes of one spacing are a level, in any order, and do not
/// overlap; each spacing is a whole part of the next coarser one, and the cells of all levels fit the coarsest ones.
/// Complete or not at all. read_field() does not read it; VTK 9.7 does, 9.1 does not. Throws Error(invalid_argument)
/// that names the box, Error(unsupported) for another ending, Error(output_failure).
CLSDF_EXPORT void write_overlapping_amr(std::span<const CellBox> boxes, const std::string& path);

/// Writes links, whose grid and directions these are: .npz or .h5, with arrays as Links has them, `stencil`, `inside`
/// (a byte for each sample, z first), `origin`, `spacing`, `size` and `first`; or .npy, a structure for each link.
/// groups: of the mesh; the file gets the number of the triangle's group, too, in the array `groups` or the member
/// `group`, and no_group if there is no triangle. Complete or not at all. Throws Error(output_failure),
/// Error(unsupported) for another ending, Error(invalid_argument) if the links are not of this grid and these
/// directions.
CLSDF_EXPORT void write_links(const Links& links, const Grid& grid, std::span<const LinkDirection> directions,
                              const std::string& path, const FaceGroups* groups = nullptr);
/// Writes crossings of the grid's edges: .npz or .h5, with `x`, `x_triangles` and, if they are there, `x_groups` and
/// `x_counts`, the same of y and z (z first), and the others as above. Throws as above.
CLSDF_EXPORT void write_crossings(const Crossings& crossings, const Grid& grid, const std::string& path,
                                  const FaceGroups* groups = nullptr);
/// Writes fractions of cells: .npz or .h5, with a row for each cell that the surface meets (`cells`, `pieces`,
/// `volume`, `centroid`, `area`, `vector_area`, `surface_centroid`, `face_fractions`, `face_centroids`), `full` (a byte
/// for each cell, z first) and the grid as above; or .vti, with arrays of all cells: `volume`, `type` (CellType),
/// `pieces`, `area`, `vector_area`, `centroid`, `surface_centroid`. Complete or not at all. Throws
/// Error(output_failure), Error(unsupported) for another ending.
CLSDF_EXPORT void write_fractions(const Fractions& found, const std::string& path);
/// Each throws Error(unsupported) if the file's ending is another one.
CLSDF_EXPORT void check_fractions_path(const std::string& path);
CLSDF_EXPORT void check_links_path(const std::string& path);
CLSDF_EXPORT void check_crossings_path(const std::string& path);

/// For a program that is about to end during its work, for instance on Ctrl-C: removes the unfinished files of all
/// threads, and prevents them from getting their final names. A thread that continues to write waits for ever, so the
/// program must end now. May be called from any thread, but not from a signal handler.
///
/// A process that is killed leaves unfinished files, ".clsdf-MACHINE-PID-N.part" in the folder of the final file. The
/// first file that another process writes there removes those without a lock, if they are of the same machine and user
/// and the file system belongs to one machine (docs/formats.md lists these). On others, such as NFS, they stay.
CLSDF_EXPORT void abandon_unfinished_files() noexcept;

}  // namespace clsdf
