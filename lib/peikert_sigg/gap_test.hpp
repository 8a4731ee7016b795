#pragma once

#include "peikert_sigg/fan_signs.hpp"
#include "peikert_sigg/surface.hpp"

#include <cstddef>
#include <vector>

/// Points beyond the bisector planes of all faces of a fan, in the same rotational sense, are in none of its polyhedra
/// (Peikert & Sigg, section 3.2). The planes pass through the vertex, so they form a cone; its antipode is the one of
/// the other sense.
namespace clsdf::peikert_sigg {

/// The fan of a vertex that has one, closed and of faces oriented alike. `fans` is memory to work in.
Fan fan_at(const Surface& surface, std::size_t vertex, polyhedra::VertexFans& fans);

/// A line in which the bisector planes i and i + 1 meet, and which lies strictly on one side of all other planes.
struct FailingLine {
    std::size_t i;
    int direction;  ///< 1 where A_i x A_(i+1) points beyond the planes of all faces in the sense of increasing i, or -1
};

/// The published test: it passes where there are none.
std::vector<FailingLine> failing_lines(FanSigns& signs);

/// The complete test: whether there are points strictly beyond all planes. The cone of such points, if there are any,
/// is spanned by lines in which two planes meet, not necessarily successive ones.
bool has_gap(FanSigns& signs);

/// Whether there is a direction along which every face is seen from its front. False also where all normals lie in one
/// plane.
bool has_view(FanSigns& signs);

/// Indices of the faces that are not seen from their front along the average normal.
std::vector<std::size_t> flipped_faces(FanSigns& signs);

}  // namespace clsdf::peikert_sigg
