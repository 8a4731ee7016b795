#pragma once

#include <clsdf/band.hpp>
#include <clsdf/field_array.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/sign.hpp>

#include <cstdint>
#include <string>

namespace clsdf {

/// Beyond the band.
inline constexpr std::uint32_t no_triangle = 0xFFFFFFFFU;

/// What a field is to hold beside the distance.
struct Outputs {
    bool triangle = false;  ///< the nearest triangle of every sample in the band
};

/// What a field is, its values apart.
struct FieldDescription {
    Grid grid;
    Band band;
    SignRule sign = SignRule::none;  ///< `automatic` where a file of another program does not say
    std::string mesh_name;
};

/// A computed field on the host. Arrays have grid.sample_count() values, x fastest, and are empty where not asked for;
/// what is made of them by hand is to be set whole, see FieldArray.
struct Field : FieldDescription {
    FieldArray<float> distance;          ///< signed distance in the mesh's units
    FieldArray<std::uint32_t> triangle;  ///< the nearest triangle (caller's order), or no_triangle beyond the band

    /// By the file's ending: .nrrd, .npy, .vti, .h5, .sdf or, where OpenVDB is built in, .vdb; docs/formats.md says
    /// what each of them holds. Beside .nrrd and .npy triangles have a file of their own, FILE_triangle.nrrd or
    /// FILE_triangle.npy. Nothing appears under its final name before everything has been written; the distances appear
    /// last.
    /// Throws Error(output_failure), Error(unsupported) for an unknown ending, or Error(invalid_argument) where the
    /// arrays do not fit the grid.
    void write(const std::string& path) const;

    /// Throws what write() would throw for the ending, for outputs that the format has no place for, or for a folder
    /// that is missing or write-protected, so that nothing is computed in vain. Leaves nothing behind.
    static void check_output(const std::string& path, const Outputs& outputs = {});

    /// Reads what write() wrote, with the very same grid, and such files of other programs where they say enough:
    /// float or double of either byte order, raw, on a grid parallel to the axes. What they do not state is a band
    /// without end and the sign rule `automatic`. `triangle` is empty where its file is not there.
    /// Throws Error(unsupported) for an unknown ending, Error(unreadable_input) that names the file, the field and the
    /// value, or Error(out_of_memory).
    static Field read(const std::string& path);
};

}  // namespace clsdf
