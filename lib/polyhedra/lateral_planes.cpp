#include "polyhedra/lateral_planes.hpp"

#include "polyhedra/one_rings.hpp"

#include <algorithm>

namespace clsdf::polyhedra {

void lean(const TriangleFrame& frame, FaceSlopes& slopes) {
    const double cosine = frame.normal_across[CLSDF_HALF_RIGHT] * frame.normal_across[CLSDF_HALF_LEFT] -
                          frame.normal_along[CLSDF_HALF_RIGHT] * frame.normal_along[CLSDF_HALF_LEFT];
    if (!(cosine > 0)) return;
    const std::size_t right = next_of_three(frame.base_edge);
    const std::size_t left = previous_of_three(frame.base_edge);
    for (std::array<float, 3>* side : {&slopes.above, &slopes.below}) {
        float& at_right = (*side)[right];
        float& at_left = (*side)[left];
        const float from_right = widened(cosine * static_cast<double>(at_right));
        const float from_left = widened(cosine * static_cast<double>(at_left));
        at_right = std::max(at_right, from_left);
        at_left = std::max(at_left, from_right);
    }
}

}  // namespace clsdf::polyhedra
