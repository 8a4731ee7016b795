#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/sign.hpp>

#include "device/buffer_pool.hpp"
#include "layout.h"
#include "transform/short_launches.hpp"
#include "transform/sweep_mesh.hpp"

#include <optional>

namespace clsdf::transform {

struct Programs;

/// One bit a sample of the part's bricks, 1 inside: rows of layout.sign_words words (docs/method.md, 'Sign by
/// crossings'). With SignRule::none all bits are 0. Otherwise `sweep_mesh` is made where it is not there yet; all parts
/// of a grid share it. Throws as make_sweep_mesh.
device::BufferPool::Lease sweep_signs(device::Context& context, const Programs& programs,
                                      const std::shared_ptr<device::BufferPool>& pool, const Layout& layout,
                                      const Grid& grid, const Mesh& mesh, SignRule rule,
                                      std::optional<SweepMesh>& sweep_mesh, const ShortLaunches& launches);

}  // namespace clsdf::transform
