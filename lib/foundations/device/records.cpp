#include "device/records.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <cerrno>
#include <charconv>
#include <fstream>
#include <iterator>
#include <random>
#include <system_error>

namespace clsdf::device {

namespace {

namespace fs = std::filesystem;

// A file is: the mark, the check sum of what follows and the size of the key in a line of hexadecimal digits, the key,
// the content.
constexpr std::string_view mark = "clsdf 1 ";
constexpr std::size_t digits = 16;

std::string file_of(std::string_view key, std::string_view content) {
    const std::string body = fmt::format("{:016x}\n{}{}", key.size(), key, content);
    return fmt::format("{}{:016x} {}", mark, hash_of(body), body);
}

struct Record {
    std::string key;
    std::string content;
};

/// Nothing if the file is damaged, or none.
std::optional<Record> read(const fs::path& path) {
    if (!fs::is_regular_file(path)) return std::nullopt;
    std::ifstream stream(path, std::ios::binary);
    const std::string file{std::istreambuf_iterator<char>(stream), {}};
    constexpr std::size_t size_at = mark.size() + digits + 1, key_at = size_at + digits + 1;
    if (file.size() < key_at) return std::nullopt;
    std::size_t key_size = 0;
    std::from_chars(file.data() + size_at, file.data() + size_at + digits, key_size, 16);
    if (key_size > file.size() - key_at) return std::nullopt;
    Record record{file.substr(key_at, key_size), file.substr(key_at + key_size)};
    if (file_of(record.key, record.content) != file) return std::nullopt;
    return record;
}

}  // namespace

std::uint64_t hash_of(std::string_view bytes) {
    std::uint64_t hash = 0xCBF29CE484222325U;
    for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001B3U;
    return hash;
}

fs::path Records::path_of(const std::string& key) const {
    return folder_ / fmt::format("{:016x}{}", hash_of(key), ending_);
}

std::optional<std::string> Records::find(const std::string& key) const noexcept {
    if (folder_.empty()) return std::nullopt;
    try {
        // Two keys may share a name.
        if (std::optional<Record> record = read(path_of(key)); record && record->key == key)
            return std::move(record->content);
    } catch (const std::exception&) {
        // As good as none.
    }
    return std::nullopt;
}

void Records::store(const std::string& key, std::string_view content) const {
    if (folder_.empty()) return;
    const fs::path path = path_of(key);
    const auto fail = [&](std::error_code error) {
        throw Error(ErrorCode::output_failure, fmt::format("cannot write '{}': {}", path.string(), error.message()));
    };
    std::error_code error;
    if (fs::create_directories(folder_, error); error) fail(error);
    // Another process, also one on another machine, may write the same file.
    std::random_device random;
    const fs::path unfinished = fmt::format("{}.{:08x}{:08x}", path.string(), random(), random());
    errno = 0;
    std::ofstream stream(unfinished, std::ios::binary);
    stream << file_of(key, content);
    stream.close();
    if (!stream) error = std::error_code(errno != 0 ? errno : EIO, std::generic_category());
    if (!error) fs::rename(unfinished, path, error);
    if (!error) return;
    std::error_code ignored;
    fs::remove(unfinished, ignored);
    fail(error);
}

void Records::note(const std::string& key) const noexcept {
    try {
        store(key, {});
    } catch (const std::exception&) {
        // Write-protected or full.
    }
}

void Records::forget(std::string_view begin_of_key) const noexcept {
    if (folder_.empty()) return;
    try {
        for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
            if (entry.path().extension() != ending_) continue;
            const std::optional<Record> record = read(entry.path());
            std::error_code ignored;
            if (record && record->key.starts_with(begin_of_key)) fs::remove(entry.path(), ignored);
        }
    } catch (const std::exception&) {
        // No folder.
    }
}

}  // namespace clsdf::device
