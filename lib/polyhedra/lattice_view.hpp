#pragma once

#include <clsdf/box.hpp>

namespace clsdf::polyhedra {

/// A mesh seen from a lattice: positions in units, in the metric frame, relative to the lattice's sample (0, 0, 0). The
/// unit is the caller's choice, of the order of the smallest spacing; a power of two scales without rounding.
struct LatticeView {
    Vec3 origin{};                   ///< of the lattice, in the mesh's units
    double unit = 1;                 ///< in the mesh's units
    Vec3 spacing_in_units{1, 1, 1};  ///< per axis
};

}  // namespace clsdf::polyhedra
