#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include <cstddef>
#include <functional>
#include <string>

/// The acceptance list of fields, their results, and the record.
namespace clsdf::acceptance {

/// A field to compute.
struct Problem {
    Mesh mesh;
    Grid grid;
    Band band;
    SignRule sign = SignRule::automatic;
};

struct Case {
    std::string kind;               ///< kind of mesh; the record has sums by kind
    std::string name;               ///< with all that reproduces it: resolution, half width, seed
    std::function<Problem()> make;  ///< on demand, so that one mesh is in memory at a time; may throw clsdf::Error
    std::size_t samples = 0;        ///< compared with the reference; 0: all
    bool has_points = true;         ///< a batch of points, too
};

/// A resolution with a half width as a share of the longest side of the mesh's box.
struct Setting {
    std::int64_t resolution;
    double share;
};

/// "96, 10%".
std::string name_of(const Setting& setting);

/// The grid around the mesh with the band's outside half width as margin, as `clsdf compute` lays it.
Problem problem(Mesh mesh, const Setting& setting, SignRule sign = SignRule::automatic);

/// Samples at `reach` steps of h on all sides of a centre, which is a sample itself.
Grid grid_about(const Vec3& centre, double h, std::int64_t reach);

}  // namespace clsdf::acceptance
