#include "polyhedra/gap_screen.hpp"

namespace clsdf::polyhedra {

void GapScreen::look_at(const EdgeSlopes& stretch) {
    for_each_vertex(triangles_, rings_, stretch.begin(), stretch.end(), [&](std::uint32_t vertex) {
        if (rings_.corner(vertex, rings_.size(vertex) - 1).face >= stretch.end()) {
            fans_.leave(vertex);
            return;
        }
        const EdgesAround edges(edges_, rings_, vertex);
        marks_[vertex] = edges.vertex_mark();
        if (!edges.are_plain()) {
            fans_.leave(vertex);
        } else if (edges.are_mixed()) {
            fans_.add(stretch, vertex);
        }
    });
}

}  // namespace clsdf::polyhedra
