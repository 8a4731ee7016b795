#pragma once

#include "segments/links.hpp"

#include <clsdf/segments.hpp>

namespace clsdf::segments {

/// Of the edges of a grid. Throws as find_links().
Crossings find_crossings(const LinkInputs& inputs, const Grid& grid, bool with_counts);

}  // namespace clsdf::segments
