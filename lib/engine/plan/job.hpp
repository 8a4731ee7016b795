#pragma once

#include <clsdf/calls.hpp>
#include <clsdf/device.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/outputs.hpp>
#include <clsdf/topology.hpp>

#include "device/buffer_pool.hpp"
#include "lattice/lattice_view.hpp"
#include "lattice/layout_of.hpp"
#include "launch/device_tools.hpp"
#include "launch/programs.hpp"

#include <memory>
#include <utility>
#include <vector>

namespace clsdf {
class FieldMethod;
}

namespace clsdf::engine {

/// What is asked of samples that are computed together. A kept plan is found again by it.
struct JobKey {
    Grid grid;
    Band band;
    OutputSet outputs;           ///< those that finishing makes: all but distances in float
    std::vector<Grid> wanted{};  ///< the blocks whose samples are needed; others may stay undefined. Empty: all
    bool counts = false;         ///< the device counts the work: see CallOptions::count_work

    friend bool operator==(const JobKey&, const JobKey&) = default;
};

/// A JobKey with its grid as kernels and polyhedra see it. KeptMesh::checked() makes it; the jobs of other parts of the
/// lattice follow from it.
struct Job : JobKey {
    Layout layout{};        ///< of the grid, as kernels read it
    LatticeView lattice{};  ///< how polyhedra see the grid's lattice

    /// The job of another part of the same lattice. Throws as set_part() does.
    Job with_grid(const Grid& part) const {
        Job result = *this;
        result.grid = part;
        set_part(part, result.layout);
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
    DeviceTools tools() const { return {context(), pool, programs}; }
    /// The same with buffers from another pool.
    Workshop with(std::shared_ptr<device::BufferPool> other) const {
        Workshop result = *this;
        result.pool = std::move(other);
        return result;
    }
};

}  // namespace clsdf::engine
