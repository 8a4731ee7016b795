#include "segments/link_places.hpp"

#include "core/parallel.hpp"

namespace clsdf::segments {

// All is inlined: only then is the loop one of vectors.
CLSDF_SEVERAL_TARGETS __attribute__((flatten)) void LinkPlaces::compute_quickly() {
#pragma omp simd
    for (std::size_t n = 0; n < most; ++n) {
        const crossing::double3 a{corners[0][0][n], corners[0][1][n], corners[0][2][n]},
            b{corners[1][0][n], corners[1][1][n], corners[1][2][n]},
            c{corners[2][0][n], corners[2][1][n], corners[2][2][n]}, from{ends[0][0][n], ends[0][1][n], ends[0][2][n]},
            to{ends[1][0][n], ends[1][1][n], ends[1][2][n]};
        int is_certain = 0;
        places[n] = crossing::quick_place_of(a, b, c, crossing::segment_between(from, to), &is_certain);
        are_certain_[n] = is_certain;
    }
}

void LinkPlaces::compute() {
    compute_quickly();
    for (std::size_t n = 0; n < most; ++n) {
        if (are_certain_[n] != 0) continue;
        const auto point = [n](const std::array<Numbers, 3>& of) { return Vec3{of[0][n], of[1][n], of[2][n]}; };
        const crossing::Corners face{point(corners[0]), point(corners[1]), point(corners[2])};
        places[n] = crossing::place_of(face, crossing::segment(point(ends[0]), point(ends[1])));
    }
}

}  // namespace clsdf::segments
