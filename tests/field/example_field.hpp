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
#include <string>
#include <vector>

namespace clsdf::test {

/// What a file of this ending has a place for.
struct Abilities {
    std::string ending;
    bool extras_beside = false;  ///< other outputs are in files of their own
};

inline const std::vector<Abilities>& all_formats() {
    static const std::vector<Abilities> formats{{".nrrd", true}, {".npy", true}};
    return formats;
}

/// A part of a grid whose numbers are no short decimals, with values that text and careless copies lose; as far as the
/// format has a place for them.
inline Field example_field([[maybe_unused]] const std::string& ending = ".nrrd") {
    Field field;
    field.grid =
        Grid{{0.1, -1e9 / 3, 1e-5}, {0.1, 1.0 / 3, 1e-20}, {20, 30, 40}, {-3, 4, 5}}.part({5, 6, 7}, {4, 3, 2});
    field.band = {0, std::numeric_limits<double>::infinity()};
    field.sign = SignRule::nonzero;
    field.mesh_name = "a \"mesh\" of\n two\\lines";
    for (std::uint32_t i = 0; i < field.grid.sample_count(); ++i) {
        field.distance.push_back(0.1F * static_cast<float>(i));
        field.triangle.push_back(i * i);
    }
    field.distance[3] = -0.0F;
    field.distance[4] = std::numeric_limits<float>::denorm_min();
    field.distance[5] = std::numeric_limits<float>::infinity();
    field.triangle[6] = no_triangle;
    return field;
}

/// Bit by bit, so that -0.0 is not 0.0.
inline bool same_bits(const std::vector<float>& one, const std::vector<float>& other) {
    return one.size() == other.size() && std::memcmp(one.data(), other.data(), one.size() * sizeof(float)) == 0;
}

/// Runs a statement that holds for every format, each in a folder of its own.
inline void for_each_format(
    const std::function<void(const TemporaryFolder& folder, const std::string& ending)>& statement) {
    for (const Abilities& format : all_formats()) {
        const TemporaryFolder folder;
        BOOST_TEST_CONTEXT("format " << format.ending) {
            statement(folder, format.ending);
        }
    }
}

/// Names and contents of all files.
inline std::map<std::string, std::string> all_contents(const TemporaryFolder& folder) {
    std::map<std::string, std::string> contents;
    for (const auto& entry : std::filesystem::directory_iterator(folder.file("")))
        contents[entry.path().filename().string()] = content_of(entry.path().string());
    return contents;
}

/// The bytes of the values in the order asked for.
template <class Value>
std::string bytes_of(const std::vector<Value>& values, std::endian order) {
    std::string bytes;
    for (const Value value : values) {
        std::string one(sizeof(Value), '\0');
        std::memcpy(one.data(), &value, sizeof(Value));
        bytes += order == std::endian::native ? one : std::string(one.rbegin(), one.rend());
    }
    return bytes;
}

}  // namespace clsdf::test
