#pragma once

#include "errors.hpp"

#include <clsdf.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>

/// What the caller gives, checked: pointers, numbers, and structs that begin with their size.
namespace clsdf::c {

/// Throws Error(invalid_argument) for null.
template <typename Value>
Value& given(Value* pointer, const char* name) {
    if (pointer == nullptr) throw misuse(std::string(name) + " is null; give its address");
    return *pointer;
}

/// A count, as the library has it.
inline std::size_t count_of(std::int64_t count, const char* name) {
    if (count < 0) throw misuse(std::string(name) + " is " + std::to_string(count) + "; a count is 0 or more");
    return static_cast<std::size_t>(count);
}

/// An array of `count` elements; null is allowed for none.
template <typename Value>
Value* elements(Value* first, std::int64_t count, const char* name) {
    if (count_of(count, name) > 0 && first == nullptr)
        throw misuse(std::string(name) + " is null, with a count of " + std::to_string(count) + "; give its address");
    return first;
}

/// An enumerator with a number from 0 to `last`.
template <typename Enum>
Enum enumerator(std::int32_t number, Enum last, const char* name) {
    if (number < 0 || number > static_cast<std::int32_t>(last))
        throw misuse(std::string(name) + " is " + std::to_string(number) + "; its numbers are 0 to " +
                     std::to_string(static_cast<std::int32_t>(last)));
    return static_cast<Enum>(number);
}

inline bool flag(std::int32_t value, const char* name) {
    if (value != 0 && value != 1) throw misuse(std::string(name) + " is " + std::to_string(value) + "; give 0 or 1");
    return value == 1;
}

inline void check_reserved(std::int32_t value, const char* name) {
    if (value != 0)
        throw misuse(std::string(name) + ".reserved is " + std::to_string(value) +
                     "; it must be 0: set the struct with zeros or its _INIT macro first");
}

/// Structs that calls only fill. Their struct_size is CLSDF_RESULT_SIZE.
template <typename Struct>
inline constexpr bool is_result =
    std::is_same_v<Struct, clsdf_output_info> || std::is_same_v<Struct, clsdf_device_info> ||
    std::is_same_v<Struct, clsdf_topology> || std::is_same_v<Struct, clsdf_defects> ||
    std::is_same_v<Struct, clsdf_weld_report> || std::is_same_v<Struct, clsdf_outer_report> ||
    std::is_same_v<Struct, clsdf_statistics> || std::is_same_v<Struct, clsdf_kept_memory>;

template <typename Struct>
std::size_t checked_size(const Struct* given_struct, const char* name) {
    std::size_t stated = 0;
    std::memcpy(&stated, given_struct, sizeof stated);
    const std::size_t size = stated & ~std::size_t{1};
    if (size < 2 * sizeof size || size > 4096 || size % sizeof size != 0)
        throw misuse(std::string(name) + ".struct_size is " + std::to_string(stated) +
                     ", which no version has; set the struct with its _INIT macro");
    if ((stated != size) != is_result<Struct>)
        throw misuse(std::string(name) + ".struct_size is " + std::to_string(stated) +
                     ", that of a struct that calls " + (is_result<Struct> ? "read" : "fill") +
                     "; arguments end with the options and then the statistics of the call, and each struct is set "
                     "with its own _INIT macro");
    return size;
}

/// The members that the caller's version of the struct has; the others as in `initial`, which is its _INIT. Null: all.
template <typename Struct>
Struct read_struct(const Struct* from, const Struct& initial, const char* name) {
    Struct result = initial;
    if (from == nullptr) return result;
    const std::size_t size = checked_size(from, name);
    std::memcpy(&result, from, std::min(size, sizeof(Struct)));
    result.struct_size = sizeof(Struct);
    const auto* bytes = reinterpret_cast<const unsigned char*>(from);
    for (std::size_t i = sizeof(Struct); i < size; ++i)
        if (bytes[i] != 0)
            throw misuse(std::string(name) + " has " + std::to_string(size) + " bytes, and byte " + std::to_string(i) +
                         " is not 0; this version knows " + std::to_string(sizeof(Struct)) +
                         " bytes: leave members of later versions at 0");
    return result;
}

/// The same for a struct that must be there.
template <typename Struct>
Struct read_given(const Struct* from, const Struct& initial, const char* name) {
    return read_struct(&given(from, name), initial, name);
}

/// Throws what write_struct() would throw: before a call that takes long.
template <typename Struct>
void check_result(const Struct* to, const char* name) {
    if (to != nullptr) checked_size(to, name);
}

/// Sets the members that the caller's version of the struct has, and what this version does not know to 0. Null: none.
template <typename Struct>
void write_struct(const Struct& from, Struct* to, const char* name) {
    if (to == nullptr) return;
    const std::size_t size = checked_size(to, name);
    const std::size_t own = sizeof(std::size_t), known = std::min(size, sizeof(Struct));
    auto* bytes = reinterpret_cast<unsigned char*>(to);
    std::memcpy(bytes + own, reinterpret_cast<const unsigned char*>(&from) + own, known - own);
    std::fill(bytes + known, bytes + size, static_cast<unsigned char>(0));
}

/// The same for a result that must be there.
template <typename Struct>
void write_given(const Struct& from, Struct* to, const char* name) {
    write_struct(from, &given(to, name), name);
}

/// A text that must be there.
inline std::string text_of(const char* text, const char* name) {
    if (text == nullptr) throw misuse(std::string(name) + " is null; give a text");
    return text;
}
inline std::string text_or(const char* text, const char* otherwise) {
    return text != nullptr ? text : otherwise;
}

/// Writes a text to text[size], cut if it is too long, and its length.
inline void write_text(const std::string& from, char* text, std::int64_t size, std::int64_t* length) {
    elements(text, size, "text");
    if (size > 0) {
        const std::size_t kept = std::min(from.size(), static_cast<std::size_t>(size - 1));
        std::memcpy(text, from.data(), kept);
        text[kept] = 0;
    }
    if (length != nullptr) *length = static_cast<std::int64_t>(from.size());
}

}  // namespace clsdf::c
