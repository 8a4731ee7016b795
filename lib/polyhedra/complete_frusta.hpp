#pragma once

#include "polyhedra/frusta.hpp"
#include "polyhedra/kernel_topology.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::polyhedra {

/// What the kernels found (kernels/mesh_records.cl): the slopes of the frusta, and
struct KernelAnswers {
    std::span<const float> signs;                  ///< three of each face: the edges' signed slopes
    std::span<const std::uint8_t> faces;           ///< CLSDF_FACE_...
    std::span<const std::uint8_t> fan_vertices{};  ///< CLSDF_VERTEX_..., CLSDF_FAN_ITEM of each item
};

/// Arrays that completing leaves to the next time. Only elements of faces and vertices that it looks at have a meaning.
struct CompletionMemory {
    PairedEdges edges;
    UninitializedVector<std::uint8_t> vertex_marks;

    std::size_t bytes() const { return edges.faces.size() * sizeof(FaceEdges) + vertex_marks.size(); }
};

/// Completes what the kernels leave to the host, exactly: the slopes (and records, if there are any) of faces that are
/// nearly degenerate or at awkward edges, and gaps at the vertices that the kernels do not decide. `frusta` has
/// positions and slopes. Returns false, the frusta unfinished, if that is more than a part of the faces: then
/// make_frusta() is faster.
bool complete_frusta(const MeshTopology& topology, const KernelTopology& of_kernels, const KernelAnswers& answers,
                     const FirstRecords* first, CompletionMemory& memory, Frusta& frusta);

/// Whether so many faces are few enough for complete_frusta().
inline bool are_few(std::size_t awkward_faces, std::size_t faces) {
    return awkward_faces <= faces / 16;
}

}  // namespace clsdf::polyhedra
