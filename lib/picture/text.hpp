#pragma once

#include <cstddef>
#include <string>

namespace clsdf::picture {

/// The text with every byte that is not UTF-8 replaced; if it is longer than `characters`, its middle is left out.
std::string printable(const std::string& text, std::size_t characters);

/// The same in ASCII, for fonts without special signs: "−2 × 10⁻⁶" becomes "-2 x 10^-6", and other signs become
/// question marks. The text must be UTF-8.
std::string in_ascii(const std::string& text);

}  // namespace clsdf::picture
