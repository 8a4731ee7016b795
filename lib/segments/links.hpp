#pragma once

#include "segments/sample_box.hpp"
#include "tree/wide_tree.hpp"

#include <clsdf/segments.hpp>
#include <clsdf/topology.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace clsdf::segments {

/// What links are made of.
struct LinkInputs {
    engine::CrossedFaces faces;
    const engine::WideTree* tree;  ///< of a mesh whose open edges count; else null
    SignRule rule;
    /// Called between stages with the fraction done; may be empty, and may throw.
    std::function<void(double)> between;
};

/// Both ends of a link are inside, with space between them: of LinkChoice::with_gaps alone.
inline constexpr auto gap_flag = static_cast<SegmentFlag>(4);

/// Which links get rows beside those whose ends have different sides.
struct LinkChoice {
    Hits hits = Hits::walls;
    bool with_between = false;  ///< of both ends outside, with walls
    bool with_gaps = false;     ///< of both ends inside, with walls
};

/// Throws Error(wrong_results): such a link has a wall.
[[noreturn]] void refuse_link(const std::array<std::int32_t, 3>& sample, std::size_t direction);

/// Checks directions: at most 32, components up to 16, none twice. Throws Error(invalid_argument).
void check_directions(std::span<const LinkDirection> directions);
/// The most that components of the directions are, on each axis.
Place margin_of(std::span<const LinkDirection> directions);

/// The links of a grid. Sample numbers count on the lattice. Throws Error(invalid_argument) for a grid and
/// Error(unsupported) for a mesh with coordinates that are out of range.
Links find_links(const LinkInputs& inputs, const Grid& grid, std::span<const LinkDirection> directions,
                 const LinkChoice& choice);
/// Their number.
std::size_t count_links(const LinkInputs& inputs, const Grid& grid, std::span<const LinkDirection> directions,
                        const LinkChoice& choice);

}  // namespace clsdf::segments
