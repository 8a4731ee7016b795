#include "targets/host_arrays.hpp"

#include "core/parallel.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>

namespace clsdf::targets {

HostArrays arrays_for(OutputSet outputs) {
    HostArrays arrays;
    for (const OutputInfo& info : infos_of(outputs))
        arrays[info.output] = {true, info.type == ElementType::float64, nullptr};
    return arrays;
}

HostArrays arrays_from(std::size_t sample, const HostArrays& arrays) {
    HostArrays part = arrays;
    for_each_output(
        [&](const OutputInfo& row, HostArray& array) {
            if (array.data != nullptr) array.data += sample * sample_bytes(row, array.in_double);
        },
        part);
    return part;
}

std::size_t widest_of(const HostArrays& arrays) {
    std::size_t widest = 0;
    for (const OutputInfo& row : output_table())
        if (const HostArray& array = arrays[row.output]; array.is_wanted)
            widest = std::max(widest, sample_bytes(row, array.in_double));
    return widest;
}

FieldSlab slab_of(const HostArrays& arrays, std::size_t samples) {
    FieldSlab slab;
    for (const OutputInfo& row : output_table())
        if (const HostArray& array = arrays[row.output]; array.is_wanted)
            slab.set(row.output, std::span<const std::byte>(array.data, samples * row.sample_bytes()));
    return slab;
}

void OutputMemories::place(const device::Context& context, device::BufferPool& pool, const HostArrays& wanted,
                           std::size_t count) {
    arrays = wanted;
    samples = count;
    buffers = {};
    in_place = context.capabilities().is_processor;
    for_each_output(
        [&](const OutputInfo& row, const HostArray& array, device::BufferPool::Lease& lease, cl::Buffer& buffer) {
            if (!array.is_wanted) return;
            if (array.in_double) buffers.in_double |= bit_of(row);
            const std::size_t bytes = samples * sample_bytes(row, array.in_double);
            if (in_place) {
                buffer = cl::Buffer(context.context(), CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, bytes, array.data);
                return;
            }
            if (lease.bytes() < bytes) {
                lease = {};
                lease = pool.lease(bytes, "samples of the field");
            }
            buffer = *lease;
        },
        arrays, leases, buffers);
}

void OutputMemories::enqueue_handover(const cl::CommandQueue& queue) const {
    if (!in_place) return;
    for_each_output(
        [&](const OutputInfo& row, const HostArray& array, const cl::Buffer& buffer) {
            if (!array.is_wanted) return;
            void* mapped =
                queue.enqueueMapBuffer(buffer, CL_FALSE, CL_MAP_READ, 0, samples * sample_bytes(row, array.in_double));
            queue.enqueueUnmapMemObject(buffer, mapped);
        },
        arrays, buffers);
}

void OutputMemories::read(const device::Context& context, const cl::CommandQueue& transfers) const {
    read(context, transfers, std::vector<device::Milestone>());
}

void OutputMemories::read(const device::Context& context, const cl::CommandQueue& transfers,
                          std::vector<device::Milestone> milestones) const {
    if (in_place) return;
    const auto read_part = [&](std::size_t begin, std::size_t end, std::span<const device::Milestone> of_part) {
        for_each_output(
            [&](const OutputInfo& row, const HostArray& array, const cl::Buffer& buffer) {
                if (!array.is_wanted) return;
                const std::size_t bytes = sample_bytes(row, array.in_double);
                std::vector<device::Milestone> in_bytes(of_part.begin(), of_part.end());
                for (device::Milestone& milestone : in_bytes) milestone.end = (milestone.end - begin) * bytes;
                context.read(transfers, buffer, begin * bytes, (end - begin) * bytes, array.data + begin * bytes,
                             array.is_pinned, in_bytes);
            },
            arrays, buffers);
    };
    std::size_t outputs = 0;
    for_each_output([&](const OutputInfo&, const HostArray& array) { outputs += array.is_wanted ? 1 : 0; }, arrays);
    if (outputs < 2) {
        read_part(0, samples, milestones);
        return;
    }
    // All that is complete, before what is still computed.
    std::size_t begin = 0;
    for (const device::Milestone& milestone : milestones) {
        read_part(begin, milestone.end, {&milestone, 1});
        begin = milestone.end;
    }
    if (begin < samples) read_part(begin, samples, {});
}

HostArrays OwnArrays::for_samples(const HostArrays& wanted, std::size_t samples) {
    HostArrays result = wanted;
    try {
        for_each_output(
            [&](const OutputInfo& row, HostArray& array, device::LinesOfMemory& own) {
                const std::size_t bytes = array.is_wanted ? samples * sample_bytes(row, array.in_double) : 0;
                const std::size_t lines = chunk_count(bytes, sizeof(device::MemoryLine));
                if (own.capacity() < lines) {
                    own = {};  // so as to get exactly so many
                    if (spares_ != nullptr) own = spares_->take(lines);
                }
                own.resize(lines);
                array.is_pinned = false;
                if (array.is_wanted) array.data = own.data()->bytes;
            },
            result, arrays_);
    } catch (const std::exception&) {
        throw Error(ErrorCode::out_of_memory,
                    fmt::format("the outputs of {} samples do not fit the memory; compute fewer at a time", samples));
    }
    return result;
}

std::size_t OwnArrays::bytes() const {
    std::size_t bytes = 0;
    for_each_output([&](const OutputInfo&,
                        const device::LinesOfMemory& own) { bytes += own.capacity() * sizeof(device::MemoryLine); },
                    arrays_);
    return bytes;
}

void OwnArrays::give_back() noexcept {
    if (spares_ == nullptr) return;
    for_each_output([&](const OutputInfo&, device::LinesOfMemory& own) { spares_->keep(std::exchange(own, {})); },
                    arrays_);
}

}  // namespace clsdf::targets
