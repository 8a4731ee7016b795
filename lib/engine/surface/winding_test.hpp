#pragma once

#include "surface/winding_view.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf {

/// The winding number of a surface with open edges, part by part: a part is joined over vertices.
struct WindingTest {
    std::vector<Vec3> points;  ///< that were tested
    WindingTally all;
    std::size_t unclear_parts = 0;
    std::uint32_t first_unclear_face = 0;
    std::size_t detail_parts = 0;  ///< of a clear surface that would not be clear if no part were a detail
    std::size_t detail_faces = 0;
    std::uint32_t first_detail_face = 0;
    bool has_clear_parts = false;  ///< beside unclear ones, in a clear box

    bool is_clear() const { return all.tested > 0 && unclear_parts == 0; }
};
/// may_be_covered: a part is clear, too, if its holes lie within others and the mesh's box is clear. This changes
/// nothing if the test without it has no clear parts.
WindingTest test_winding_number(const Mesh& mesh, std::span<const Triangle> triangles, const OpenLoops& loops,
                                bool may_be_covered = false);

}  // namespace clsdf
