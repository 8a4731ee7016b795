#include "polyhedra/vertex_fans.hpp"

namespace clsdf::polyhedra {

void VertexFans::build(std::span<const Triangle> triangles, std::span<const FaceEdges> faces, const OneRings& rings,
                       std::size_t vertex) {
    const std::size_t count = rings.size(vertex);
    faces_.clear();
    starts_ = {0};
    walk(triangles, faces, vertex, rings.corner(vertex, 0));
    if (faces_.size() == count) return;

    walked_.assign(count, 0);
    std::size_t known = 0;
    for (std::size_t place = 0; place < count; ++place) {
        for (; known < faces_.size(); ++known) walked_[rings.place(vertex, faces_[known].corner)] = 1;
        if (!walked_[place]) walk(triangles, faces, vertex, rings.corner(vertex, place));
    }
}

void VertexFans::walk(std::span<const Triangle> triangles, std::span<const FaceEdges> faces, std::size_t vertex,
                      Corner first) {
    Corner corner = first;
    bool forward = true;
    do {
        const Triangle& triangle = triangles[corner.face];
        const std::uint32_t next = next_of_three(corner.vertex);
        const std::uint32_t previous = previous_of_three(corner.vertex);
        faces_.push_back({corner, triangle[forward ? next : previous], forward});
        const Corner across = Corner::unpack(faces[corner.face].across[forward ? previous : corner.vertex]);
        forward = triangles[across.face][across.vertex] == vertex;
        corner = {across.face, forward ? across.vertex : next_of_three(across.vertex)};
    } while (corner.face != first.face);
    starts_.push_back(faces_.size());
}

}  // namespace clsdf::polyhedra
