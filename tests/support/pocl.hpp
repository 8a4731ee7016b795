#pragma once

#include <link.h>
#include <filesystem>
#include <string_view>

namespace clsdf::test {

/// The file of the PoCL that this process has loaded; empty if there is none.
inline std::filesystem::path file_of_pocl() {
    std::filesystem::path file;
    dl_iterate_phdr(
        [](dl_phdr_info* info, std::size_t, void* found) {
            if (std::string_view(info->dlpi_name).find("/libpocl.so") != std::string_view::npos)
                *static_cast<std::filesystem::path*>(found) = info->dlpi_name;
            return 0;
        },
        &file);
    return file;
}

}  // namespace clsdf::test
