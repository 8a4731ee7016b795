#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/outputs.hpp>

#include "finish/finishing.hpp"
#include "targets/host_arrays.hpp"
#include "targets/mapped_memory.hpp"
#include "targets/target_overlap.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace clsdf::targets {

/// What finishing (kernels/finish/finish.h) makes for the targets: the outputs beside the distance, and the distance
/// if it is in double.
OutputSet outputs_of(const OutputTargets& targets);
/// The set without the distance, which is always computed.
OutputSet extras_of(OutputSet outputs);

/// The target of each output; those without memory are not asked for.
using TargetArrays = PerOutput<OutputArray>;

/// Whether the distance's target is memory of the device.
bool are_on_device(const OutputTargets& targets);

/// The caller's host memory for a grid. Throws Error(invalid_argument) if the distance has none, or if memory is too
/// small, and Error(unsupported) for what cannot be written to yet.
struct HostTargets {
    /// owner: what has the samples and how many, for messages, with a place for the number.
    HostTargets(const OutputTargets& given, const Grid& samples, const char* owner = "the grid has {} samples");

    /// Adds the arrays of all targets, for refuse_overlap().
    void add_written(std::size_t request, std::vector<WrittenArray>& written) const;

    /// Copies those of a slab's packed samples that belong to the grid to where they belong, on all cores if they are
    /// many. The slab is of the same lattice.
    void store(const Grid& slab, const HostArrays& values) const;

    bool can_be_in_place() const { return are_packed; }

    TargetArrays targets;  ///< with all types and strides set
    Grid grid;
    /// The packed arrays. If a target is not packed, only the elements that are computed and whether it is asked for
    /// are set.
    HostArrays arrays;
    bool are_packed = true;  ///< the samples of every output, so that they can be computed in place
};

/// Points are stored as the samples of a grid of one row, from number `first` on.
Grid row_of(std::size_t count, std::size_t first = 0);
/// The targets of points from number `first` on. Strides along the row that leave no room are as if they were not
/// given.
OutputTargets targets_from(const OutputTargets& targets, std::size_t first);
/// Adds what the targets of a grid take of device memory to what is mapped. Throws as HostTargets does.
void add_targets(const OutputTargets& targets, const Grid& grid, MappedMemory& memory);
/// The same targets when that is mapped, all in memory of the host.
OutputTargets on_host(const OutputTargets& targets, const Grid& grid, const MappedMemory& memory);

/// The caller's device memory for a grid, with any offset and strides. Throws as HostTargets does.
struct DeviceTargets {
    DeviceTargets(const OutputTargets& given, const Grid& grid, const device::Context& context);
    /// Without memory yet: packed, with the types of output_table(), in place.
    DeviceTargets(OutputSet outputs, const Grid& grid);

    /// Adds the arrays of all targets, for refuse_overlap(). Throws cl::Error.
    void add_written(std::size_t request, std::vector<WrittenArray>& written) const;

    bool can_be_in_place() const { return in_place.has_value(); }

    TargetArrays targets;  ///< with all types and strides set; empty for outputs that are not asked for
    HostArrays arrays;     ///< which outputs are asked for, and the elements that are computed, without memory
    Index3 size{};
    engine::OutputBuffers buffers;                  ///< those that the device can write packed samples to
    std::optional<engine::OutputBuffers> in_place;  ///< the same, if that is all of them
    std::string why_not_in_place;  ///< the name of the output that needs a copy, and why; empty if none does
};

}  // namespace clsdf::targets
