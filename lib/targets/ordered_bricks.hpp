#pragma once

#include <clsdf/sparse.hpp>

#include "core/outputs.hpp"
#include "launch/commands.hpp"
#include "launch/device_tools.hpp"
#include "launch/prefix_sums.hpp"
#include "targets/host_arrays.hpp"

#include <cstddef>

namespace clsdf::targets {

/// Memory of the device that the parts of a sparse field share, one after another: the list of a part's bricks and
/// their values as kernels leave them (CLSDF_STORED), and what is needed to put them in order.
struct ListedBricks {
    /// The list of `room` bricks, one at least, of parts with at most `most` bricks. wanted: the outputs.
    ListedBricks(device::BufferPool& pool, std::size_t room_in, std::size_t most, const HostArrays& wanted_in);
    std::size_t bytes() const;

    std::size_t room;
    HostArrays wanted;
    device::BufferPool::Lease listed;
    PerOutput<device::BufferPool::Lease> values;
    device::BufferPool::Lease counts, starts;  ///< of ranges of bricks
    device::BufferPool::Lease places;          ///< of the listed bricks
    device::BufferPool::Lease totals;          ///< bricks and runs of the parts so far
};

/// Arrays of the caller in memory of the device, checked: see SparseDeviceTargets.
struct OrderedTargets {
    struct Place {
        cl::Buffer memory{};
        std::size_t offset = 0;
    };
    Place counts, bricks, inside;
    PerOutput<Place> values{};
    SparseCounts room;
};

/// The launches that append the listed bricks of a part of a sparse field to the caller's arrays, in the order of the
/// lattice, and its runs of bricks inside.
class BrickStore {
public:
    /// marks: of the part's bricks, as in engine::FieldScan. memory: must outlive it. Throws cl::Error.
    BrickStore(const engine::DeviceTools& tools, const Layout& layout, const cl::Buffer& marks,
               const ListedBricks& memory);

    /// Allocates no device memory. Throws cl::Error.
    void enqueue(engine::CommandChain& chain, const OrderedTargets& targets);

    std::size_t bytes() const { return sums_.bytes(); }

private:
    const ListedBricks& memory_;
    std::size_t ranges_;  ///< of the part's bricks, each of CLSDF_RANGE_BRICKS
    engine::SumLaunches sums_;
    device::LentKernel count_, place_, store_, store_bytes_, runs_, add_;
    cl_uint place_targets_, runs_targets_, add_targets_;  ///< the first arguments that change from run to run
    std::size_t pieces_;                                  ///< of a brick, a work-item each
};

}  // namespace clsdf::targets
