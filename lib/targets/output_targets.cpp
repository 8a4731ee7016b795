#include "targets/output_targets.hpp"

#include "core/outputs.hpp"
#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "targets/target_layout.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <span>

namespace clsdf::targets {

namespace {

Error misuse(const std::string& what) {
    return {ErrorCode::invalid_argument, what};
}

void check_host_memory(const OutputInfo& row, const Grid& grid, const char* owner, const OutputArray& target,
                       bool is_plain) {
    if (target.device != nullptr)
        refuse_unsupported(
            "the target of the output {} is memory of the device, and this call writes to the "
            "host's; give all targets memory of the host, or all memory of the device",
            row.name);
    const std::ptrdiff_t width = width_of(target.type);
    if (is_plain && target.bytes != ArrayLayout::unknown_size) {
        if (target.bytes == grid.sample_count() * sample_bytes(row, is_in_double(target))) return;
        throw misuse(
            fmt::format("{0}, and the array given for the output {1} has room for {2} values; {3} are needed: give the "
                        "array exactly {3} values, or set the strides",
                        fmt::format(fmt::runtime(owner), grid.sample_count()), row.name,
                        target.bytes / static_cast<std::size_t>(width),
                        static_cast<std::size_t>(grid.sample_count()) * row.components));
    }
    range_of(row, grid, target, target.bytes);
}

/// The target of each output. Throws if the distance has none.
TargetArrays target_arrays(const OutputTargets& targets) {
    TargetArrays arrays;
    for (const OutputTarget& target : targets.all()) arrays[info_of(target.output).output] = target.array;
    for_each_output(
        [](const OutputInfo& row, const OutputArray& array) {
            if (array.host != nullptr && array.device != nullptr)
                throw misuse(
                    fmt::format("the target of the output {} has memory of the host and of the device; give "
                                "one of them",
                                row.name));
        },
        arrays);
    if (!arrays[Output::distance].is_given())
        throw misuse("the distance has no target; give it memory, whatever else is asked for");
    return arrays;
}

/// begin: of the memory, see WrittenArray::first.
WrittenArray written_array(const OutputInfo& info, const OutputArray& target, const Index3& size, std::size_t request,
                           const void* memory, std::uint64_t begin) {
    return {.memory = memory,
            .first = begin + target.offset,
            .width = bytes_of(target.type),
            .size = size,
            .strides = target.strides,
            .components = info.components,
            .component_stride = target.component_stride,
            .output = info.output,
            .request = request};
}

}  // namespace

OutputSet extras_of(OutputSet outputs) {
    OutputSet known;
    for (const OutputInfo& info : output_table()) known.insert(info.output);
    if ((outputs.bits() & ~known.bits()) != 0)
        throw misuse(fmt::format("the set of outputs has the bits {:#x}; those of outputs are {:#x}", outputs.bits(),
                                 known.bits()));
    outputs.erase(Output::distance);
    return outputs;
}

OutputSet outputs_of(const OutputTargets& targets) {
    OutputSet outputs = extras_of(targets.outputs());
    const OutputArray* distance = targets.find(Output::distance);
    if (distance != nullptr && is_in_double(*distance)) outputs.insert(Output::distance);
    return outputs;
}

bool are_on_device(const OutputTargets& targets) {
    const OutputArray* distance = targets.find(Output::distance);
    return distance != nullptr && distance->device != nullptr;
}

HostTargets::HostTargets(const OutputTargets& given, const Grid& samples, const char* owner)
    : targets(target_arrays(given)), grid(samples) {
    for_each_output(
        [&](const OutputInfo& row, OutputArray& target, HostArray& array) {
            if (!target.is_given()) return;
            resolve_type(row, target);
            const bool is_plain =
                target.offset == 0 && target.component_stride == 0 && target.strides == OutputArray().strides;
            const bool is_packed = resolve_strides(row, grid, target);
            check_host_memory(row, grid, owner, target, is_plain);
            are_packed = are_packed && is_packed;
            array = {true, is_in_double(target), static_cast<std::byte*>(target.host) + target.offset,
                     target.is_pinned};
        },
        targets, arrays);
}

Grid row_of(std::size_t count, std::size_t first) {
    Grid row;
    row.first = {static_cast<std::int64_t>(first), 0, 0};
    row.size = {static_cast<std::int64_t>(count), 1, 1};
    return row;
}

OutputTargets targets_from(const OutputTargets& targets, std::size_t first) {
    const Grid one = row_of(1);
    OutputTargets result;
    for (const OutputTarget& given : targets.all()) {
        const OutputInfo& row = info_of(given.output);
        OutputArray& target = result[given.output];
        target = given.array;
        OutputArray of_one = given.array;
        resolve_type(row, of_one);
        resolve_strides(row, one, of_one);
        target.offset = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(target.offset) +
                                                 static_cast<std::ptrdiff_t>(first) * of_one.strides[0]);
        const auto packed = static_cast<std::ptrdiff_t>(sample_bytes(row, is_in_double(of_one)));
        const bool is_packed =
            of_one.strides[0] == packed && (row.components == 1 || of_one.component_stride == width_of(of_one.type));
        target.strides = {is_packed ? 0 : of_one.strides[0], 0, 0};
    }
    return result;
}

namespace {

/// visit(row, target, range, is_packed) for targets in memory of the device, whose types and strides are set.
template <typename Visit>
OutputTargets visit_device_targets(const OutputTargets& targets, const Grid& grid, const Visit& visit) {
    OutputTargets visited;
    for (const OutputTarget& given : targets.all()) {
        OutputArray& target = visited[given.output];
        target = given.array;
        if (target.device == nullptr || target.host != nullptr) continue;
        const OutputInfo& row = info_of(given.output);
        resolve_type(row, target);
        const bool is_packed = resolve_strides(row, grid, target);
        const std::size_t bytes =
            device::guarded([&] { return cl::Buffer(target.device, true).getInfo<CL_MEM_SIZE>(); });
        visit(row, target, range_of(row, grid, target, bytes), is_packed);
    }
    return visited;
}

}  // namespace

void add_targets(const OutputTargets& targets, const Grid& grid, MappedMemory& memory) {
    using Use = MappedMemory::Use;
    visit_device_targets(targets, grid,
                         [&](const OutputInfo& row, const OutputArray& target, const ByteRange& range, bool is_packed) {
                             memory.add(target.device, range, is_packed ? Use::overwrite : Use::write,
                                        fmt::format("output {}", row.name));
                         });
}

OutputTargets on_host(const OutputTargets& targets, const Grid& grid, const MappedMemory& memory) {
    static std::byte nothing{};
    return visit_device_targets(targets, grid,
                                [&](const OutputInfo&, OutputArray& target, const ByteRange& range, bool is_packed) {
                                    target.host = range.is_empty() ? &nothing : memory.at(target.device, range.begin);
                                    target.device = nullptr;
                                    target.offset = range.is_empty() ? 0 : target.offset - range.begin;
                                    target.bytes = range.end - range.begin;
                                    if (is_packed) target.strides = {};
                                });
}

void HostTargets::add_written(std::size_t request, std::vector<WrittenArray>& written) const {
    for_each_output(
        [&](const OutputInfo& info, const OutputArray& target) {
            if (target.is_given())
                written.push_back(written_array(info, target, grid.size, request, nullptr,
                                                reinterpret_cast<std::uintptr_t>(target.host)));
        },
        targets);
}

void HostTargets::store(const Grid& slab, const HostArrays& values) const {
    // The samples that both have, by their numbers on the lattice.
    Index3 begin{}, count{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        begin[axis] = std::max(slab.first[axis], grid.first[axis]);
        count[axis] = std::min(slab.first[axis] + slab.size[axis], grid.first[axis] + grid.size[axis]) - begin[axis];
        if (count[axis] <= 0) return;
    }
    const auto width = static_cast<std::size_t>(count[0]), rows_of_slice = static_cast<std::size_t>(count[1]);
    for_each_output(
        [&](const OutputInfo& row, const OutputArray& target, const HostArray& array) {
            if (!target.is_given()) return;
            const std::size_t sample = sample_bytes(row, array.in_double), element = sample / row.components;
            const bool is_row_packed = target.strides[0] == static_cast<std::ptrdiff_t>(sample) &&
                                       (row.components == 1 || target.component_stride == width_of(target.type));
            std::byte* const first = static_cast<std::byte*>(target.host) + target.offset;
            for_each_index(rows_of_slice * static_cast<std::size_t>(count[2]), [&](std::size_t number) {
                const Index3 at{begin[0], begin[1] + static_cast<std::int64_t>(number % rows_of_slice),
                                begin[2] + static_cast<std::int64_t>(number / rows_of_slice)};
                const std::byte* from = array.data + sample * slab.offset(at[0] - slab.first[0], at[1] - slab.first[1],
                                                                          at[2] - slab.first[2]);
                std::byte* to = first;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    to += static_cast<std::ptrdiff_t>(at[axis] - grid.first[axis]) * target.strides[axis];
                if (is_row_packed) {
                    std::memcpy(to, from, width * sample);
                    return;
                }
                for (std::size_t x = 0; x < width; ++x, to += target.strides[0])
                    for (std::size_t c = 0; c < row.components; ++c, from += element)
                        std::memcpy(to + static_cast<std::ptrdiff_t>(c) * target.component_stride, from, element);
            });
        },
        targets, values);
}

namespace {

/// The buffer from `offset` on, which is aligned.
cl::Buffer buffer_from(const cl::Buffer& buffer, std::size_t offset, std::size_t bytes) {
    if (offset == 0) return buffer;
    BufferPlace place = place_of(buffer(), offset);
    const cl_buffer_region region{place.byte, bytes};
    return place.memory.createSubBuffer(0, CL_BUFFER_CREATE_TYPE_REGION, &region);
}

/// Memory that kernels cannot or may not write would fail later and less clearly.
void check_memory(const OutputInfo& row, const cl::Memory& memory, const device::Context& context) {
    require_buffer(context, memory, fmt::format("the target of the output {}", row.name));
    if ((memory.getInfo<CL_MEM_FLAGS>() & CL_MEM_READ_ONLY) != 0)
        throw misuse(
            fmt::format("the target of the output {} is a buffer made with CL_MEM_READ_ONLY; kernels write to "
                        "it, so make it with CL_MEM_READ_WRITE",
                        row.name));
}

}  // namespace

DeviceTargets::DeviceTargets(const OutputTargets& given, const Grid& grid, const device::Context& context)
    : targets(target_arrays(given)), size(grid.size) {
    const std::size_t alignment = context.device().getInfo<CL_DEVICE_MEM_BASE_ADDR_ALIGN>() / 8;
    for_each_output(
        [&](const OutputInfo& row, OutputArray& target, HostArray& array, cl::Buffer& buffer) {
            if (!target.is_given()) {
                target = {};
                return;
            }
            if (target.device == nullptr)
                refuse_unsupported(
                    "the target of the output {} is memory of the host, and this call writes to "
                    "the device's; give all targets memory of the device, or compute without "
                    "a plan into memory of the host",
                    row.name);
            resolve_type(row, target);
            const bool is_packed = resolve_strides(row, grid, target);
            const cl::Buffer memory(target.device, true);
            check_memory(row, memory, context);
            range_of(row, grid, target, memory.getInfo<CL_MEM_SIZE>());
            array = {true, is_in_double(target), nullptr};
            if (array.in_double) buffers.in_double |= bit_of(row);
            if (is_packed && target.offset % alignment == 0) {
                buffer =
                    buffer_from(memory, target.offset, grid.sample_count() * sample_bytes(row, is_in_double(target)));
                return;
            }
            if (!why_not_in_place.empty()) return;
            why_not_in_place = is_packed ? fmt::format("{} begins at byte {} of its buffer, which is no multiple of {}",
                                                       row.name, target.offset, alignment)
                                         : fmt::format("{} has strides", row.name);
        },
        targets, arrays, buffers);
    if (why_not_in_place.empty()) in_place = buffers;
}

void DeviceTargets::add_written(std::size_t request, std::vector<WrittenArray>& written) const {
    for_each_output(
        [&](const OutputInfo& info, const OutputArray& target) {
            if (target.device == nullptr) return;
            const BufferPlace begin = place_of(target.device, 0);
            written.push_back(written_array(info, target, size, request, begin.memory(), begin.byte));
        },
        targets);
}

DeviceTargets::DeviceTargets(OutputSet outputs, const Grid& grid)
    : arrays(arrays_for(outputs)), in_place(engine::OutputBuffers()) {
    for_each_output(
        [&](const OutputInfo& row, OutputArray& target, const HostArray& array) {
            if (!array.is_wanted) return;
            resolve_type(row, target);
            resolve_strides(row, grid, target);
        },
        targets, arrays);
}

}  // namespace clsdf::targets
