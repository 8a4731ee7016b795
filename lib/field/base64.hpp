#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace clsdf {

/// The bytes of a text in base64 (RFC 4648), blanks between the letters; padded parts may follow one another. Null
/// where it is none.
std::optional<std::vector<std::byte>> decode_base64(std::string_view text);

}  // namespace clsdf
