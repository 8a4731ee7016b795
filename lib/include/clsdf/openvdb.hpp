#pragma once

/// OpenVDB's grids of a sparse field, in clsdf::io if it is built with OpenVDB. A program that includes this header
/// links OpenVDB, too.
#include <clsdf/export.hpp>
#include <clsdf/sparse.hpp>

#include <openvdb/openvdb.h>

#include <memory>

namespace clsdf {

/// A narrow-band level set as openvdb::tools::meshToSignedDistanceField() makes it: the samples of the band are active;
/// its background is the half width outside; bricks without values that are inside are inactive tiles of minus the half
/// width inside. Indices are those of the grid's lattice. Distances are in the mesh's units, and equal the dense
/// field's bit for bit. Samples beyond the grid have the background.
///
/// The class is GRID_LEVEL_SET if the spacings are equal, the field has a sign, and the band has a width outside.
/// Otherwise it is GRID_UNKNOWN, because OpenVDB's tools assume cubic voxels.
struct LevelSet {
    openvdb::FloatGrid::Ptr distance;
    /// The nearest triangle of each active sample, -1 elsewhere; null if it was not asked for.
    openvdb::Int32Grid::Ptr triangle;
};

/// Makes a level set from layers of bricks: the sink of a sparse computation can append its argument.
///
///     LevelSetBuilder builder({grid, band, transform.sign(), {}}, Output::triangle);
///     transform.compute_sparse(grid, band, Output::triangle, [&](const SparseSlab& slab) { builder.append(slab); });
///     openvdb::FloatGrid::Ptr distance = builder.finish().distance;
class CLSDF_EXPORT LevelSetBuilder {
public:
    /// `outputs`: Output::triangle, or none. Throws Error(unsupported) for other outputs, for a field that is positive
    /// inside, and for a grid whose indices or spacings OpenVDB does not have; Error(invalid_argument) for an invalid
    /// grid or band.
    explicit LevelSetBuilder(const FieldDescription& field, OutputSet outputs = {});
    LevelSetBuilder(LevelSetBuilder&&) noexcept;
    LevelSetBuilder& operator=(LevelSetBuilder&&) noexcept;
    ~LevelSetBuilder();

    /// The next layers. Throws Error(invalid_argument) if the slab lacks values of an output.
    void append(const SparseSlab& slab);

    /// The grids. Nothing can be appended afterwards.
    LevelSet finish();

private:
    class Trees;
    std::unique_ptr<Trees> trees_;
};

/// The same of a field in memory; with the triangle if the field has it.
CLSDF_EXPORT LevelSet make_level_set(const SparseField& field);

}  // namespace clsdf
