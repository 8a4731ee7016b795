#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace clsdf::device {

/// FNV-1a (Fowler, Noll, Vo) of 64 bits.
std::uint64_t hash_of(std::string_view bytes);

/// Files in a folder, one for each key. A file holds its key, a content and a check sum: a file that cannot be read, is
/// damaged or has another key counts as missing. Keys are texts of a few lines. Any number of threads and processes
/// may use one folder: a file gets its name when it is complete.
class Records {
public:
    /// `ending` of the files' names, with its point. An empty folder keeps nothing. The folder is made when the first
    /// file is written.
    Records(std::filesystem::path folder, std::string_view ending) : folder_(std::move(folder)), ending_(ending) {}

    const std::filesystem::path& folder() const { return folder_; }

    /// The content that was stored under the very same key.
    std::optional<std::string> find(const std::string& key) const noexcept;
    /// Replaces what was stored under the key. Throws Error(output_failure).
    void store(const std::string& key, std::string_view content) const;

    bool has(const std::string& key) const noexcept { return find(key).has_value(); }
    /// Stores an empty content. If it cannot be written, nothing is kept.
    void note(const std::string& key) const noexcept;
    /// Deletes all files whose key begins like that.
    void forget(std::string_view begin_of_key) const noexcept;

private:
    std::filesystem::path path_of(const std::string& key) const;

    std::filesystem::path folder_;
    std::string_view ending_;
};

}  // namespace clsdf::device
