#pragma once

#include "targets/host_arrays.hpp"

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>

#include <cstdint>
#include <optional>

/// Fields of many bodies: the least of the bodies' fields, sample by sample.
namespace clsdf::scenes {

inline constexpr std::uint32_t no_body = 0xFFFFFFFFU;

/// The samples of a grid that lie in a box, or at most `margin` beside it, or farther by rounding; nothing if there are
/// none. A margin may be infinite.
std::optional<Grid> part_near(const Grid& grid, const Box& box, double margin);

/// The field of a grid as far as bodies have been added, in any order. A body is added with the samples that it
/// reaches: all that are inside it or within the half width outside. Elsewhere its value is that beyond the band.
class LeastField {
public:
    /// arrays: packed, of the grid. If there are other outputs than the distance, the body is one of them.
    LeastField(const Grid& grid, const targets::HostArrays& arrays) : grid_(grid), arrays_(arrays) {}

    /// Every sample is outside all bodies, beyond the band.
    void clear(double outside);
    /// The arrays already have the field of this one in a part of the grid, as a transform made it.
    void begin_with(const Grid& part, std::uint32_t body);
    /// values: of a block of the lattice, as the body's transform made them in the part of it that the body reaches,
    /// with the outputs and the elements of the arrays. Of equal distances the body that is within the band counts at
    /// the outer limit, that beyond it at the inner one; then the lowest body.
    void add(const Grid& part, const Grid& block, const targets::HostArrays& values, std::uint32_t body);

private:
    template <typename Distance>
    void add_row(std::size_t to, std::size_t from, std::size_t count, const targets::HostArrays& values,
                 std::uint32_t body);

    Grid grid_;
    targets::HostArrays arrays_;
};

}  // namespace clsdf::scenes
