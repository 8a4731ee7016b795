#pragma once

#include "core/parallel.hpp"
#include "frusta/records.hpp"

#include <clsdf/mesh.hpp>

namespace clsdf::test {

/// A mesh's frusta and their records for a lattice: those of the faces, then those of the point sites.
struct LeanedFrusta {
    UninitializedVector<Polyhedron> polyhedra;
    std::size_t saddle_vertices = 0;
    std::size_t point_sites = 0;
    std::size_t boxes = 0;
};

inline LeanedFrusta leaned_frusta(const Mesh& mesh, const engine::LatticeView& lattice,
                                  const engine::FrustaOptions& options = {}) {
    const engine::MeshTopology topology(mesh);
    const engine::Frusta frusta = engine::make_frusta(topology, mesh.vertices(), options);
    const std::size_t faces = topology.order.size();
    LeanedFrusta result{UninitializedVector<Polyhedron>(faces + frusta.sites.size()), frusta.saddle_vertices,
                        frusta.sites.size(), frusta.boxes};
    const std::span<Polyhedron> records(result.polyhedra);
    for (std::size_t face = 0; face < faces; ++face) write_face_record(topology, frusta, lattice, face, records[face]);
    write_site_records(topology, frusta, lattice, 0, records.subspan(faces));
    return result;
}

}  // namespace clsdf::test
