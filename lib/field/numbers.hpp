#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace clsdf {

/// Numbers between blanks. Returns false where one is malformed or the count differs.
bool parse_numbers(std::string_view text, std::span<double> numbers);
bool parse_numbers(std::string_view text, std::span<std::int64_t> numbers);

}  // namespace clsdf
