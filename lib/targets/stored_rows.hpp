#pragma once

#include <clsdf/grid.hpp>

#include "device/context.hpp"
#include "launch/commands.hpp"

#include <array>
#include <cstddef>
#include <utility>

namespace clsdf::targets {

/// Where the numbers of an array lie in a buffer of the caller's. Strides are bytes.
struct ItemLayout {
    cl_mem memory = nullptr;
    std::size_t first = 0;  ///< byte of the first item
    std::array<std::ptrdiff_t, 3> strides{};
    std::ptrdiff_t component_stride = 0;
    std::size_t components = 1;
    std::size_t width = 4;  ///< bytes of a number: 1, 4 or 8
};

/// Links on the device, packed. parts: of the width of the layout that they go to.
struct DeviceLinks {
    std::size_t count = 0;
    cl::Buffer samples, directions, parts;
};

/// Launches that store packed values in the caller's arrays, by the program `store`. Throw cl::Error.
class RowStore {
public:
    RowStore(const device::Context& context, cl::Program program) : context_(context), program_(std::move(program)) {}

    /// Items one after another along the first stride.
    void enqueue_items(engine::CommandChain& chain, const cl::Buffer& values, std::size_t count,
                       const ItemLayout& layout) const;
    /// The parts of links in fields, which are the layout's components, and -1 elsewhere.
    void enqueue_fields(engine::CommandChain& chain, const DeviceLinks& links, const Grid& grid,
                        const ItemLayout& layout) const;

private:
    const device::Context& context_;
    cl::Program program_;
};

}  // namespace clsdf::targets
