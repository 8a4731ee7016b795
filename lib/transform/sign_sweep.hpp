#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/sign.hpp>

#include "device/buffer_pool.hpp"
#include "layout.h"
#include "transform/short_launches.hpp"

namespace clsdf::transform {

struct Programs;

/// One bit a sample of the part's bricks, 1 inside: rows of layout.sign_words words (docs/method.md, 'Sign by
/// crossings'). With SignRule::none all bits are 0. The mesh's triangles are on the device already. Throws
/// Error(unsupported) where the mesh reaches farther from the grid than the sweep's integers.
device::BufferPool::Lease sweep_signs(device::Context& context, const Programs& programs,
                                      const std::shared_ptr<device::BufferPool>& pool, const Layout& layout,
                                      const Grid& grid, const Mesh& mesh, SignRule rule, const cl::Buffer& triangles,
                                      const ShortLaunches& launches);

}  // namespace clsdf::transform
