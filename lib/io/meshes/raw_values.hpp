#pragma once

#include "core/files.hpp"
#include "core/outputs.hpp"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace clsdf {

/// A regular file that is read; every failure is an Error(unreadable_input) that starts with the file's name.
class InputFile {
public:
    explicit InputFile(std::string path);

    const std::string& path() const { return path_; }
    std::uint64_t size() const { return size_; }

    /// Throws if the file ends before. Much is read on all cores.
    void read(std::uint64_t offset, std::span<std::byte> bytes);

    /// The first bytes, at most `limit`.
    std::string beginning(std::size_t limit);

    [[noreturn]] void fail(const std::string& what) const;

private:
    std::string path_;
    std::unique_ptr<Descriptor> file_;
    std::uint64_t size_ = 0;
};

/// The offset, number and type of an array's values in a file.
struct RawValues {
    ElementType type = ElementType::float32;
    std::endian order = std::endian::little;
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;
};

/// From `offset` to the end of the file.
RawValues values_to_the_end(const InputFile& file, ElementType type, std::endian order, std::uint64_t offset);

/// The number of values of an array of these sizes. Throws if `values` has another number, or if they exceed the file.
/// Allocates nothing.
std::size_t checked_count(const InputFile& file, const RawValues& values, std::span<const std::int64_t> sizes);
/// The same of values that lie elsewhere.
std::size_t checked_count_of(const InputFile& file, const RawValues& values, std::span<const std::int64_t> sizes);

/// Whether values of one type are read as values of another: doubles are rounded to float, everything else stays.
bool reads_as(ElementType stored, ElementType wanted);

/// Reads values of type `wanted` until `room` is full, in this machine's byte order.
void read_values(InputFile& file, const RawValues& values, ElementType wanted, std::span<std::byte> room);
/// The same from values in memory, which are overwritten.
void convert_values(std::span<std::byte> bytes, const RawValues& values, ElementType wanted, std::span<std::byte> room);

/// Reads one output of the field, whose grid is known; the values have been counted, and their type fits.
void read_output(InputFile& file, const RawValues& values, const OutputInfo& info, Field& field);

/// Values of `width` bytes each.
void write_little_endian(AtomicFile& file, std::span<const std::byte> bytes, std::size_t width);

/// Numbers between blanks. Returns false if one is malformed or the count differs.
bool parse_numbers(std::string_view text, std::span<double> numbers);
bool parse_numbers(std::string_view text, std::span<std::int64_t> numbers);

}  // namespace clsdf
