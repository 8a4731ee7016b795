#pragma once

#include <clsdf/picture.hpp>

#include <span>

namespace clsdf::picture {

/// The axis of a solid that probably points upwards: y, as in most scanned and modelled meshes, or z, as in most
/// machine parts and terrains. It is the axis along which the solid stands firmly: the centre of mass lies well within
/// the convex hull of the lowest twentieth, seen from above. The answer is z if the solid stands firmly on it and y is
/// not clearly firmer, else y.
///
/// The solid is given by the ends of its rows of samples along x, two points a row, at least one row; gaps within a row
/// count as solid. `spacing`: of the samples.
Axis upright_axis(std::span<const Vec3> row_ends, const Vec3& spacing);

}  // namespace clsdf::picture
