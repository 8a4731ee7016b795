#pragma once

#include <clsdf/mesh.hpp>

#include "cutting/cancellation.hpp"
#include "cutting/meetings.hpp"
#include "surface/sign_surface.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace clsdf::cutting {

/// Bodies are known to the rounding of their coordinates: a gap narrower than that part of the largest coordinate
/// counts as closed.
inline constexpr double gap_width = 4e-15;

/// What was done about gaps between faces that look at each other.
struct ClosedGaps {
    std::vector<bool> is_moved;  ///< by vertex, by at most four widths; empty: none is
    bool is_changed = false;     ///< triangles may have other vertices
    std::size_t left = 0;        ///< pairs of faces that are nearer than 1e-9, and stay apart
};

/// Faces that are nearer to each other than that are told of.
inline constexpr double gap_margin = 1e-9;

/// Closes gaps that are no wider than gap_width: the corners of one face are moved along the other one's normal until
/// they are on its plane or behind it, so that the bodies overlap by a rounding. A quadrilateral that two bodies have
/// in common, and that is flat but for rounding, is divided along one diagonal in both. vertices: the largest
/// coordinate is between 1/2 and 1. boxes: of the faces, widened by gap_margin. are_inside_out: faces look inwards.
ClosedGaps close_gaps(std::vector<Vec3>& vertices, std::vector<Triangle>& triangles, const FaceBoxes& boxes,
                      const SignSurface& surface, bool are_inside_out, const Cancellation& cancellation);

}  // namespace clsdf::cutting
