#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/outputs.hpp>

#include "device/mapped_memory.hpp"
#include "scan/finishing.hpp"
#include "scan/slab_pipeline.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace clsdf::scan {

/// The outputs that have a target.
Outputs outputs_of(const OutputTargets& targets);
/// The outputs that are asked for.
Outputs outputs_of(const HostArrays& arrays);

/// The samples are computed as floats, and the target gets doubles of the same values.
inline bool is_widened(const OutputRow& row, const OutputTarget& target) {
    return row.bit == 0 && target.element == OutputTarget::Element::float64;
}

/// The caller's host memory for a grid. Throws Error(invalid_argument) if the distance has none, or if memory is too
/// small, and Error(unsupported) for what cannot be written to yet.
class HostTargets {
public:
    HostTargets(const OutputTargets& targets, const Grid& grid);

    /// The same for points, which are stored as the samples of a grid of one row.
    static HostTargets of_points(const OutputTargets& targets, std::size_t count);

    /// Whether the samples of every output are packed, so that they can be computed in place.
    bool are_packed() const { return are_packed_; }
    /// The packed arrays. If a target is not packed, only the elements that are computed and whether it is asked for
    /// are set.
    const HostArrays& arrays() const { return arrays_; }

    /// Copies those of a slab's packed samples that belong to the grid to where they belong, on all cores if they are
    /// many. The slab is of the same lattice.
    void store(const Grid& slab, const HostArrays& values) const;
    /// The same for some points, from number `first` on.
    void store_row(std::size_t first, std::size_t count, const HostArrays& values) const;

private:
    /// owner: what has the samples and how many, for messages, with a place for the number.
    HostTargets(const OutputTargets& targets, const Grid& grid, const char* owner);

    OutputTargets targets_;  ///< with all strides set
    Grid grid_;
    HostArrays arrays_;
    bool are_packed_ = true;
};

/// Adds what the targets of points take of device memory to what is mapped. Throws as HostTargets does.
void add_targets(const OutputTargets& targets, std::size_t points, device::MappedMemory& memory);
/// The same targets when that is mapped, all in memory of the host.
OutputTargets on_host(const OutputTargets& targets, std::size_t points, const device::MappedMemory& memory);
/// Whether targets in memory of the host lie on some of these bytes.
bool overlap(const OutputTargets& targets, std::span<const std::byte> bytes);

/// The caller's device memory for a grid, with any offset and strides. Throws as HostTargets does.
class DeviceTargets {
public:
    DeviceTargets(const OutputTargets& targets, const Grid& grid, const device::Context& context);
    /// Without memory yet: packed, with the elements of PerOutput, in place.
    DeviceTargets(const Outputs& outputs, const Grid& grid);

    /// With all elements and strides set; empty for outputs that are not asked for.
    const OutputTargets& targets() const { return targets_; }
    /// Which outputs are asked for, and the elements that are computed, without memory.
    const HostArrays& arrays() const { return arrays_; }
    /// The targets, if the device can write a packed field there in place.
    const std::optional<OutputBuffers>& in_place() const { return in_place_; }
    /// The name of the output that needs a copy, and why; empty if none does.
    const std::string& why_not_in_place() const { return why_not_in_place_; }

private:
    OutputTargets targets_;
    HostArrays arrays_;
    std::optional<OutputBuffers> in_place_;
    std::string why_not_in_place_;
};

}  // namespace clsdf::scan
