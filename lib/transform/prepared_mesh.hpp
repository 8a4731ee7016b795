#pragma once

#include <clsdf/mesh.hpp>

#include "device/buffer_pool.hpp"
#include "layout.h"
#include "polyhedra/leaned_frusta.hpp"

namespace clsdf::transform {

/// A mesh on the device, as seen from one lattice with one band: what all parts of a grid share.
struct PreparedMesh {
    device::BufferPool::Lease polyhedra;
    device::BufferPool::Lease triangles;
    std::size_t polyhedron_count = 0;
    std::size_t saddle_vertices = 0;
    std::size_t point_sites = 0;
    std::size_t boxes = 0;
    double seconds = 0;
};

PreparedMesh prepare_mesh(device::Context& context, const std::shared_ptr<device::BufferPool>& pool, const Mesh& mesh,
                          const polyhedra::LatticeView& lattice, const Layout& layout);

}  // namespace clsdf::transform
