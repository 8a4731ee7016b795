#pragma once

#include "device/buffer_pool.hpp"
#include "launch/device_tools.hpp"
#include "launch/short_launches.hpp"
#include "sign/exact_sides.hpp"

#include <clsdf/grid.hpp>
#include <clsdf/row_tables.hpp>
#include <clsdf/segments.hpp>
#include <clsdf/topology.hpp>

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>

/// Links by kernels (kernels/segments/links.cl): the rows of find_links() with LinkChoice(), of a mesh that decides its
/// sign by itself. Nothing if the host has to find them: if a coordinate of the mesh or the size of the grid is out of
/// range, or if the order of two walls on a link is not certain.
namespace clsdf::segments {

struct DeviceLinkInputs {
    engine::DeviceTools tools;
    const engine::CrossedMesh& mesh;
    SignRule rule;  ///< nonzero or parity
    /// Called between stages with the fraction done; may be empty, and may throw.
    std::function<void(double)> between;
};

/// Links in memory of the device, packed.
struct DeviceLinks {
    using Lease = device::BufferPool::Lease;

    std::size_t row_bytes() const;

    std::size_t count = 0;
    Lease inside;  ///< a byte for each sample
    Lease samples, directions, q, triangles, counts, flags;
    Lease q_floats;  ///< as_float_part()
};

/// The members of DeviceLinks, as link_columns.
inline constexpr std::array device_columns{&DeviceLinks::samples,   &DeviceLinks::directions, &DeviceLinks::q,
                                           &DeviceLinks::triangles, &DeviceLinks::counts,     &DeviceLinks::flags};
static_assert(device_columns.size() == link_columns.size());

inline std::size_t DeviceLinks::row_bytes() const {
    std::size_t bytes = inside.bytes() + q_floats.bytes();
    for (const auto column : device_columns) bytes += (this->*column).bytes();
    return bytes;
}

/// Waits, but not for `inside`, which is enqueued. most: if there are more links, there are no rows. Throws as
/// find_links() does, and Error(device_failure).
std::optional<DeviceLinks> links_on_device(const DeviceLinkInputs& inputs, const Grid& grid,
                                           std::span<const LinkDirection> directions, std::size_t most);
/// The same for the host.
std::optional<Links> links_by_kernels(const DeviceLinkInputs& inputs, const Grid& grid,
                                      std::span<const LinkDirection> directions);
/// Their number.
std::optional<std::size_t> count_links_by_kernels(const DeviceLinkInputs& inputs, const Grid& grid,
                                                  std::span<const LinkDirection> directions);

}  // namespace clsdf::segments
