#pragma once

#include "device/buffer_pool.hpp"
#include "layout.h"
#include "transform/short_launches.hpp"
#include "transform/sweep_mesh.hpp"

namespace clsdf::transform {

struct Programs;

/// Where the part's rows of samples cross the surface.
struct Crossings {
    device::BufferPool::Lease row_counts;  ///< how many crossings each row has
    device::BufferPool::Lease records;     ///< SweepRecord, in no order
    std::size_t record_count = 0;          ///< those that are left over included
};

Crossings find_crossings(device::Context& context, const Programs& programs,
                         const std::shared_ptr<device::BufferPool>& pool, const Layout& layout, const SweepMesh& mesh,
                         const ShortLaunches& launches);

}  // namespace clsdf::transform
