#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace clsdf {

/// A regular file, whole in memory.
class FileContent {
public:
    /// Throws Error(unreadable_input) where the file cannot be read or is a folder, a pipe or a device.
    explicit FileContent(std::string path);

    const std::string& path() const { return path_; }
    std::size_t size() const { return size_; }
    std::string_view text() const { return {bytes_.get(), size_}; }
    std::span<const std::byte> bytes() const { return std::as_bytes(std::span(bytes_.get(), size_)); }

private:
    std::string path_;
    std::unique_ptr<char[]> bytes_;
    std::size_t size_ = 0;
};

}  // namespace clsdf
