#pragma once

#include "face_sources.h"
#include "frusta/frusta.hpp"
#include "topology/topology.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::engine {

/// A mesh's topology as the kernels that make polyhedra read it (kernels/frusta/face_records.cl), and what they leave
/// out.
struct KernelTopology {
    UninitializedVector<std::uint32_t> opposite;   ///< opposite_words()
    UninitializedVector<std::uint32_t> fan_words;  ///< see FanItem
    std::vector<FanItem> fan_items;
    /// Ascending: faces with an edge of three faces or more, of two of different orientations, or from a vertex to
    /// itself.
    std::vector<std::uint32_t> irregular_faces;
    /// Ascending: vertices that are in no item, and may leave a gap or be saddle vertices.
    std::vector<std::uint32_t> irregular_vertices;

    explicit KernelTopology(const MeshTopology& topology);

    /// `face_answers`: CLSDF_FACE_... of each face. `vertex_answers`: CLSDF_VERTEX_..., CLSDF_FAN_ITEM of each item.
    LeftToHost left_to_host(const MeshTopology& topology, std::span<const std::uint8_t> face_answers,
                            std::span<const std::uint8_t> vertex_answers) const;

    std::size_t host_bytes() const;
};

/// The same from answers by vertex. saddles_elsewhere counts those that have no other answer.
LeftToHost left_by_answers(const MeshTopology& topology, std::span<const std::uint8_t> face_answers,
                           std::span<const std::uint8_t> vertex_answers);

}  // namespace clsdf::engine
