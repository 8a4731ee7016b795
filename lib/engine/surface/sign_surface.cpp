#include "surface/sign_surface.hpp"

#include "core/bucket_sort.hpp"
#include "core/large_memory.hpp"
#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "mesh/box_index.hpp"

#include <utility>

namespace clsdf {

std::vector<DoubledFace> doubled_faces(std::span<const Triangle> triangles, std::size_t vertex_count) {
    /// A face at its lowest vertex.
    struct Filed {
        std::uint64_t others;  ///< the other two vertices, ascending; 0 if a vertex is repeated
        std::uint32_t face;
        bool is_forward;  ///< the face runs through its vertices in ascending order

        bool operator<(const Filed& other) const {
            return others != other.others ? others < other.others : face < other.face;
        }
    };
    UninitializedVector<Filed> filed(triangles.size());
    const UninitializedVector<std::uint32_t> first_at = bucket_sort(
        triangles.size(), vertex_count, [&](std::size_t face) { return std::ranges::min(triangles[face]); },
        [&](std::size_t face, std::size_t place) {
            const auto& [a, b, c] = triangles[face];
            const std::uint64_t lowest = std::min({a, b, c}), highest = std::max({a, b, c});
            const std::uint64_t middle = std::uint64_t{a} + b + c - lowest - highest;
            const bool is_repeated = lowest == middle || middle == highest;
            filed[place] = {is_repeated ? 0 : middle << 32 | highest, static_cast<std::uint32_t>(face),
                            (a > b) != ((b > c) != (c > a))};
        });
    constexpr std::size_t chunk = 4096;
    std::vector<std::vector<DoubledFace>> of_chunks(chunk_count(vertex_count, chunk));
    for_each_chunk(vertex_count, chunk, [&](std::size_t number, std::size_t begin, std::size_t end) {
        for (std::size_t vertex = begin; vertex != end; ++vertex) {
            const std::span<Filed> at_vertex(filed.data() + first_at[vertex], filed.data() + first_at[vertex + 1]);
            std::sort(at_vertex.begin(), at_vertex.end());
            for (std::size_t first = 0, i = 1; i < at_vertex.size(); ++i) {
                const Filed &one = at_vertex[i], &lowest = at_vertex[first];
                if (one.others != lowest.others)
                    first = i;
                else if (one.others != 0)
                    of_chunks[number].push_back({one.face, lowest.face, one.is_forward != lowest.is_forward});
            }
        }
    });
    std::vector<DoubledFace> doubled;
    for (const std::vector<DoubledFace>& part : of_chunks) doubled.insert(doubled.end(), part.begin(), part.end());
    return doubled;
}

void check_joined(const engine::Vertices& vertices, const Mesh& mesh, const SignSurface& surface,
                  std::span<const Vec3> moved) {
    if (surface.vertices.empty()) return;
    Box all = empty_box;
    for (const Triangle& triangle : mesh.triangles())
        for (const std::uint32_t index : triangle) add(all, {moved[index], moved[index]});
    check_joined(mesh.name(), all, surface, moved,
                 [&](std::uint32_t vertex) { return vertices.callers_number(vertex); });
}

void check_joined(const std::string& name, const Box& all, const SignSurface& surface, std::span<const Vec3> moved,
                  const std::function<std::size_t(std::uint32_t)>& callers_number) {
    if (surface.vertices.empty()) return;
    double half_side = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        half_side = std::max(half_side, 0.5 * all.upper[axis] - 0.5 * all.lower[axis]);
    const double most = 2 * joined_extent * half_side;
    std::vector<Box> boxes(moved.size(), empty_box);  // of clusters, by the vertex that counts
    for (std::uint32_t vertex = 0; vertex < moved.size(); ++vertex) {
        const std::uint32_t least = surface.vertex(vertex);
        if (least == vertex) continue;
        Box& box = boxes[least];
        for (const std::uint32_t one : {least, vertex}) add(box, {moved[one], moved[one]});
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (!(box.upper[axis] - box.lower[axis] > most))
                continue;  // also if one is not finite, which is told later
            refuse(
                "vertices {} and {} of {} differed by rounding and are joined for the sign, and "
                "they move apart, to ({}, {}, {}) and ({}, {}, {}), or others that are joined with "
                "them do; move them together, to within {} on each axis, use the sign rule none, or "
                "make a new transform",
                callers_number(least), callers_number(vertex), name, moved[least][0], moved[least][1], moved[least][2],
                moved[vertex][0], moved[vertex][1], moved[vertex][2], most);
        }
    }
}

}  // namespace clsdf
