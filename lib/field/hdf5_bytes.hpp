#pragma once

#include "field/raw_values.hpp"

#include <cstdint>
#include <string>
#include <string_view>

namespace clsdf::hdf5 {

/// The address of what is not there.
constexpr std::uint64_t nowhere = ~std::uint64_t{0};

/// Bytes of an HDF5 file's structure, taken one after the other. Taking more than there are throws
/// Error(unreadable_input).
class Bytes {
public:
    /// From an address of the file on. `what` they are is for the message.
    Bytes(InputFile& file, std::uint64_t address, std::uint64_t size, const char* what);
    /// Bytes that have been read already, which must outlive this.
    Bytes(InputFile& file, std::string_view bytes, const char* what) : file_(file), rest_(bytes), what_(what) {}
    Bytes(const Bytes&) = delete;
    Bytes& operator=(const Bytes&) = delete;

    std::size_t left() const { return rest_.size(); }
    std::string_view take(std::uint64_t count);
    void skip(std::uint64_t count) { take(count); }
    /// A whole number of up to 8 bytes, the lowest first.
    std::uint64_t number(std::size_t width);
    /// Takes the letters that a part of the structure begins with.
    void expect(std::string_view signature);
    void expect(std::uint64_t number, std::size_t width, const char* name);

    [[noreturn]] void fail(const std::string& reason) const;

private:
    InputFile& file_;
    std::string content_;
    std::string_view rest_;
    const char* what_;
};

}  // namespace clsdf::hdf5
