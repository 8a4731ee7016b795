#include "field/hdf5_bytes.hpp"

#include <fmt/format.h>

namespace clsdf::hdf5 {

namespace {

// No part of the structure that a field needs is as large.
constexpr std::uint64_t largest_part = std::uint64_t{1} << 22;

}  // namespace

Bytes::Bytes(InputFile& file, std::uint64_t address, std::uint64_t size, const char* what) : file_(file), what_(what) {
    if (address > file.size() || size > file.size() - address)
        fail(fmt::format("{} bytes from byte {} on do not lie in the {} bytes of the file; it is truncated or damaged",
                         size, address, file.size()));
    if (size > largest_part) fail(fmt::format("{} bytes are more than any field has", size));
    content_.resize(static_cast<std::size_t>(size));
    file.read(address, std::as_writable_bytes(std::span(content_)));
    rest_ = content_;
}

std::string_view Bytes::take(std::uint64_t count) {
    if (count > rest_.size()) fail("it ends early; the file is damaged");
    const std::string_view taken = rest_.substr(0, static_cast<std::size_t>(count));
    rest_.remove_prefix(taken.size());
    return taken;
}

std::uint64_t Bytes::number(std::size_t width) {
    const std::string_view bytes = take(width);
    std::uint64_t value = 0;
    for (std::size_t i = width; i-- > 0;) value = value << 8U | static_cast<unsigned char>(bytes[i]);
    return value;
}

void Bytes::expect(std::string_view signature) {
    if (take(signature.size()) != signature)
        fail(fmt::format("it does not begin with '{}'; the file is damaged", signature));
}

void Bytes::expect(std::uint64_t number, std::size_t width, const char* name) {
    if (const std::uint64_t found = this->number(width); found != number)
        fail(fmt::format("its {} is {}, not {}; save the field with HDF5's default settings", name, found, number));
}

void Bytes::fail(const std::string& reason) const {
    file_.fail(fmt::format("HDF5: {}: {}", what_, reason));
}

}  // namespace clsdf::hdf5
