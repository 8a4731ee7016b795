#pragma once

#include "device/buffer_pool.hpp"
#include "frusta/prepared_mesh.hpp"
#include "launch/device_tools.hpp"
#include "launch/programs.hpp"
#include "launch/short_launches.hpp"
#include "layout.h"
#include "lists/surface_points.hpp"

#include <memory>
#include <vector>

namespace clsdf::engine {

/// An upper estimate of a core's time for a pair of the lists; it limits the work of a launch.
inline constexpr double seconds_per_pair = 5e-8;

/// The inputs of the lists of a part. They are needed until the lists are made.
struct ListInputs {
    DeviceTools tools;
    const Layout& layout;
    const PreparedMesh& mesh;
    const ShortLaunches& launches;  ///< of the set-up
    const RecordSelection& selection;
    std::shared_ptr<const SurfacePoints> points;  ///< null if the band is so narrow that no bound would be below it
};

/// Which polyhedra overlap which coarse bricks, on the device.
struct CoarseLists {
    device::BufferPool::Lease bounds;   ///< float a coarse brick, by groups of 4 x 4 x 4 of the lattice: bound of its
                                        ///< samples' distance
    device::BufferPool::Lease starts;   ///< `parts` values a coarse brick: where its entries begin
    device::BufferPool::Lease entries;  ///< numbers of polyhedra, ascending in each brick
    std::size_t parts = 1;
    std::size_t pairs = 0;

    /// Coarse bricks with a list, the longest first, and the lists' lengths.
    std::vector<cl_uint> order;
    std::vector<cl_uint> lengths;
};

/// The lists of the group body, whose bounds are known. Returns where each brick's list begins, and behind the last one
/// the end of all. `seconds`: of a core, for a polyhedron.
std::vector<cl_uint> make_lists_by_group(const ListInputs& inputs, double seconds, CoarseLists& lists);

/// Whether all coarse bricks are bounded by the half width alone: in a narrow band hardly any bound of their own is
/// below it.
bool has_uniform_bounds(const Layout& layout);

/// The lists of a part: of the mesh, the points and the selection. They hold no reference to the inputs.
CoarseLists make_coarse_lists(const ListInputs& inputs);

}  // namespace clsdf::engine
