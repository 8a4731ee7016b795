#pragma once

#include "frusta/cluster_index.hpp"
#include "layout.h"
#include "segments/sample_box.hpp"

#include <clsdf/grid.hpp>
#include <clsdf/topology.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::segments {

/// Writes the exact sides of all samples of a part's bricks as the sign bits that the kernels of fields read: rows of
/// layout.sign_words words, 1 inside. grid: of the part. near: see BoxSides. Throws as SampleBox() does.
void write_sign_bits(const engine::CrossedFaces& faces, SignRule rule, const Grid& grid, const Layout& layout,
                     const std::vector<engine::RecordRange>* near, std::span<std::uint32_t> words);

}  // namespace clsdf::segments
