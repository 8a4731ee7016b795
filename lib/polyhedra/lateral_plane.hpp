#pragma once

#include "polyhedra/vector.hpp"

namespace clsdf::polyhedra {

/// The parts of the planes at a face's edge, above the face and below it.
struct LateralPlane {
    Vector normal;  ///< of the face
    Vector inward;  ///< unit vector in the face's plane, perpendicular to the edge
    float above;    ///< slopes
    float below;
};

}  // namespace clsdf::polyhedra
