#include "device/find/system_library.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>

namespace clsdf::device {

namespace {

namespace fs = std::filesystem;

/// The absolute entries of LD_LIBRARY_PATH. A program with more rights than its user has ignores it, as the loader
/// does.
std::vector<fs::path> folders_of_environment() {
    std::vector<fs::path> folders;
#if defined(__linux__)
    const char* const value = ::secure_getenv("LD_LIBRARY_PATH");
#else
    const char* const value = std::getenv("LD_LIBRARY_PATH");
#endif
    std::string_view rest = value == nullptr ? "" : value;
    while (!rest.empty()) {
        const std::size_t end = std::min(rest.find_first_of(":;"), rest.size());
        if (const fs::path folder = rest.substr(0, end); folder.is_absolute()) folders.push_back(folder);
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    return folders;
}

/// The files of this name in the cache of glibc's loader, which ldconfig writes (glibc, sysdeps/generic/dl-cache.h). A
/// cache of another form has none.
std::vector<fs::path> files_of_cache(const std::string& name) {
    struct Entry {
        std::int32_t flags;
        std::uint32_t key, value;  ///< offsets of the name and of the path from the beginning of the cache
        std::uint32_t version;
        std::uint64_t hardware;  ///< 0: for every processor
    };
    constexpr std::string_view mark = "glibc-ld.so.cache1.1";
    constexpr std::size_t head = 48;
    std::ifstream file("/etc/ld.so.cache", std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    // A cache of an older form may stand before.
    const std::string_view cache = std::string_view(bytes).substr(std::min(bytes.find(mark), bytes.size()));
    std::vector<fs::path> files;
    if (cache.size() < head) return files;
    const auto text_at = [&](std::uint32_t offset) {
        const std::string_view text = cache.substr(std::min<std::size_t>(offset, cache.size()));
        return text.substr(0, text.find('\0'));
    };
    std::uint32_t count = 0;
    std::memcpy(&count, cache.data() + mark.size(), sizeof count);
    count = static_cast<std::uint32_t>(std::min<std::size_t>(count, (cache.size() - head) / sizeof(Entry)));
    for (std::uint32_t n = 0; n < count; ++n) {
        Entry entry{};
        std::memcpy(&entry, cache.data() + head + n * sizeof entry, sizeof entry);
        if (entry.hardware == 0 && text_at(entry.key) == name) files.emplace_back(text_at(entry.value));
    }
    return files;
}

}  // namespace

std::vector<fs::path> system_libraries(const std::string& name) {
    std::vector<fs::path> files;
    const auto add = [&](const fs::path& file) {
        std::error_code none;
        if (file.is_absolute() && fs::exists(file, none) && std::ranges::find(files, file) == files.end())
            files.push_back(file);
    };
    for (const fs::path& folder : folders_of_environment()) add(folder / name);
    for (const fs::path& file : files_of_cache(name)) add(file);
    for (const char* folder : {"/lib/x86_64-linux-gnu", "/usr/lib/x86_64-linux-gnu", "/lib/aarch64-linux-gnu",
                               "/usr/lib/aarch64-linux-gnu", "/lib64", "/usr/lib64", "/lib", "/usr/lib"})
        add(fs::path(folder) / name);
    return files;
}

}  // namespace clsdf::device
