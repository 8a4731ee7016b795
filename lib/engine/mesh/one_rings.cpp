#include "mesh/one_rings.hpp"

#include "core/bucket_sort.hpp"
#include "core/parallel.hpp"
#include "core/refuse.hpp"

namespace clsdf {

std::size_t checked_face_count(std::size_t count) {
    if (count > most_faces)
        refuse_unsupported("{} triangles are more than the {} that can be prepared; split the mesh", count, most_faces);
    return count;
}

OneRings::OneRings(std::span<const Triangle> triangles, std::size_t vertex_count)
    : corners_(3 * checked_face_count(triangles.size())) {
    start_ = bucket_sort(
        corners_.size(), vertex_count, [&](std::size_t i) { return triangles[i / 3][i % 3]; },
        [&](std::size_t i, std::size_t place) {
            const auto number = static_cast<std::uint32_t>(i);
            corners_[place] = Corner{number / 3, number % 3}.packed();
        });
}

namespace {

/// In a namespace without a name: compilers export the function that chooses a target, whatever the visibility.
CLSDF_SEVERAL_TARGETS RingMatches matches_of(const RingMatches::Numbers& next, const RingMatches::Numbers& previous,
                                             std::size_t count) {
    RingMatches matches{};
    for (std::size_t j = 0; j < count; ++j)
        for (std::size_t i = 0; i < RingMatches::most_faces; ++i) {
            matches.other[i] = next[i] == previous[j] ? static_cast<std::uint32_t>(j) : matches.other[i];
            matches.arriving[i] += next[i] == previous[j] ? 1U : 0U;
            matches.leaving[i] += next[i] == next[j] ? 1U : 0U;
        }
    return matches;
}

}  // namespace

RingMatches match_ring(const RingMatches::Numbers& next, const RingMatches::Numbers& previous, std::size_t count) {
    return matches_of(next, previous, count);
}

}  // namespace clsdf
