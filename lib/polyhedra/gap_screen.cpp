#include "polyhedra/gap_screen.hpp"

namespace clsdf::polyhedra {

void GapScreen::look_at(const EdgeSlopes& stretch) {
    const std::size_t number = stretch.begin() / OrderedFaces::stretch;
    for (std::uint32_t vertex = first_vertices_[number]; vertex < first_vertices_[number + 1]; ++vertex) {
        if (rings_.corner(vertex, rings_.size(vertex) - 1).face >= stretch.end()) {
            fans_.leave(vertex);
            continue;
        }
        const EdgesAround edges(edges_, rings_, vertex);
        marks_[vertex] = edges.vertex_mark();
        if (!edges.are_plain()) {
            fans_.leave(vertex);
        } else if (edges.are_mixed()) {
            fans_.add(stretch, vertex);
        }
    }
}

}  // namespace clsdf::polyhedra
