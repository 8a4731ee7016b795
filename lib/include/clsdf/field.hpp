#pragma once

#include <clsdf/band.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/sign.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace clsdf {

/// Beyond the band.
inline constexpr std::uint32_t no_triangle = 0xFFFFFFFFU;

/// A computed field on the host. Arrays have grid.sample_count() values, x fastest, and are empty where not asked for.
struct Field {
    Grid grid;
    Band band;
    SignRule sign = SignRule::none;
    std::string mesh_name;

    std::vector<float> distance;          ///< signed distance in the mesh's units
    std::vector<std::uint32_t> triangle;  ///< the nearest triangle (caller's order), or no_triangle beyond the band

    /// By the file's ending: .nrrd (raw, attached, little endian) or .npy (with a .json beside it). Complete or not at
    /// all. Throws Error(output_failure), or Error(unsupported) for an unknown ending.
    void write(const std::string& path) const;

    /// Reads what write() wrote, and such files of other programs where they say enough. Throws
    /// Error(unreadable_input).
    static Field read(const std::string& path);
};

}  // namespace clsdf
