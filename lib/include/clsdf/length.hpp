#pragma once

#include <clsdf/version.hpp>

#include <string>

namespace clsdf {

/// A length as people state it: in the mesh's units, in voxels, or as a fraction of the longest side of the mesh's box.
struct Length {
    enum class Unit { mesh, voxels, extent };

    double value = 0;
    Unit unit = Unit::mesh;

    static Length in_mesh_units(double value) { return {value, Unit::mesh}; }
    static Length in_voxels(double value) { return {value, Unit::voxels}; }
    /// 0.1 is 10% of the longest side of the mesh's own box.
    static Length of_extent(double fraction) { return {fraction, Unit::extent}; }
    static Length infinite();

    bool is_infinite() const;

    /// "10%", "3v", "0.05" or "full". Throws Error(invalid_argument) that quotes the text.
    static Length parse(const std::string& text);

    /// In the mesh's units; `voxel` is the smallest spacing of the grid, `extent` the longest side of the mesh's box.
    double resolve(double voxel, double extent) const;
};

}  // namespace clsdf
