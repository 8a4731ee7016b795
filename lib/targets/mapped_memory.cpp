#include "targets/mapped_memory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace clsdf::targets {

namespace {

void check_flags(const cl::Buffer& memory, bool is_read, const std::string& what) {
    const cl_mem_flags flags = memory.getInfo<CL_MEM_FLAGS>();
    const cl_mem_flags forbidding = CL_MEM_HOST_NO_ACCESS | (is_read ? CL_MEM_HOST_WRITE_ONLY : CL_MEM_HOST_READ_ONLY);
    if ((flags & forbidding) == 0) return;
    throw Error(ErrorCode::unsupported,
                fmt::format("the buffer of the {} was made with {}, and the host {} it; make it without", what,
                            (flags & CL_MEM_HOST_NO_ACCESS) != 0 ? "CL_MEM_HOST_NO_ACCESS"
                            : is_read                            ? "CL_MEM_HOST_WRITE_ONLY"
                                                                 : "CL_MEM_HOST_READ_ONLY",
                            is_read ? "reads" : "writes"));
}

template <typename Buffers>
auto find(Buffers& buffers, const cl::Buffer& memory) {
    return std::find_if(buffers.begin(), buffers.end(),
                        [&](const auto& buffer) { return buffer.memory() == memory(); });
}

}  // namespace

void require_buffer(const device::Context& context, const cl::Memory& memory, const std::string& owner) {
    if (memory.getInfo<CL_MEM_TYPE>() != CL_MEM_OBJECT_BUFFER)
        throw Error(ErrorCode::invalid_argument, fmt::format("{} is an image or a pipe; give it a buffer", owner));
    if (memory.getInfo<CL_MEM_CONTEXT>()() != context.context()())
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("{} belongs to another OpenCL context than the device of the transform; make it in the "
                                "context that the device was made with",
                                owner));
}

cl::CommandQueue queue_of(const device::Context& context, cl_command_queue queue) {
    if (queue == nullptr) return context.callers_queue();
    cl::CommandQueue callers(queue, true);
    if (callers.getInfo<CL_QUEUE_CONTEXT>()() != context.context()() ||
        callers.getInfo<CL_QUEUE_DEVICE>()() != context.device()())
        throw Error(ErrorCode::invalid_argument,
                    "the queue belongs to another OpenCL context or device than the transform; give one of the "
                    "transform's device, or none");
    return callers;
}

std::vector<cl::Event> events_of(const device::Context& context, std::span<const cl_event> wait_list) {
    std::vector<cl::Event> events;
    for (std::size_t n = 0; n < wait_list.size(); ++n) {
        const auto refuse = [&](const char* reason) {
            return Error(ErrorCode::invalid_argument,
                         fmt::format("event {} of the wait list's {} {}", n, wait_list.size(), reason));
        };
        if (wait_list[n] == nullptr) throw refuse("is null");
        events.emplace_back(wait_list[n], true);
        if (events.back().getInfo<CL_EVENT_CONTEXT>()() != context.context()())
            throw refuse("belongs to another OpenCL context than the transform's device");
        // Commands that wait for it would fail; those of PoCL 3.1 never end.
        if (const auto status = events.back().getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>(); status < CL_COMPLETE)
            throw Error(ErrorCode::device_failure,
                        fmt::format("event {} of the wait list's {} has failed (status {}), so nothing can follow it",
                                    n, wait_list.size(), status));
    }
    return events;
}

void wait_for(const device::Context& context, std::span<const cl_event> wait_list) {
    if (!wait_list.empty()) device::guarded([&] { cl::Event::waitForEvents(events_of(context, wait_list)); });
}

BufferPlace place_of(cl_mem memory, std::size_t byte) {
    cl::Buffer buffer(memory, true);
    if (const auto whole = buffer.getInfo<CL_MEM_ASSOCIATED_MEMOBJECT>(); whole() != nullptr) {
        byte += buffer.getInfo<CL_MEM_OFFSET>();
        buffer = cl::Buffer(whole(), true);
    }
    return {buffer, byte};
}

cl::Buffer checked_range(const device::Context& context, const DeviceRange& range, std::size_t bytes,
                         std::size_t alignment, const char* name) {
    const auto misuse = [](const std::string& what) { return Error(ErrorCode::invalid_argument, what); };
    if (range.memory == nullptr)
        throw misuse(fmt::format("{} has no memory, and a run writes {} bytes there; give it a buffer", name, bytes));
    const cl::Buffer memory(range.memory, true);
    require_buffer(context, memory, name);
    if ((memory.getInfo<CL_MEM_FLAGS>() & CL_MEM_READ_ONLY) != 0)
        throw misuse(
            fmt::format("{} is a buffer made with CL_MEM_READ_ONLY; kernels write to it, so make it with "
                        "CL_MEM_READ_WRITE",
                        name));
    if (range.offset % alignment != 0)
        throw misuse(fmt::format("{} begins at byte {} of its buffer; let it begin at a multiple of {}", name,
                                 range.offset, alignment));
    const std::size_t size = memory.getInfo<CL_MEM_SIZE>();
    if (range.offset > size || size - range.offset < bytes)
        throw misuse(fmt::format("{} needs {} bytes from byte {} on, and its buffer has {}; give it a larger one", name,
                                 bytes, range.offset, size));
    return memory;
}

MappedMemory::~MappedMemory() {
    try {
        unmap();
    } catch (const std::exception&) {
        // On the way out after another error.
    }
}

void MappedMemory::add(cl_mem memory, const ByteRange& range, Use use, const std::string& what) {
    device::guarded([&] {
        const cl::Buffer callers(memory, true);
        require_buffer(context_, callers, fmt::format("the memory of the {}", what));
        const std::size_t bytes = callers.getInfo<CL_MEM_SIZE>();
        if (range.end > bytes)
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("the {} reach to byte {} of a buffer that holds {}", what, range.end, bytes));
        check_flags(callers, use == Use::read, what);
        if (range.is_empty()) return;
        const BufferPlace begin = place_of(memory, range.begin);
        const ByteRange in_whole{begin.byte, begin.byte + (range.end - range.begin)};
        const cl_map_flags flags = use == Use::read    ? cl_map_flags{CL_MAP_READ}
                                   : use == Use::write ? cl_map_flags{CL_MAP_WRITE}
                                                       : cl_map_flags{CL_MAP_WRITE_INVALIDATE_REGION};
        const auto known = find(buffers_, begin.memory);
        if (known == buffers_.end()) {
            buffers_.push_back({begin.memory, in_whole, flags, nullptr});
            return;
        }
        known->range = {std::min(known->range.begin, in_whole.begin), std::max(known->range.end, in_whole.end)};
        // Bytes between two ranges stay.
        const auto keeping = [](cl_map_flags any) {
            return any == CL_MAP_WRITE_INVALIDATE_REGION ? cl_map_flags{CL_MAP_WRITE} : any;
        };
        known->flags = keeping(known->flags) | keeping(flags);
    });
}

void MappedMemory::add_triples(const InputArray& triples, const std::string& what) {
    if (triples.device == nullptr) return;
    const std::size_t bytes = device::guarded([&] { return cl::Buffer(triples.device, true).getInfo<CL_MEM_SIZE>(); });
    add(triples.device, range_of(triples, bytes, what.c_str(), ErrorCode::invalid_argument), Use::read, what);
}

void MappedMemory::map(std::span<const cl_event> wait_list) {
    wait_for(context_, wait_list);
    device::guarded([&] {
        for (Buffer& buffer : buffers_)
            context_.run_blocking([&](cl::Event* ended) {
                buffer.mapped = static_cast<std::byte*>(
                    context_.queue().enqueueMapBuffer(buffer.memory, CL_TRUE, buffer.flags, buffer.range.begin,
                                                      buffer.range.end - buffer.range.begin, nullptr, ended));
            });
    });
}

std::byte* MappedMemory::at(cl_mem memory, std::size_t byte) const {
    const BufferPlace place = device::guarded([&] { return place_of(memory, byte); });
    const auto found = find(buffers_, place.memory);
    return found->mapped + (place.byte - found->range.begin);
}

InputArray MappedMemory::mapped(const InputArray& triples) const {
    if (triples.device == nullptr) return triples;
    InputArray result = triples;
    result.device = nullptr;
    if (triples.count == 0) return result;
    const ByteRange range = range_of(triples, InputArray::unknown_size, "", ErrorCode::invalid_argument);
    result.host = at(triples.device, range.begin);
    result.offset = triples.offset - range.begin;
    result.bytes = range.end - range.begin;
    return result;
}

void MappedMemory::unmap() {
    bool is_mapped = false;
    device::guarded([&] {
        for (Buffer& buffer : buffers_)
            if (std::byte* const mapped = std::exchange(buffer.mapped, nullptr); mapped != nullptr) {
                context_.queue().enqueueUnmapMemObject(buffer.memory, mapped);
                is_mapped = true;
            }
        if (is_mapped) context_.finish();
    });
}

}  // namespace clsdf::targets
