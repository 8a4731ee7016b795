#pragma once

#include "device/buffer_pool.hpp"
#include "layout.h"
#include "scan/short_launches.hpp"
#include "scan/sweep_mesh.hpp"

#include <memory>

namespace clsdf::scan {

struct Programs;

/// The crossings of the part's rows of samples and the surface.
struct Crossings {
    std::size_t count = 0;
    device::BufferPool::Lease starts;   ///< of the rows' crossings, were they listed row by row; and `count`
    device::BufferPool::Lease records;  ///< SweepRecord, in no order
    std::size_t record_count = 0;       ///< those that are left over included
    bool has_large_triangles = false;   ///< see SignBits
};

/// The launches that find the crossings.
class CrossingSearch {
public:
    /// Enqueues the search and does not wait for it. The arguments must outlive this.
    CrossingSearch(device::Context& context, const Programs& programs, const std::shared_ptr<device::BufferPool>& pool,
                   const Layout& layout, const SweepMesh& mesh, const SweepSelection& selection,
                   const ShortLaunches& launches);
    CrossingSearch(const CrossingSearch&) = delete;
    CrossingSearch& operator=(const CrossingSearch&) = delete;
    ~CrossingSearch();

    /// Waits for what was found, unless the host has waited for later commands of the queue. Searches again if there
    /// was too little room. Throws Error(out_of_memory) if there are 2^32 crossings or more.
    Crossings finish();

private:
    class Launches;
    std::unique_ptr<Launches> search_;
    Crossings crossings_;
    std::size_t capacity_;
};

}  // namespace clsdf::scan
