#include "device/program_cache.hpp"

#include "core/atomic_file.hpp"
#include "device/build_records.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>

namespace clsdf::device {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view ending = ".program";

// A file is: the mark, the sizes and a check sum of what follows, the key, the binary. The key is kept in full, because
// two keys may have one name.
constexpr std::string_view mark = "clsdf program 1\n";

struct Header {
    std::uint64_t key_size;
    std::uint64_t binary_size;
    std::uint64_t check_sum;
};

std::optional<ProgramCache::Binary> parse(std::string_view content, std::string_view key) {
    if (!content.starts_with(mark)) return std::nullopt;
    content.remove_prefix(mark.size());
    Header header{};
    if (content.size() < sizeof header) return std::nullopt;
    std::memcpy(&header, content.data(), sizeof header);
    content.remove_prefix(sizeof header);
    if (header.key_size != key.size() || content.size() < key.size() ||
        header.binary_size != content.size() - key.size() || header.check_sum != hash_of(content) ||
        !content.starts_with(key))
        return std::nullopt;
    content.remove_prefix(key.size());
    return ProgramCache::Binary(content.begin(), content.end());
}

/// The time of the last use is that of the last change; once a day is often enough.
void note_use(const fs::path& path) {
    std::error_code ignored;
    const auto now = fs::file_time_type::clock::now();
    if (now - fs::last_write_time(path, ignored) > std::chrono::hours(24)) fs::last_write_time(path, now, ignored);
}

struct StoredFile {
    fs::path path;
    std::uintmax_t size;
    fs::file_time_type used;
};

}  // namespace

fs::path ProgramCache::path_of(const std::string& key) const {
    return folder_ / fmt::format("{:016x}{}", hash_of(key), ending);
}

std::optional<ProgramCache::Binary> ProgramCache::find(const std::string& key) const noexcept {
    if (folder_.empty()) return std::nullopt;
    try {
        const fs::path path = path_of(key);
        if (!is_trusted_file(path) || fs::file_size(path) > limit_) return std::nullopt;
        std::ifstream file(path, std::ios::binary);
        const std::string content((std::istreambuf_iterator<char>(file)), {});
        std::optional<Binary> binary = parse(content, key);
        if (binary) note_use(path);
        return binary;
    } catch (const std::exception&) {
        return std::nullopt;
    }
}

void ProgramCache::store(const std::string& key, std::span<const unsigned char> binary) const noexcept {
    if (folder_.empty() || binary.empty()) return;
    try {
        if (fs::create_directories(folder_)) fs::permissions(folder_, fs::perms::owner_all);
        std::string content = key;
        content.append(reinterpret_cast<const char*>(binary.data()), binary.size());
        const Header header{key.size(), binary.size(), hash_of(content)};
        const fs::path path = path_of(key);
        AtomicFile file(path.string());
        file.write(mark);
        file.write(std::as_bytes(std::span(&header, 1)));
        file.write(content);
        file.commit();
        prune(path);
    } catch (const std::exception&) {
        // Write-protected, full or gone: the next run compiles again.
    }
}

void ProgramCache::prune(const fs::path& newest) const {
    std::error_code ignored;
    std::vector<StoredFile> files;
    std::uintmax_t total = 0;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
        const fs::path& path = entry.path();
        const fs::file_time_type used = entry.last_write_time(ignored);
        std::error_code gone;
        const std::uintmax_t size = entry.file_size(gone);
        if (gone || path.extension() != ending) continue;
        files.push_back({path, size, used});
        total += size;
    }
    std::sort(files.begin(), files.end(),
              [](const StoredFile& one, const StoredFile& other) { return one.used < other.used; });
    for (const StoredFile& file : files) {
        if (total <= limit_) break;
        if (file.path == newest) continue;
        fs::remove(file.path, ignored);
        total -= file.size;
    }
}

fs::path default_cache_folder(bool driver_keeps_programs) {
    if (const char* folder = std::getenv("CLSDF_CACHE_DIR")) {
        // A relative one would be another whenever the program goes to another folder.
        std::error_code error;
        const fs::path path = *folder == 0 ? fs::path() : fs::absolute(folder, error);
        return error ? fs::path() : path;
    }
    if (driver_keeps_programs) return {};
    // A relative path is to be ignored (XDG Base Directory Specification).
    if (const char* base = std::getenv("XDG_CACHE_HOME"); base != nullptr && fs::path(base).is_absolute())
        return fs::path(base) / "clsdf";
    if (const char* home = std::getenv("HOME"); home != nullptr && fs::path(home).is_absolute())
        return fs::path(home) / ".cache" / "clsdf";
    return {};
}

}  // namespace clsdf::device
