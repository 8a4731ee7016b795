#pragma once

#include "core/uninitialized_vector.hpp"

#include <cstddef>
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
    std::size_t size() const { return bytes_.size(); }
    std::string_view text() const { return {bytes_.data(), bytes_.size()}; }
    std::span<const std::byte> bytes() const { return std::as_bytes(std::span(bytes_)); }

private:
    std::string path_;
    UninitializedVector<char> bytes_;
};

}  // namespace clsdf
