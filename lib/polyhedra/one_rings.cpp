#include "polyhedra/one_rings.hpp"

#include "core/parallel.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <array>

namespace clsdf::polyhedra {

void check_face_count(std::size_t count) {
    if (count > most_faces)
        throw Error(
            ErrorCode::unsupported,
            fmt::format("{} triangles are more than the {} that can be prepared; split the mesh", count, most_faces));
}

OneRings::OneRings(std::span<const Triangle> triangles, std::size_t vertex_count, ScratchMemory* scratch)
    : start_(vertex_count + 1), corners_(3 * triangles.size(), scratch) {
    check_face_count(triangles.size());

    // By one thread, in the order of the faces: several would take longer to agree, and to sort what they file (on two
    // cores).
    UninitializedVector<std::array<std::uint32_t, 3>> places(triangles.size(), scratch);
    for (std::size_t face = 0; face < triangles.size(); ++face)
        for (std::size_t k = 0; k < 3; ++k) places[face][k] = start_[triangles[face][k] + 1]++;
    for (std::size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
    for_each_index(triangles.size(), [&](std::size_t face) {
        for (std::uint32_t k = 0; k < 3; ++k)
            corners_[start_[triangles[face][k]] + places[face][k]] =
                Corner{static_cast<std::uint32_t>(face), k}.packed();
    });
}

}  // namespace clsdf::polyhedra
