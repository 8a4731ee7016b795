#pragma once

#include <span>
#include <string>
#include <string_view>

namespace clsdf {

/// The candidate that is the fewest insertions, deletions and replacements of one character away from the text, the
/// first of several; empty where there is no candidate.
std::string nearest_name(std::string_view text, std::span<const std::string> candidates);

}  // namespace clsdf
