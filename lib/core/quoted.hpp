#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace clsdf {

/// What stands in a file, as a message can show it: in quotes, cut after `limit` bytes, and '?' for each byte that is a
/// control character or no ASCII. A NUL would end the message.
std::string quoted(std::string_view text, std::size_t limit = 40);

}  // namespace clsdf
