#pragma once

#include "device/buffer_pool.hpp"
#include "layout.h"
#include "transform/short_launches.hpp"
#include "transform/sweep_mesh.hpp"

namespace clsdf::transform {

struct Programs;

/// Where the part's rows of samples cross the surface.
struct Crossings {
    std::size_t count = 0;
    device::BufferPool::Lease starts;   ///< of the rows' crossings, were they listed row by row; and `count`
    device::BufferPool::Lease records;  ///< SweepRecord, in no order
    std::size_t record_count = 0;       ///< those that are left over included
    bool has_large_triangles = false;   ///< see SignBits
};

/// Throws Error(out_of_memory) where there are 2^32 crossings or more.
Crossings find_crossings(device::Context& context, const Programs& programs,
                         const std::shared_ptr<device::BufferPool>& pool, const Layout& layout, const SweepMesh& mesh,
                         const ShortLaunches& launches);

}  // namespace clsdf::transform
