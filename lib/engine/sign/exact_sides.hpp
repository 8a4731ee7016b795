#pragma once

#include <clsdf/topology.hpp>

#include "device/buffer_pool.hpp"
#include "launch/device_tools.hpp"
#include "launch/short_launches.hpp"
#include "sign/row_records.hpp"
#include "sweep.h"
#include "topology/device_topology.hpp"

#include <cstddef>
#include <memory>
#include <optional>

/// The exact sides of samples by kernels (kernels/sign/exact_sides.cl).
namespace clsdf::engine {

/// A mesh on the device that decides its sign by itself, as exact predicates of kernels read it.
struct CrossedMesh {
    std::shared_ptr<const NamedFaces> faces;
    std::shared_ptr<const device::BufferPool::Lease> positions;  ///< Vec3 of each vertex
    double per_unit = 1;  ///< what coordinates are multiplied by: that of CrossedFaces
};

struct ExactSides {
    device::BufferPool::Lease bits;  ///< rows of SampleRows::words words, 1 inside
    RowKeys crossings;               ///< of the rows, sorted (look_windings.h)

    std::size_t device_bytes() const { return bits.bytes() + crossings.starts.bytes() + crossings.keys.bytes(); }
};

/// Finds the sides of all samples. at: their coordinates on the device; at most CLSDF_MOST_EXACT_SAMPLES in a row.
/// rule: nonzero or parity. Nothing if a coordinate of the mesh is out of the range of exact arithmetic. Waits for the
/// number of crossings. Throws Error(out_of_memory).
std::optional<ExactSides> find_exact_sides(const DeviceTools& tools, const ShortLaunches& launches,
                                           const CrossedMesh& mesh, SignRule rule, const SampleRows& samples,
                                           const cl::Buffer& at);

}  // namespace clsdf::engine
