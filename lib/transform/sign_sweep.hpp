#pragma once

#include <clsdf/topology.hpp>

#include "device/buffer_pool.hpp"
#include "layout.h"
#include "transform/short_launches.hpp"
#include "transform/sweep_mesh.hpp"

namespace clsdf::transform {

struct Programs;

/// One bit a sample of the part's bricks, 1 inside: rows of layout.sign_words words (docs/method.md, 'Sign by
/// crossings').
struct SignBits {
    device::BufferPool::Lease bits;
    bool has_large_triangles = false;  ///< a triangle of the sweep has more than CLSDF_LARGE_ROWS rows
};

/// Without a mesh all bits are 0.
SignBits sweep_signs(device::Context& context, const Programs& programs,
                     const std::shared_ptr<device::BufferPool>& pool, const Layout& layout, const SweepMesh* mesh,
                     SignRule rule, const ShortLaunches& launches);

}  // namespace clsdf::transform
