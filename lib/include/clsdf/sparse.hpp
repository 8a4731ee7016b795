#pragma once

/// Sparse fields: values near the surface only, and the sign of the rest. docs/sparse.md.
#include <clsdf/export.hpp>
#include <clsdf/field.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/outputs.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace clsdf {

/// A brick is a block of 8 x 8 x 8 samples. Bricks tile the lattice from its sample (0, 0, 0), whatever grid is
/// computed, so the bricks of a part of a grid are bricks of the whole. A brick is named by the index of its first
/// sample on the lattice, a multiple of 8 on each axis.
inline constexpr std::int64_t brick_side = 8;
inline constexpr std::size_t brick_samples = 512;

/// Bricks that follow each other along x: (first[0] + 8 n, first[1], first[2]) for n < count.
struct BrickRun {
    Index3 first{};
    std::int64_t count = 0;

    /// Whether the brick with this first sample is one of them.
    bool holds(const Index3& brick) const {
        return brick[1] == first[1] && brick[2] == first[2] && brick[0] >= first[0] &&
               brick[0] - first[0] < count * brick_side;
    }

    friend bool operator==(const BrickRun&, const BrickRun&) = default;
};

/// Whole layers of a sparse field's bricks, in memory of their owner.
///
/// A brick of the grid has values if one of its samples is in the band, limits included, or if it has samples of both
/// signs. All 512 samples have values, also those that lie beyond the grid. In each other brick all samples are beyond
/// the band and have one sign: their distance is -band.inside if a run of `inside` holds the brick, +band.outside if
/// not; every bit of their other outputs is set. Bricks and runs are sorted by z, then y, then x; a run is as long as
/// possible.
struct CLSDF_EXPORT SparseSlab {
    Grid part;                           ///< the layers: a block of whole bricks, which may stick out of the grid
    std::span<const Index3> bricks{};    ///< that have values
    FieldSlab values{};                  ///< brick n has the samples [512 n, 512 (n + 1)), x fastest
    std::span<const BrickRun> inside{};  ///< bricks without values that are inside

    /// The number of the brick that has this sample's values, by binary search. Empty: it has none, or is not in the
    /// layers. Indices of samples count on the lattice.
    std::optional<std::size_t> find(const Index3& sample) const;
    /// The distance of a sample of the layers. band: of the field, which is negative inside.
    float distance_at(const Index3& sample, const Band& band) const;
};

/// How many bricks with values a sparse field has, and how many runs of bricks inside.
struct SparseCounts {
    std::size_t bricks = 0;
    std::size_t runs = 0;

    friend bool operator==(const SparseCounts&, const SparseCounts&) = default;
};

/// One sparse field of many.
struct SparseRequest {
    Grid grid;
    Band band;
    OutputSet outputs = Output::distance;
};

/// The caller's arrays for a sparse field, on the host. Their sizes are what they have room for; what the field does
/// not need of them stays as it is.
struct SparseTargets {
    std::span<Index3> bricks{};
    std::span<BrickRun> inside{};
    /// Packed arrays of 512 samples for each element of `bricks`, of the types of output_table(); the triangle may also
    /// be int32.
    OutputTargets values{};
};

/// Called with the layers of a sparse field, one part after the other in the order of z; together the parts are the
/// grid's bricks. The spans hold until it returns. Its exceptions are passed on; std::bad_alloc becomes
/// Error(out_of_memory).
using SparseSink = std::function<void(const SparseSlab& slab)>;

/// A sparse field on the host: see SparseSlab, whose arrays it has, of all layers. `grid` is the block of samples that
/// was asked for.
struct CLSDF_EXPORT SparseField : FieldDescription {
    std::vector<Index3> bricks;
    std::vector<BrickRun> inside;

    std::span<std::byte> bytes(Output output) { return arrays_[detail::index_of(output)]; }
    std::span<const std::byte> bytes(Output output) const { return arrays_[detail::index_of(output)]; }

    /// The outputs that it has; none without bricks.
    OutputSet outputs() const { return values().outputs(); }
    /// Makes room for the values of so many bricks; the first ones stay, new ones are not initialised. Throws
    /// std::bad_alloc.
    std::span<std::byte> resize(Output output, std::size_t brick_count);

    /// A view of all values, and of all layers.
    FieldSlab values() const;
    SparseSlab slab() const;

    /// See SparseSlab::find().
    std::optional<std::size_t> find(const Index3& sample) const { return slab().find(sample); }
    /// The distance of a sample of the grid's bricks; its index counts on the lattice. A sample of the field has
    /// the distance that a dense field has, bit for bit.
    float distance_at(const Index3& sample) const;

    // The values of each output: distance(), triangle(), site(), closest(), gradient(), barycentric(), offset().
#define CLSDF_VALUES(name, description, element, components, number)    \
    const std::span<detail::element> name() {                           \
        return detail::values_in<detail::element>(bytes(Output::name)); \
    }                                                                   \
    std::span<const detail::element> name() const {                     \
        return values().name();                                         \
    }
    CLSDF_VALUES(distance, , float32, 1, 0)
    CLSDF_OUTPUTS(CLSDF_VALUES)
#undef CLSDF_VALUES

private:
    std::array<FieldArray<std::byte>, detail::most_outputs> arrays_;
};

/// The bricks that overlap the grid, as a block of the lattice: the grid rounded out to multiples of 8.
CLSDF_EXPORT Grid in_whole_bricks(const Grid& grid);

}  // namespace clsdf
