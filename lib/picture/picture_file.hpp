#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

namespace clsdf::picture {

/// The path's ending in lower case, e.g. ".png". Throws Error(unsupported) if it is none of `endings`.
std::string ending_of(const std::string& path, std::initializer_list<std::string_view> endings);

/// Throws Error(output_failure) if no file can be written there. Leaves nothing behind.
void check_writable(const std::string& path);

/// Complete, or not at all. Throws Error(output_failure).
void write_file(const std::string& path, const std::string& bytes);

}  // namespace clsdf::picture
