#pragma once

#include "polyhedra/vector.hpp"

namespace clsdf::polyhedra {

/// What the planes of a face's edge are made of, above the face and below it.
struct LateralPlane {
    Vector normal;  ///< of the face
    Vector inward;  ///< unit vector in the face's plane, perpendicular to the edge
    float above;    ///< slopes
    float below;
};

}  // namespace clsdf::polyhedra
