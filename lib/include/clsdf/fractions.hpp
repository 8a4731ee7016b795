#pragma once

#include <clsdf/arrays.hpp>
#include <clsdf/calls.hpp>
#include <clsdf/export.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/outer.hpp>
#include <clsdf/topology.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

/// The parts of a grid's cells that a mesh fills (docs/fractions.md).
namespace clsdf {

class Device;

/// The part of a cell that is measured. The values of the enumerators never change.
enum class CellPart : std::int32_t {
    solid = 0,  ///< what the mesh encloses
    fluid = 1,  ///< the rest
};

/// The cell that has a piece of surface which lies in the face between two cells. The values of the enumerators never
/// change.
enum class WallCell : std::int32_t {
    above = 0,  ///< the one with the larger index, on whichever side the solid is
    solid = 1,  ///< the one on the solid's side: the other one has no surface there, and the face no solid
    fluid = 2,  ///< the one on the fluid's side: the face is solid
};

/// The meaning of a cell's numbers.
struct FractionOptions {
    CellPart part = CellPart::solid;
    WallCell walls = WallCell::above;
    /// The direction of vector areas and normals: out of the solid, or into it.
    bool normals_into_solid = false;
    /// Areas are parts of a cell's face across the normal, as AMReX's bndryarea: the length of the vector area divided
    /// by sqrt((n_x hy hz)^2 + (n_y hx hz)^2 + (n_z hx hy)^2). A vector area has this length.
    bool areas_of_faces = false;
    /// Centroids are points of the mesh's space; else they are in cells from the middle of the cell or face.
    bool centroids_as_points = false;
    /// Vertices that are at most so far from a plane between cells are moved onto it: in cells, 0 to 0.001. Walls that
    /// are in such planes but for rounding then leave no slivers.
    double snap = 0;
    /// Of dense arrays: each coordinate of the surface's centroid in cells without surface.
    double no_surface_centroid = 0;

    /// The options for "plain" (the defaults), "amrex", "chombo" or "vtk". Throws Error(invalid_argument) for others.
    CLSDF_EXPORT static FractionOptions of(std::string_view convention);
    /// The same with another part. "amrex" and "chombo" are of a flow: what is counted then is the flow, so the wall in
    /// a face between two cells belongs to its cell, and normals look as seen from it.
    CLSDF_EXPORT static FractionOptions of(std::string_view convention, CellPart part);

    friend bool operator==(const FractionOptions&, const FractionOptions&) = default;
};

/// A cell of a grid that the surface meets.
struct CellFraction {
    std::array<std::int32_t, 3> cell{};  ///< indices on the lattice of the sample at its low corner
    /// Parts of the surface in the cell that are joined over edges. With more than one, a centroid and a normal say
    /// little.
    std::uint32_t pieces = 0;
    double volume = 0;   ///< of FractionOptions::part, as a fraction of the cell
    Vec3 centroid{};     ///< of that part, in cells from the middle of the cell: -0.5 to 0.5; 0 if it has no volume
    double area = 0;     ///< of the surface in the cell, in squared units of the mesh
    Vec3 vector_area{};  ///< the integral of the surface's unit normal out of the solid, in squared units
    Vec3 surface_centroid{};                 ///< as `centroid`
    std::array<double, 6> face_fractions{};  ///< of that part in the low and high face across x, y and z
    /// Of that part in these faces, along the two other axes in the order x, y, z, in cells from the face's middle.
    std::array<std::array<double, 2>, 6> face_centroids{};
};

/// The cells of a grid: those between neighbouring samples, one fewer than samples along each axis.
struct Fractions {
    Grid grid;
    std::vector<CellFraction> cells;  ///< that the surface meets, sorted by z, y, x
    /// Of the other cells those that are wholly of FractionOptions::part: a bit a cell, x fastest, the lowest bit of a
    /// byte first. Those that the surface meets have 0.
    std::vector<std::uint8_t> full;
    FractionOptions options{};  ///< what the numbers mean

    std::array<std::size_t, 3> counts() const {
        return {static_cast<std::size_t>(grid.size[0] - 1), static_cast<std::size_t>(grid.size[1] - 1),
                static_cast<std::size_t>(grid.size[2] - 1)};
    }
    bool is_full(std::size_t i, std::size_t j, std::size_t k) const {
        const auto [x, y, z] = counts();
        return is_full((k * y + j) * x + i);
    }
    /// cell: its number in the order of the bits.
    bool is_full(std::size_t cell) const { return (full[cell / 8] >> cell % 8 & 1) != 0; }
};

/// Called with the cells of each grid, or of each slab of one, in their order. Its exceptions are passed on;
/// std::bad_alloc becomes Error(out_of_memory).
using FractionSink = std::function<void(std::size_t grid_number, Fractions& found)>;

/// The value of a cell in the array of types. The values of the enumerators never change.
enum class CellType : std::uint8_t {
    empty = 0,  ///< nothing of FractionOptions::part: AMReX's covered cell
    full = 1,   ///< wholly of that part: AMReX's regular cell
    cut = 2,    ///< the surface meets it
};

/// The caller's arrays, each of which may be missing: of float or double, but for `types` and `pieces`. Of
/// cells they have an item for each cell of the grid, x fastest; face_fractions[d] and face_centroids[d] one for each
/// face across axis d, one more along that axis. Volumes and fractions of faces are clamped to [0, 1]. Without strides
/// the components of an item lie side by side; with a component_stride alone those of all items do.
struct FractionTargets {
    OutputArray types{};             ///< uint8: CellType
    OutputArray pieces{};            ///< uint8, uint32 or int32; 0 in cells that the surface does not meet
    OutputArray volume{};            ///< 0 or 1 in cells that the surface does not meet
    OutputArray centroid{};          ///< three components; the middle of cells that the surface does not meet
    OutputArray area{};              ///< 0 in cells that the surface does not meet, as of the next two
    OutputArray vector_area{};       ///< three components
    OutputArray normal{};            ///< three components: the vector area divided by its length
    OutputArray surface_centroid{};  ///< three components; FractionOptions::no_surface_centroid elsewhere
    std::array<OutputArray, 3> face_fractions{};
    std::array<OutputArray, 3> face_centroids{};  ///< two components
};

/// One box of cells of many.
struct FractionRequest {
    Grid grid;
    FractionTargets targets;
};

/// The caller's arrays for the members of CellFraction, each of which may be missing, an item for each cell that the
/// surface meets, in the order of Fractions::cells. They have `room` items, of any strides; real numbers are float or
/// double.
struct FractionRows {
    std::size_t room = 0;
    OutputArray cells{};   ///< int32, three components
    OutputArray pieces{};  ///< uint32 or int32
    OutputArray volume{};
    OutputArray centroid{};  ///< three components
    OutputArray area{};
    OutputArray vector_area{};       ///< three components
    OutputArray surface_centroid{};  ///< three components
    OutputArray face_fractions{};    ///< six components
    OutputArray face_centroids{};    ///< twelve components: two of each face
    /// uint8, an item for each cell of the grid, x fastest: 1 if it is wholly of FractionOptions::part. It needs no
    /// room.
    OutputArray full{};
};

/// The fractions of cells that a mesh fills: volumes, areas and centroids, by the mesh's triangles clipped at the
/// cells' faces. They are those of its outer() surface, so parts may overlap. Sums are the mesh's: the volumes add up
/// to the volume inside, the areas to its area, differences of opposite faces are the vector area, up to rounding.
///
/// A vertex on a face between cells counts as above it, so a piece of surface that lies in such a face belongs to the
/// cell above, and is counted once; see WallCell. Rounding may make a fraction differ from [0, 1] by some 1e-13.
///
/// A grid may be a part of a lattice: each cell has the same bytes as in the whole. Uses all cores; may be called by
/// many threads. Throws the errors of outer() and of the validation of the grid; Error(invalid_argument) unless it has
/// two samples or more on each axis, none of them 2^31 or more from its origin; Error(out_of_memory). Of `call`,
/// should_stop and progress count.
CLSDF_EXPORT Fractions fractions(const Mesh& mesh, const Grid& grid, SignRule sign = SignRule::automatic,
                                 const CallOptions& call = {});
CLSDF_EXPORT Fractions fractions(const Mesh& mesh, const Grid& grid, const FractionOptions& options,
                                 SignRule sign = SignRule::automatic, const CallOptions& call = {});
/// The same of an outer surface, which is not cut again: for many boxes and levels.
CLSDF_EXPORT Fractions fractions(const OuterSurface& surface, const Grid& grid, const FractionOptions& options = {},
                                 const CallOptions& call = {});
/// The same of many grids, one after the other on the calling thread; of few at a time the cells are in memory. Grids
/// of one lattice share their preparation.
CLSDF_EXPORT void fractions(const OuterSurface& surface, std::span<const Grid> grids, const FractionSink& sink,
                            const FractionOptions& options = {}, const CallOptions& call = {});
/// The cells of a grid of any size, slab by slab: whole layers of cells in the order of z, whose rows one after another
/// are those of the whole. The sink gets the number of the slab, which is Fractions::grid. The memory is that of two
/// slabs, and 64 bytes a cell of a layer for each thread; fewer threads work if these were more than 4 GiB together.
/// Throws Error(invalid_argument) for an empty sink, as the function above does.
CLSDF_EXPORT void fraction_slabs(const OuterSurface& surface, const Grid& grid, const FractionSink& sink,
                                 const FractionOptions& options = {}, const CallOptions& call = {});
/// How many cells of a grid the surface meets. Takes the time of fraction_slabs().
CLSDF_EXPORT std::size_t count_fractions(const OuterSurface& surface, const Grid& grid,
                                         const FractionOptions& options = {}, const CallOptions& call = {});

/// The same into arrays of the caller's on the host. Throws also Error(unsupported) for memory of a device and other
/// types, Error(invalid_argument) for arrays that are too small or overlap; then no array has changed.
CLSDF_EXPORT void fractions(const OuterSurface& surface, std::span<const FractionRequest> requests,
                            const FractionOptions& options = {}, const CallOptions& call = {});
/// The rows of a grid into arrays of the caller's on the host. `count` gets how many rows there are. If arrays of rows
/// have less room, throws Error(invalid_argument) that names both numbers, `count` has it, and nothing is written.
/// After other errors `count` is 0. Items beyond the rows stay as they are. Throws as the function above does.
CLSDF_EXPORT void fractions(const OuterSurface& surface, const Grid& grid, const FractionRows& rows, std::size_t& count,
                            const FractionOptions& options = {}, const CallOptions& call = {});

/// The same two with arrays that may be buffers of a device, too: they are mapped after the events of the call's
/// wait_list, and have the results when the call returns. Throw also Error(invalid_argument) for memory of another
/// context, Error(unsupported) for a buffer that the host may not write, Error(device_failure).
CLSDF_EXPORT void fractions(const Device& device, const OuterSurface& surface,
                            std::span<const FractionRequest> requests, const FractionOptions& options = {},
                            const CallOptions& call = {});
CLSDF_EXPORT void fractions(const Device& device, const OuterSurface& surface, const Grid& grid,
                            const FractionRows& rows, std::size_t& count, const FractionOptions& options = {},
                            const CallOptions& call = {});

}  // namespace clsdf
