#pragma once

#include <cstddef>
#include <string>

namespace clsdf::picture {

/// The text with every byte that is not UTF-8 replaced, and its middle left out where it is longer than `characters`.
std::string printable(const std::string& text, std::size_t characters);

/// The same in ASCII alone, for letters that are poor in signs: "−2 × 10⁻⁶" becomes "-2 x 10^-6", and what has no such
/// form a question mark. The text must be UTF-8.
std::string in_ascii(const std::string& text);

}  // namespace clsdf::picture
