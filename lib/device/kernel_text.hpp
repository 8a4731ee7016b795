#pragma once

#include <string>
#include <string_view>

namespace clsdf::device {

/// The text of an embedded kernel file with its #include "..." lines replaced by the files they name, each once: OpenCL
/// compilers look for nothing at run time.
std::string kernel_text(std::string_view file_name);

}  // namespace clsdf::device
