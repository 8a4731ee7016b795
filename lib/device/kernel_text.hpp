#pragma once

#include <span>
#include <string>
#include <string_view>

namespace clsdf::device {

/// A kernel file that the build has embedded.
struct KernelFile {
    std::string_view name;
    std::string_view text;
};
using KernelFiles = std::span<const KernelFile>;

/// The text of an embedded kernel file, of the core or of `beside`, with its #include "..." lines replaced by the files
/// they name, each once: OpenCL compilers look for nothing at run time.
std::string kernel_text(std::string_view file_name, KernelFiles beside = {});

}  // namespace clsdf::device
