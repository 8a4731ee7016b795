#include "io/meshes/raw_values.hpp"

#include "core/files.hpp"
#include "core/real_numbers.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <fcntl.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <limits>
#include <system_error>

namespace clsdf {
namespace {

static_assert(std::numeric_limits<float>::is_iec559 && std::numeric_limits<double>::is_iec559);

constexpr std::size_t chunk = std::size_t{1} << 16;  // values converted at a time

void swap_bytes(std::span<std::byte> bytes, std::size_t width) {
    for (std::size_t begin = 0; begin < bytes.size(); begin += width)
        std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(begin),
                     bytes.begin() + static_cast<std::ptrdiff_t>(begin + width));
}

}  // namespace

InputFile::InputFile(std::string path) : path_(std::move(path)) {
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(path_, error);
    if (status.type() == std::filesystem::file_type::not_found) fail("there is no such file");
    if (error) fail(error.message());
    if (!std::filesystem::is_regular_file(status)) fail("not a regular file; its size must be known before it is read");
    size_ = std::filesystem::file_size(path_, error);
    if (error) fail(error.message());
    const int descriptor = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) fail(std::generic_category().message(errno));
    file_ = std::make_unique<Descriptor>(descriptor);
}

void InputFile::read(std::uint64_t offset, std::span<std::byte> bytes) {
    const ReadResult result = read_in_parallel(*file_, offset, bytes);
    if (result.error != 0) fail(std::generic_category().message(result.error));
    if (result.bytes != bytes.size())
        fail(fmt::format("{} bytes from byte {} on cannot be read; the file has {}", bytes.size(), offset, size_));
}

std::string InputFile::beginning(std::size_t limit) {
    std::string text(static_cast<std::size_t>(std::min<std::uint64_t>(limit, size_)), '\0');
    read(0, std::as_writable_bytes(std::span(text)));
    return text;
}

void InputFile::fail(const std::string& what) const {
    throw Error(ErrorCode::unreadable_input, fmt::format("{}: {}", path_, what));
}

RawValues values_to_the_end(const InputFile& file, ElementType type, std::endian order, std::uint64_t offset) {
    return {type, order, offset, file.size() - std::min(file.size(), offset)};
}

std::size_t checked_count(const InputFile& file, const RawValues& values, std::span<const std::int64_t> sizes) {
    if (values.offset > file.size() || values.bytes > file.size() - values.offset)
        file.fail(
            fmt::format("{} bytes of values from byte {} on do not lie in the {} bytes of the file, which is "
                        "truncated, or its header is wrong",
                        values.bytes, values.offset, file.size()));
    return checked_count_of(file, values, sizes);
}

std::size_t checked_count_of(const InputFile& file, const RawValues& values, std::span<const std::int64_t> sizes) {
    const std::uint64_t width = bytes_of(values.type);
    std::uint64_t count = 1;
    for (const std::int64_t size : sizes) {
        if (size < 1)
            file.fail(fmt::format("sizes: {} is not a number of samples; each axis has at least one",
                                  fmt::join(sizes, " x ")));
        const auto factor = static_cast<std::uint64_t>(size);
        if (count > values.bytes / width / factor)
            file.fail(
                fmt::format("sizes: {} values of {} bytes do not fit the {} bytes after the header; the file is "
                            "truncated, or its header is wrong",
                            fmt::join(sizes, " x "), width, values.bytes));
        count *= factor;
    }
    if (count * width != values.bytes)
        file.fail(
            fmt::format("sizes: {} values of {} bytes leave {} of the {} bytes after the header unused; the "
                        "header is wrong",
                        fmt::join(sizes, " x "), width, values.bytes - count * width, values.bytes));
    return static_cast<std::size_t>(count);
}

bool reads_as(ElementType stored, ElementType wanted) {
    return stored == wanted || (stored == ElementType::float64 && wanted == ElementType::float32);
}

void convert_values(std::span<std::byte> bytes, const RawValues& values, ElementType wanted,
                    std::span<std::byte> room) {
    if (values.order != std::endian::native) swap_bytes(bytes, bytes_of(values.type));
    if (values.type == wanted) {
        std::ranges::copy(bytes, room.begin());
        return;
    }
    for (std::size_t i = 0; i < room.size() / sizeof(float); ++i) {
        double value = 0;
        std::memcpy(&value, bytes.data() + i * sizeof(double), sizeof(double));
        const auto rounded = static_cast<float>(value);
        std::memcpy(room.data() + i * sizeof(float), &rounded, sizeof(float));
    }
}

void read_values(InputFile& file, const RawValues& values, ElementType wanted, std::span<std::byte> room) {
    if (values.type == wanted) {
        file.read(values.offset, room);
        if (values.order != std::endian::native) swap_bytes(room, bytes_of(wanted));
        return;
    }
    const std::size_t width = bytes_of(values.type), wanted_width = bytes_of(wanted);
    const std::size_t count = room.size() / wanted_width;
    std::vector<std::byte> buffer(std::min(chunk, count) * width);
    for (std::size_t begin = 0; begin < count; begin += chunk) {
        const std::size_t part = std::min(chunk, count - begin);
        const auto bytes = std::span(buffer).first(part * width);
        file.read(values.offset + begin * width, bytes);
        convert_values(bytes, values, wanted, room.subspan(begin * wanted_width, part * wanted_width));
    }
}

void read_output(InputFile& file, const RawValues& values, const OutputInfo& info, Field& field) {
    read_values(file, values, info.type, allocate_output(info, field));
}

void write_little_endian(AtomicFile& file, std::span<const std::byte> bytes, std::size_t width) {
    if constexpr (std::endian::native == std::endian::little) {
        file.write(bytes);
    } else {
        std::vector<std::byte> swapped;
        for (std::size_t begin = 0; begin < bytes.size(); begin += chunk * width) {
            const auto part = bytes.subspan(begin, std::min(chunk * width, bytes.size() - begin));
            swapped.assign(part.begin(), part.end());
            swap_bytes(swapped, width);
            file.write(swapped);
        }
    }
}

namespace {

constexpr std::string_view blanks = " \t\r\n";

template <class Number>
bool parse_all(std::string_view text, std::span<Number> numbers) {
    for (Number& number : numbers) {
        text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
        const auto [stop, error] = read_number(text.data(), text.data() + text.size(), number);
        if (error != std::errc()) return false;
        text.remove_prefix(static_cast<std::size_t>(stop - text.data()));
        if (!text.empty() && blanks.find(text.front()) == std::string_view::npos) return false;
    }
    return text.find_first_not_of(blanks) == std::string_view::npos;
}

}  // namespace

bool parse_numbers(std::string_view text, std::span<double> numbers) {
    return parse_all(text, numbers);
}

bool parse_numbers(std::string_view text, std::span<std::int64_t> numbers) {
    return parse_all(text, numbers);
}

}  // namespace clsdf
