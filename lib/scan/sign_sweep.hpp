#pragma once

#include <clsdf/topology.hpp>

#include "device/buffer_pool.hpp"
#include "layout.h"
#include "scan/short_launches.hpp"
#include "scan/sign_crossings.hpp"
#include "scan/sweep_mesh.hpp"

#include <memory>

namespace clsdf::scan {

struct Programs;

/// One bit a sample of the part's bricks, 1 inside: rows of layout.sign_words words (docs/method.md, 'Sign by
/// crossings').
struct SignBits {
    device::BufferPool::Lease bits;
    bool has_large_triangles = false;  ///< a triangle of the sweep has more than CLSDF_LARGE_ROWS rows
};

/// The sweep. It has two steps: between them the host may enqueue other work, and one wait covers both.
class SignSweep {
public:
    /// Enqueues the search for the crossings. Without a mesh all bits are 0. The arguments must outlive this.
    SignSweep(device::Context& context, const Programs& programs, const std::shared_ptr<device::BufferPool>& pool,
              const Layout& layout, const SweepMesh* mesh, const SweepSelection& selection, SignRule rule,
              const ShortLaunches& launches);

    /// The buffer for the bits.
    const cl::Buffer& bits() const { return *result_.bits; }

    /// Waits for the numbers of crossings, if need be, and enqueues the rest.
    SignBits finish();

private:
    /// Enqueues the launches that make bits of the crossings.
    void sweep_rows(const Crossings& crossings);

    device::Context& context_;
    const Programs& programs_;
    const std::shared_ptr<device::BufferPool>& pool_;
    const Layout& layout_;
    SignRule rule_;
    const ShortLaunches& launches_;
    SignBits result_;
    std::unique_ptr<CrossingSearch> search_;
};

}  // namespace clsdf::scan
