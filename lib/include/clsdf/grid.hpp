#pragma once

#include <clsdf/export.hpp>
#include <clsdf/mesh.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

namespace clsdf {

/// A length in the mesh's units, in voxels, or as a fraction of the longest side of the mesh's box.
struct CLSDF_EXPORT Length {
    enum class Unit : std::int32_t { mesh = 0, voxels = 1, extent = 2 };

    double value = 0;
    Unit unit = Unit::mesh;

    static Length in_mesh_units(double value) { return {value, Unit::mesh}; }
    static Length in_voxels(double value) { return {value, Unit::voxels}; }
    /// 0.1 is 10% of the longest side of the mesh's own box.
    static Length of_extent(double fraction) { return {fraction, Unit::extent}; }
    static Length infinite();
    /// What a text means: "10%" (of_extent), "3v" (in_voxels), "0.05" (in_mesh_units) or "full" (infinite). Throws
    /// Error(invalid_argument) that begins with `name`, the option that has the text, and quotes it.
    static Length parse(std::string_view text, std::string_view name);

    bool is_infinite() const;

    /// In the mesh's units; `voxel` is the smallest spacing of the grid, `extent` the longest side of the mesh's box.
    double resolve(double voxel, double extent) const;
};

/// A narrow band around the surface, or the signs alone. The half widths are in the mesh's units; each is >= 0, at
/// least one is > 0, and both may be infinite. They have no default: a band that is not set is refused. A sample with
/// -inside <= distance <= outside carries its exact signed distance; every other one carries +outside or -inside, with
/// the right sign (-0.0 for inside = 0). An unsigned field uses `outside` alone.
struct CLSDF_EXPORT Band {
    double inside = std::numeric_limits<double>::quiet_NaN();   ///< NaN: not set
    double outside = std::numeric_limits<double>::quiet_NaN();  ///< NaN: not set
    /// No distances: the field holds -0.0 inside and +0.0 outside. Both half widths are 0.
    bool has_signs_only = false;
    /// The field is below 0 at exactly those samples that are inside by the exact sides that links and crossings
    /// return, which off the surface are those of queries. On the surface, too: a sample on a wall is outside, one on a
    /// face within the body is inside. Values inside are then at most minus the least normal float (1.2e-38), also
    /// where the distance is 0, where the half width is 0 and in arrays of doubles. Refused without a sign. The host
    /// makes the sides: docs/grids-and-bands.md.
    bool has_exact_signs = false;

    static Band symmetric(double half_width) { return {half_width, half_width}; }
    /// Every sample of the grid carries its distance.
    static Band full();
    /// No sample carries its distance, and each its sign.
    static Band signs_only() { return {0, 0, true}; }

    /// The same band with exact signs.
    Band with_exact_signs() const {
        Band result = *this;
        result.has_exact_signs = true;
        return result;
    }

    double widest() const { return inside > outside ? inside : outside; }
    /// The value of samples inside, beyond the band: -inside; with exact signs at most minus the least normal float.
    double inside_value() const;

    /// Throws Error(invalid_argument) if a half width is NaN or negative, or if both are 0 but for signs_only().
    /// Computations refuse finite ones > 1e15 voxel.
    void validate() const;

    friend bool operator==(const Band&, const Band&) = default;
};

/// Options of Grid::around.
struct GridOptions {
    /// Samples on the longest side of the box, margin included; >= 2. Ignored if `spacing` is set.
    std::int64_t resolution = 256;
    /// Spacing per axis in the mesh's units, instead of a resolution.
    std::optional<Vec3> spacing{};
    /// Margin between the box and the first and last samples. A length in voxels counts in the resulting spacing. If it
    /// is 0, and the grid has a resolution, the first sample on the longest side is the box's lower corner exactly.
    Length margin = Length::of_extent(0.05);
    /// Every axis gets as many samples as the longest one.
    bool cubic = false;
    /// Samples at the centres of cells instead of at nodes: everything shifted by half a voxel.
    bool cell_centred = false;
};

/// Numbers of samples or cells: the same on every axis, or one for each.
class AxisCounts {
public:
    /// Not given.
    constexpr AxisCounts() = default;
    // NOLINTNEXTLINE(google-explicit-constructor): a number counts on every axis
    constexpr AxisCounts(std::int64_t all) : each_{all, all, all}, is_given_(true) {}
    constexpr AxisCounts(std::int64_t x, std::int64_t y, std::int64_t z) : each_{x, y, z}, is_given_(true) {}
    // NOLINTNEXTLINE(google-explicit-constructor): three numbers count on their axes
    constexpr AxisCounts(const Index3& each) : each_(each), is_given_(true) {}

    constexpr bool is_given() const { return is_given_; }
    constexpr const Index3& each() const { return each_; }

private:
    Index3 each_{};
    bool is_given_ = false;
};

/// How Grid::between() divides a box: {.samples = 65}, {.cells = {64, 64, 32}}. One of the two numbers is given.
struct GridDivision {
    AxisCounts samples{};  ///< on each axis, at least 2: both ends of the box are samples; 1 if they are equal
    AxisCounts cells{};    ///< on each axis, at least 1: samples at their corners, one more than the cells
    /// With cells: one sample at the centre of each instead.
    bool cell_centred = false;
};

/// A regular grid: sample (i, j, k) of the lattice lies at origin + (i hx, j hy, k hz), a real number formed from the
/// stored doubles. A Grid is the block of samples first <= (i, j, k) < first + size of that lattice; x runs fastest in
/// memory, so NumPy's shape is (nz, ny, nx). Every result depends on the lattice's sample (0, 0, 0), never on `first`:
/// a part of a grid has the same bytes as the whole. A field is as accurate far from sample (0, 0, 0) as near it. On
/// every axis a block may reach 2^30 - 128 samples from sample (0, 0, 0), and a mesh 1e14 times the smallest spacing
/// (2^40 times in y and z, for a field with a sign).
struct CLSDF_EXPORT Grid {
    Vec3 origin{};
    Vec3 spacing{1, 1, 1};
    Index3 size{};
    Index3 first{};

    /// A grid around a box whose longest side has N = `options.resolution` samples. The spacing is L / (N - 1), L being
    /// the longest side of the box after the margin was added on both sides; with a margin of k voxels it is the box's
    /// longest side divided by (N - 1 - 2 k). The other axes get as many samples as cover the box to 1e-6 voxel. With
    /// `options.spacing`, every axis does. The box stays centred, except along its longest side with a margin of 0 (see
    /// GridOptions::margin). Throws Error(invalid_argument) if the spacing would not be positive (a box without extent
    /// needs options.spacing), if the box or the margin is not finite, or if a side has too many samples.
    static Grid around(const Box& box, const GridOptions& options);

    /// The same around a mesh's box, with the band's outside half width as margin (5% of the longest side if infinite).
    static Grid around(const Mesh& mesh, std::int64_t resolution, const Band& band);

    /// The grid from `lower`, its first sample, to `upper`. The spacing is (upper - lower) / n, n being the cells along
    /// an axis, rounded once: the last sample is within n/2 ulp of the spacing of `upper`. A slice has upper == lower
    /// on an axis, and one sample there (samples 1, or cells 1 if cell_centred) with the least of the other spacings.
    /// Throws Error(invalid_argument) if upper < lower, for a point, unless one number is given, or if it does not fit.
    static Grid between(const Vec3& lower, const Vec3& upper, const GridDivision& division);

    /// The block of `part_size` samples that starts `offset` samples from this grid's first one. Throws
    /// Error(invalid_argument) if it is not inside.
    Grid part(const Index3& offset, const Index3& part_size) const;

    /// Any block of this grid's lattice: `block_size` samples from the lattice's sample `block_first` on, within this
    /// grid or beyond it. Nothing is checked here; see validate().
    Grid block(const Index3& block_first, const Index3& block_size) const;

    /// The block with so many samples more on every side, e.g. ghost samples; fewer if negative. Throws
    /// Error(invalid_argument) if none would be left, or for indices beyond 2^53.
    Grid grown(std::int64_t samples) const;

    /// A lattice `ratio` times as fine that has all samples of this one, and the block of it from this grid's first
    /// sample to its last: for samples at nodes. Throws Error(invalid_argument) for a ratio < 1 or indices beyond 2^53.
    Grid refined(std::int64_t ratio) const;

    /// The same for samples at the centres of cells: each cell becomes ratio^3 cells with a sample at the centre of
    /// each.
    Grid refined_cells(std::int64_t ratio) const;

    /// The same block shifted by half a voxel on every axis.
    Grid cell_centred() const;

    /// Position of sample (i, j, k) of this block, counted from `first`.
    Vec3 position(std::int64_t i, std::int64_t j, std::int64_t k) const;

    /// The smallest box that holds all samples: from the first one to the last.
    Box box() const;

    /// "A voxel" as a measure: the smallest spacing.
    double voxel() const;

    /// size[0] size[1] size[2]. Throws Error(out_of_memory) if so many values of four bytes do not fit the address
    /// space.
    std::size_t sample_count() const;

    /// Offset of sample (i, j, k), counted from `first`, in an array of sample_count() values.
    std::size_t offset(std::int64_t i, std::int64_t j, std::int64_t k) const {
        return static_cast<std::size_t>(i) +
               static_cast<std::size_t>(size[0]) *
                   (static_cast<std::size_t>(j) + static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(k));
    }

    /// Throws Error(invalid_argument) if a size or spacing is not positive, a number not finite, an index beyond 2^53.
    /// A computation also refuses indices beyond 2^30 - 128, and spacings that differ by more than a factor of 1e9.
    void validate() const;

    friend bool operator==(const Grid&, const Grid&) = default;
};

}  // namespace clsdf
