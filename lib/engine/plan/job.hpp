#pragma once

#include <clsdf/calls.hpp>
#include <clsdf/device.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/outputs.hpp>
#include <clsdf/topology.hpp>

#include "device/buffer_pool.hpp"
#include "launch/programs.hpp"

#include <memory>
#include <utility>
#include <vector>

namespace clsdf {
class FieldMethod;
}

namespace clsdf::engine {

/// Samples that are computed together: a block of a lattice.
struct Job {
    Grid grid;
    Band band;
    OutputSet outputs;           ///< those that finishing makes: see targets::outputs_of()
    std::vector<Grid> wanted{};  ///< the blocks whose samples are needed; others may stay undefined. Empty: all
    bool counts = false;         ///< the device counts the work: see CallOptions::count_work

    friend bool operator==(const Job&, const Job&) = default;

    Job part(const Grid& slab) const {
        Job result = *this;
        result.grid = slab;
        return result;
    }
};

/// What the jobs of a transform share.
struct Workshop {
    Device device;
    std::shared_ptr<device::BufferPool> pool;
    Programs programs;
    std::shared_ptr<const FieldMethod> method{};  ///< null: leaned polyhedra scanned by bricks
    SignRule sign = SignRule::none;

    device::Context& context() const { return device::context_of(device); }
    /// The same with buffers from another pool.
    Workshop with(std::shared_ptr<device::BufferPool> other) const {
        Workshop result = *this;
        result.pool = std::move(other);
        return result;
    }
};

}  // namespace clsdf::engine
