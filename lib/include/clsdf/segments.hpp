#pragma once

#include <clsdf/arrays.hpp>
#include <clsdf/export.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/outputs.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

/// Where segments meet the surface: links of a lattice, crossings of grid edges, rays (docs/segments.md).
namespace clsdf {

/// What counts where a segment meets the surface. The values of the enumerators never change.
enum class Hits : std::int32_t {
    walls = 0,  ///< where inside and outside meet, by the sign rule: never a face within a body
    faces = 1,  ///< every face as given, also of sheets and of meshes without a sign
};

/// What is said of a link or a crossing, as bits. The values of the enumerators never change.
enum class SegmentFlag : std::uint8_t {
    none = 0,
    film = 1,      ///< the sign changes where an open mesh has no face: there is no triangle, and q is known to 2^-30
    between = 2,   ///< both ends are outside, with a body between them
    sheet = 8,     ///< of Hits::faces: the sides of the ends are equal
    closing = 16,  ///< the wall is one of those from the rim of a terrain down to its floor, or the floor (the rule
                   ///< below): there is no triangle
};

/// A step on the lattice, in samples.
using LinkDirection = std::array<std::int32_t, 3>;

/// The directions of a lattice-Boltzmann stencil, in the order of a code: "D3Q15", "D3Q19" or "D3Q27"; "OpenLB",
/// "waLBerla" (also lbmpy's), "Palabos" or "XLB". The first is the zero vector, which has no links. Throws
/// Error(invalid_argument) that names what there is.
CLSDF_EXPORT std::vector<LinkDirection> stencil(std::string_view name, std::string_view code = "waLBerla");

struct LinkOptions {
    Hits hits = Hits::walls;
    /// Also links with both ends outside and a body between them: two rows each, one from each end. With Hits::walls.
    bool with_between = false;
};

struct CrossingOptions {
    /// EdgeCrossings::counts, too, for which the edges with equal sides are looked at.
    bool with_counts = false;
};

/// A bit for each sample of a grid: whether it is inside, for SegmentFlag and links. x fastest, the lowest bit of a
/// byte first, rows one after another. A sample has the side that a query has at Grid::position(); on a wall it is
/// outside, on a face within a body inside.
struct SampleSides {
    Index3 size{};
    std::vector<std::uint8_t> bits;

    /// offset: from the grid's first sample.
    bool is_inside(const Index3& offset) const {
        return is_inside(static_cast<std::size_t>((offset[2] * size[1] + offset[1]) * size[0] + offset[0]));
    }
    /// sample: its number in the order of the bits.
    bool is_inside(std::size_t sample) const { return (bits[sample / 8] >> sample % 8 & 1) != 0; }
    std::size_t sample_count() const { return static_cast<std::size_t>(size[0] * size[1] * size[2]); }
};

/// The links of a grid that meet the surface, a row each, by sample (z, then y, then x), then by direction. A link
/// begins at its row's sample, which is in the grid and outside (with Hits::faces on any side), and ends a direction
/// farther, in the grid or beyond it.
struct Links {
    std::vector<std::array<std::int32_t, 3>> samples;  ///< on the lattice: Grid::first counts
    std::vector<std::uint8_t> directions;              ///< the number of the direction among those asked for
    std::vector<double> q;  ///< the part of the link up to the first wall: 0 (the sample is on the wall) to 1
    std::vector<std::uint32_t> triangles;  ///< of the first wall; of several the lowest; or no_triangle
    std::vector<std::uint32_t> counts;     ///< walls on the link
    std::vector<SegmentFlag> flags;
    SampleSides inside;

    std::size_t size() const { return q.size(); }
};

/// A part of a link as a float: 0 and 1 only if the double is.
inline float as_float_part(double q) {
    const auto single = static_cast<float>(q);
    if (q > 0 && single == 0) return std::numeric_limits<float>::denorm_min();
    return q < 1 && single == 1 ? 1 - std::numeric_limits<float>::epsilon() / 2 : single;
}

/// Called with the links of a grid slab after slab, which are there until it returns: those whose samples are in
/// `part`, whole slices of the grid, in the order of z. It may use the transform. Its exceptions are passed on;
/// std::bad_alloc becomes Error(out_of_memory).
using LinkSink = std::function<void(const Grid& part, const Links& links)>;

/// The caller's arrays for links, each of which may be missing; all on the host or in buffers of the device. The rows,
/// up to `flags`, have `room` items. q and dense may be float or double (as_float_part()).
struct LinkTargets {
    std::size_t room = 0;
    OutputArray samples{};     ///< int32, three components
    OutputArray directions{};  ///< uint8
    OutputArray q{};
    OutputArray triangles{};  ///< uint32 or int32 (then -1 for none)
    OutputArray counts{};     ///< uint32
    OutputArray flags{};      ///< uint8
    OutputArray inside{};     ///< uint8, an item for each sample of the grid: 1 if it is inside, else 0
    /// q by direction and sample; -1 where there is no link. A direction's field is an array of samples with these
    /// strides, and component_stride leads from a direction's to the next one's. Zeros: packed, field by field
    /// (direction, z, y, x). It needs no room.
    OutputArray dense{};
};

/// Where the edges of a grid along one axis cross the surface. Edge (i, j, k) joins sample (i, j, k) of the grid with
/// the next one along the axis, so there is one edge less than samples on that axis. x fastest.
struct EdgeCrossings {
    Index3 size{};
    std::vector<double>
        coordinates;  ///< of the first wall from the end outside, along the axis; NaN if the sides agree
    std::vector<std::uint32_t> triangles;  ///< or no_triangle
    std::vector<std::uint32_t> counts;     ///< walls on the edge, also where the sides agree; empty if not asked for
};

struct Crossings {
    std::array<EdgeCrossings, 3> axes;
    SampleSides inside;
};

/// What is asked about rays.
struct RayOptions {
    Hits hits = Hits::walls;
    /// Hits beyond are left out: in lengths of the direction, 0 to infinity. t, rounded to a double, is compared.
    double limit = std::numeric_limits<double>::infinity();
};

/// The caller's arrays for rays, an item for each ray. What is given decides what is looked for: the first
/// hits alone, whether there is any, or all.
struct RayTargets {
    /// Numbers of `t` and `triangles` for each ray, as the components of an item: its first hits, ascending. Those that
    /// are missing are infinity and no_triangle.
    std::size_t most = 1;
    OutputArray t{};  ///< float or double: in lengths of the direction; NaN of a ray that is not usable
    /// uint32 or int32 (then -1 for none); of several at equal t the lowest. A wall without a triangle is one of the
    /// film of an open mesh, or of the walls and the floor of the rule below: it has a finite t.
    OutputArray triangles{};
    OutputArray counts{};  ///< uint32 or int32: all hits up to the limit
    OutputArray any{};     ///< uint8: 1 if there is a hit up to the limit, else 0
};

}  // namespace clsdf
