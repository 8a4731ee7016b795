#pragma once

#include <clsdf/topology.hpp>

#include "device/buffer_pool.hpp"
#include "launch/device_tools.hpp"
#include "launch/short_launches.hpp"
#include "layout.h"
#include "sign/film.hpp"
#include "sign/sweep_mesh.hpp"

#include <functional>
#include <memory>

namespace clsdf::engine {

class CrossingSearch;
struct Programs;

/// Makes the sign bits of a part whose layout this is, sign_bytes() of them; throws Error.
using MakeSignBits = std::function<device::BufferPool::Lease(const Layout& layout)>;

/// The inputs of a sweep; all of them must outlive it.
struct SweepInputs {
    DeviceTools tools;
    const Layout& layout;
    const SweepMesh* mesh;  ///< null: all bits are 0
    const SweepSelection& selection;
    SignRule rule;
    const ShortLaunches& launches;
    const MakeSignBits& make_bits;  ///< empty: the sweep makes the bits; else this alone does
};

/// The sweep that makes one bit a sample of the part's bricks, 1 inside: rows of layout.sign_words words
/// (docs/method.md, 'Sign by crossings'). It has two steps: between them the host may enqueue other work, and one wait
/// covers both.
class SignSweep {
public:
    /// Enqueues the search for the crossings, and does not wait for it.
    explicit SignSweep(const SweepInputs& inputs);
    SignSweep(const SignSweep&) = delete;
    SignSweep& operator=(const SignSweep&) = delete;
    ~SignSweep();

    /// The buffer for the bits.
    const cl::Buffer& bits() const { return *bits_; }

    /// Waits for the numbers of crossings, unless the host has waited for later commands of the queue, and enqueues the
    /// rest. Throws Error(out_of_memory) if there are 2^32 crossings or more.
    device::BufferPool::Lease finish();

private:
    SweepInputs inputs_;
    device::BufferPool::Lease bits_;
    FilmCrossings film_;
    std::unique_ptr<CrossingSearch> search_;
};

}  // namespace clsdf::engine
