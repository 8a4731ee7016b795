#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace clsdf {

/// A text from a file for a message: in quotes, cut after `limit` bytes, with '?' for each byte that is a control
/// character or not ASCII. (A NUL would end the message.)
std::string quoted(std::string_view text, std::size_t limit = 40);

}  // namespace clsdf
