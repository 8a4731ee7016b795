#include "targets/stored_rows.hpp"

#include "launch/short_launches.hpp"

namespace clsdf::targets {

void RowStore::enqueue_items(engine::CommandChain& chain, const cl::Buffer& values, std::size_t count,
                             const ItemLayout& layout) const {
    if (count == 0) return;
    device::LentKernel kernel(context_.kernels(), program_, "store_items");
    engine::set_arguments(kernel, 0, static_cast<cl_ulong>(count), static_cast<cl_int>(layout.components),
                          static_cast<cl_int>(layout.width), values, static_cast<cl_long>(layout.first),
                          static_cast<cl_long>(layout.strides[0]), static_cast<cl_long>(layout.component_stride),
                          cl::Buffer(layout.memory, true));
    chain.then_launch(kernel, engine::WorkItems{count});
}

void RowStore::enqueue_fields(engine::CommandChain& chain, const DeviceLinks& links, const Grid& grid,
                              const ItemLayout& layout) const {
    const cl::Buffer to(layout.memory, true);
    cl_int4 size{}, begin{};
    cl_long4 strides{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        size.s[axis] = static_cast<cl_int>(grid.size[axis]);
        begin.s[axis] = static_cast<cl_int>(grid.first[axis]);
        strides.s[axis] = layout.strides[axis];
    }
    strides.s[3] = layout.component_stride;
    const auto width = static_cast<cl_int>(layout.width);
    const auto first = static_cast<cl_long>(layout.first);
    {
        device::LentKernel kernel(context_.kernels(), program_, "clear_fields");
        engine::set_arguments(kernel, 0, size, strides, width, first, to);
        const std::size_t pieces = context_.capabilities().is_processor ? 1 : engine::common_group;
        const auto rows = static_cast<std::size_t>(grid.size[1] * grid.size[2]);
        // A field at a time is short.
        engine::divided({pieces, rows, layout.components}, {engine::most_groups, 1},
                        [&](std::size_t y, std::size_t z, const cl::NDRange& items) {
                            chain.then_launch(kernel, cl::NDRange(0, y, z), items, cl::NDRange(pieces, 1, 1));
                        });
    }
    if (links.count == 0) return;
    device::LentKernel kernel(context_.kernels(), program_, "scatter_links");
    engine::set_arguments(kernel, 0, static_cast<cl_ulong>(links.count), links.samples, links.directions, links.parts,
                          begin, strides, width, first, to);
    chain.then_launch(kernel, engine::WorkItems{links.count});
}

}  // namespace clsdf::targets
