#pragma once

#include <filesystem>
#include <string>

namespace clsdf::test {

/// Whether the command's large arrays may lie in files: not in builds with sanitizers.
#ifdef CLSDF_WITHOUT_SCRATCH
inline constexpr bool has_scratch = false;
#else
inline constexpr bool has_scratch = true;
#endif

/// Beside the program: a folder for temporary files may be in memory, and is refused.
class ScratchFolder {
public:
    explicit ScratchFolder(const char* name) : path(std::filesystem::absolute(name).string()) {
        std::filesystem::create_directory(path);
    }
    ~ScratchFolder() { std::filesystem::remove_all(path); }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    bool is_empty() const { return std::filesystem::is_empty(path); }

    const std::string path;
};

}  // namespace clsdf::test
