// For tests alone: the arrays of an example, so that the same example in another language can be compared with it.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <span>

/// Appends the bytes of an array to the file that the environment variable CLSDF_EXAMPLE_ARRAYS names, if it is set.
template <typename Array>
void record(const Array& array) {
    const char* path = std::getenv("CLSDF_EXAMPLE_ARRAYS");
    if (path == nullptr) return;
    std::FILE* file = std::fopen(path, "ab");
    if (file == nullptr) std::abort();
    const auto bytes = std::as_bytes(std::span(array));
    if (std::fwrite(bytes.data(), 1, bytes.size(), file) != bytes.size()) std::abort();
    std::fclose(file);
}
