#pragma once

#include "support/exact_field.hpp"

#include "device/buffer_pool.hpp"
#include "device/context.hpp"
#include "plan/grid_inputs.hpp"
#include "plan/grid_plan.hpp"
#include "plan/kept_mesh.hpp"

#include <memory>
#include <utility>
#include <vector>

namespace clsdf::test {

/// The distances by the kernels for GPUs, whose groups share lists of eight entries and more as they do long ones.
inline std::vector<float> distances_by_shares(const Device& device, const Mesh& mesh, const Grid& grid,
                                              const Band& band) {
    device::Context& context = device::context_of(device);
    const engine::Workshop workshop{device, std::make_shared<device::BufferPool>(device::shared_context_of(device)),
                                    engine::Programs(context, KernelBody::by_group), nullptr, SignRule::nonzero};
    engine::KeptMesh kept_mesh(context, workshop.pool, Mesh(mesh), engine::Vertices(),
                               {.programs = workshop.programs, .method = nullptr, .is_whole = true});
    const engine::Job job = kept_mesh.checked({grid, band, {}}, workshop.sign);
    engine::Inputs inputs = engine::grid_inputs(kept_mesh, job, workshop.sign);
    inputs.shares_short_lists = true;
    engine::GridPlan plan(workshop, std::move(inputs), job, {});
    engine::OutputBuffers buffers;
    buffers[Output::distance] = cl::Buffer(context.context(), CL_MEM_READ_WRITE, grid.sample_count() * sizeof(float));
    engine::CommandChain chain(context.queue(), {});
    plan.enqueue(chain, buffers, {});
    std::vector<float> found(grid.sample_count());
    context.queue().enqueueReadBuffer(buffers[Output::distance], CL_TRUE, 0, found.size() * sizeof(float),
                                      found.data());
    return found;
}

}  // namespace clsdf::test
