#include "polyhedra/one_rings.hpp"

#include "polyhedra/parallel.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>

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

    // Where each corner goes among those of its vertex.
    UninitializedVector<std::array<std::uint32_t, 3>> places(triangles.size(), scratch);
    for_each_index(triangles.size(), [&](std::size_t face) {
        for (std::size_t k = 0; k < 3; ++k)
            places[face][k] = std::atomic_ref(start_[triangles[face][k] + 1]).fetch_add(1, std::memory_order_relaxed);
    });
    for (std::size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
    for_each_index(triangles.size(), [&](std::size_t face) {
        for (std::uint32_t k = 0; k < 3; ++k)
            corners_[start_[triangles[face][k]] + places[face][k]] =
                Corner{static_cast<std::uint32_t>(face), k}.packed();
    });

    // Threads race for the places within a vertex: only the sorted list is the same on every run.
    for_each_index(vertex_count, [&](std::size_t vertex) {
        std::sort(corners_.begin() + start_[vertex], corners_.begin() + start_[vertex + 1]);
    });
}

}  // namespace clsdf::polyhedra
