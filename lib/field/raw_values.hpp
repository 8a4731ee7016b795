#pragma once

#include "core/atomic_file.hpp"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <span>
#include <string>
#include <vector>

namespace clsdf {

/// A regular file that is read; every failure is an Error(unreadable_input) that starts with the file's name.
class InputFile {
public:
    explicit InputFile(std::string path);

    const std::string& path() const { return path_; }
    std::uint64_t size() const { return size_; }

    /// Throws where the file ends before.
    void read(std::uint64_t offset, std::span<std::byte> bytes);

    /// The first bytes, at most `limit`.
    std::string beginning(std::size_t limit);

    [[noreturn]] void fail(const std::string& what) const;

private:
    std::string path_;
    std::ifstream stream_;
    std::uint64_t size_ = 0;
};

enum class ValueType { float32, float64, uint32 };

/// Where the values of an array lie in a file, and how they are stored: from `offset` to the end of the file.
struct RawValues {
    ValueType type = ValueType::float32;
    std::endian order = std::endian::little;
    std::uint64_t offset = 0;
};

/// The number of samples of a block. Throws where the file does not hold just as many values; nothing is allocated
/// before.
std::size_t checked_count(const InputFile& file, const RawValues& values, std::span<const std::int64_t> sizes);

/// Doubles are rounded to float.
std::vector<float> read_floats(InputFile& file, const RawValues& values, std::size_t count);
std::vector<std::uint32_t> read_indices(InputFile& file, const RawValues& values, std::size_t count);

void write_little_endian(AtomicFile& file, std::span<const float> values);
void write_little_endian(AtomicFile& file, std::span<const std::uint32_t> values);

}  // namespace clsdf
