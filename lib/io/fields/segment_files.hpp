#pragma once

#include <clsdf/arrays.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace clsdf {

/// An array of a file that has several. shape: slowest first.
struct FileArray {
    std::string name;
    ElementType type;
    std::vector<std::int64_t> shape;
    std::span<const std::byte> bytes;
};

/// numpy's archive: a zip file of .npy files, which are not compressed.
void write_npz(const std::string& path, std::span<const FileArray> arrays);
/// hdf5_write.cpp. description: of the attribute "clsdf".
void write_h5_arrays(const std::string& path, const std::string& description, std::span<const FileArray> arrays);

}  // namespace clsdf
