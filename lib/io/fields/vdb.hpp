#pragma once

#include "core/outputs.hpp"
#include "io/meshes/raw_values.hpp"

#include <string>

// OpenVDB's types must stay visible: its library looks them up in registries, although clsdf hides its own symbols.
#pragma GCC visibility push(default)
#include <openvdb/openvdb.h>
#pragma GCC visibility pop

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

// Included by the few files that include OpenVDB, whose headers take long to compile.

namespace clsdf::vdb {

/// The metadata that holds a field's description.
inline constexpr const char* description_key = "clsdf";

inline void initialise() {
    static const bool once = (openvdb::initialize(), true);
    static_cast<void>(once);
}

inline openvdb::Coord coordinates(const Index3& index) {
    return {static_cast<int>(index[0]), static_cast<int>(index[1]), static_cast<int>(index[2])};
}

/// Outputs of whole numbers are in an Int32Grid, those of up to three doubles in a Vec3DGrid, of floats in a Vec3SGrid.
/// Bytes are widened, and vectors of two components get a third one, which is 0. Beyond the band all bits are set, as
/// in the field.
inline std::size_t sample_bytes_in_grid(const OutputInfo& info) {
    return is_whole(info.type) ? sizeof(std::int32_t) : 3 * bytes_of(info.type);
}
inline bool fits_grid(const OutputInfo& info) {
    return is_whole(info.type) ? info.components == 1 : info.components == 2 || info.components == 3;
}

/// The samples of an output as its grid has them, into `room`.
inline void widen(const OutputInfo& info, std::span<const std::byte> values, std::span<std::byte> room) {
    const std::size_t from = info.sample_bytes(), to = sample_bytes_in_grid(info);
    for (std::size_t sample = 0; sample < values.size() / from; ++sample) {
        const auto one = values.subspan(sample * from, from);
        const bool is_left = std::all_of(one.begin(), one.end(), [](std::byte b) { return b == std::byte{0xFF}; });
        const auto wide = room.subspan(sample * to, to);
        std::fill(wide.begin(), wide.end(), is_left ? std::byte{0xFF} : std::byte{0});
        std::copy(one.begin(), one.end(), wide.begin());  // the low bytes come first, as in all that OpenVDB writes
    }
}
inline void narrow(const OutputInfo& info, std::span<const std::byte> wide, std::span<std::byte> room) {
    const std::size_t from = sample_bytes_in_grid(info), to = info.sample_bytes();
    for (std::size_t sample = 0; sample < room.size() / to; ++sample)
        std::copy_n(wide.begin() + static_cast<std::ptrdiff_t>(sample * from), to,
                    room.begin() + static_cast<std::ptrdiff_t>(sample * to));
}

}  // namespace clsdf::vdb

namespace clsdf {

/// A .vdb file has a random UUID and no checksum. clsdf writes a UUID that identifies clsdf and holds a checksum of all
/// other bytes. So the same field has the same bytes, and a damaged file is detected before OpenVDB reads it.

/// Gives a finished file its UUID. Throws std::runtime_error if it cannot be read or written.
void seal_vdb(const std::string& path);

/// Throws Error(unreadable_input) if the file is no .vdb file, or if clsdf wrote it and it is damaged. Returns whether
/// clsdf wrote it.
bool check_vdb_seal(InputFile& file);

}  // namespace clsdf
