#pragma once

#include "support/temporary_folder.hpp"

#include <clsdf/field.hpp>

#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <ranges>
#include <span>
#include <string>
#include <vector>

namespace clsdf::test {

/// The properties that the files of an ending can store.
struct Format {
    std::string ending;
    bool is_described = true;    ///< lattice, band, sign rule and mesh name
    bool has_extras = true;      ///< other outputs than the distance
    bool extras_beside = false;  ///< in files of their own
    bool any_spacing = true;     ///< unequal spacing, and of any size
};

inline const std::vector<Format>& all_formats() {
    static const std::vector<Format> formats {
        {.ending = ".nrrd", .extras_beside = true}, {.ending = ".npy", .extras_beside = true}, {.ending = ".vti"},
            {.ending = ".vtkhdf"}, {.ending = ".h5"}, {.ending = ".nvdb", .has_extras = false},
#if CLSDF_WITH_OPENVDB
            {.ending = ".vdb", .any_spacing = false},
#endif
            {.ending = ".sdf", .is_described = false, .has_extras = false, .any_spacing = false},
    };
    return formats;
}

/// The distance and, if the format has a place for it, the triangle.
inline OutputSet outputs_of(const Format& format) {
    return format.has_extras ? Output::distance | Output::triangle : Output::distance;
}

/// A part of a grid whose numbers are no short decimals, with values that text and careless copies lose; as far as the
/// format has a place for them.
inline Field example_field(const Format& format = all_formats().front()) {
    FieldDescription description;
    description.grid =
        Grid{{0.1, -1e9 / 3, 1e-5}, {0.1, 1.0 / 3, 1e-20}, {20, 30, 40}, {-3, 4, 5}}.part({5, 6, 7}, {4, 3, 2});
    if (!format.any_spacing) description.grid.spacing.fill(1.0 / 3);
    description.band = {0, std::numeric_limits<double>::infinity()};
    description.sign = SignRule::nonzero;
    description.mesh_name = "a \"mesh\" of\n two\\lines & <more>";
    Field field(description, outputs_of(format));
    for (std::uint32_t i = 0; i < field.grid.sample_count(); ++i) {
        field.distance()[i] = 0.1F * static_cast<float>(i);
        if (format.has_extras) field.triangle()[i] = i * i;
    }
    field.distance()[3] = -0.0F;
    field.distance()[4] = std::numeric_limits<float>::denorm_min();
    field.distance()[5] = std::numeric_limits<float>::infinity();
    if (format.has_extras) field.triangle()[6] = no_triangle;
    return field;
}

/// The example on a grid of 64 samples on a side.
inline Field large_field(const Format& format) {
    FieldDescription description = example_field(format);
    description.grid.size = {64, 64, 64};
    Field field(description, outputs_of(format));
    for (std::uint32_t i = 0; i < field.distance().size(); ++i) {
        const std::uint32_t scattered = i * 2654435761U;
        field.distance()[i] = static_cast<float>(scattered >> 8);
        if (format.has_extras) field.triangle()[i] = scattered;
    }
    return field;
}

/// Takes the last value of an output away: then its array does not fit the grid.
inline void shorten(Field& field, Output output) {
    field.resize(output, field.grid.sample_count() - 1);
}

/// Bit by bit, so that -0.0 is not 0.0.
inline bool same_bits(std::span<const float> one, std::span<const float> other) {
    return one.size() == other.size() && std::memcmp(one.data(), other.data(), one.size() * sizeof(float)) == 0;
}

/// Runs a statement that holds for every format that can do something, each in a folder of its own.
inline void for_each_format(bool Format::*ability,
                            const std::function<void(const TemporaryFolder& folder, const Format& format)>& statement) {
    for (const Format& format : all_formats()) {
        if (ability != nullptr && !(format.*ability)) continue;
        const TemporaryFolder folder;
        BOOST_TEST_CONTEXT("format " << format.ending) {
            statement(folder, format);
        }
    }
}

inline void for_each_format(const std::function<void(const TemporaryFolder& folder, const Format& format)>& statement) {
    for_each_format(nullptr, statement);
}

/// Names and contents of all files.
inline std::map<std::string, std::string> all_contents(const TemporaryFolder& folder) {
    std::map<std::string, std::string> contents;
    for (const auto& entry : std::filesystem::directory_iterator(folder.file("")))
        contents[entry.path().filename().string()] = content_of(entry.path().string());
    return contents;
}

/// The text with the first `from` replaced.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t position = text.find(from);
    BOOST_REQUIRE_MESSAGE(position != std::string::npos, "no '" << from << "'");
    return text.replace(position, from.size(), to);
}

/// The bytes of the values in the order asked for.
template <std::ranges::contiguous_range Array>
std::string bytes_of(const Array& values, std::endian order) {
    using Value = std::ranges::range_value_t<Array>;
    std::string bytes;
    for (const Value value : values) {
        std::string one(sizeof(Value), '\0');
        std::memcpy(one.data(), &value, sizeof(Value));
        bytes += order == std::endian::native ? one : std::string(one.rbegin(), one.rend());
    }
    return bytes;
}

}  // namespace clsdf::test
