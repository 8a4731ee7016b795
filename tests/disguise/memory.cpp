// Buffers and the host's access to them. A GPU's buffers are its own memory: a mapping is a copy.
#include "disguise/gpu.hpp"

#include "disguise/external.hpp"
#include "disguise/failing.hpp"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

namespace clsdf::disguise {

namespace {

// As numbers of polyhedra or samples these bytes are far beyond every buffer, as floats they are NaN.
constexpr int unset = 0xFF;
// Larger buffers are not filled, because the fill would take memory twice.
constexpr std::size_t largest_unset = std::size_t{256} << 20;

struct Mapping {
    cl_mem buffer;
    std::size_t offset;
    std::size_t bytes;
    bool written;
    std::unique_ptr<std::byte[]> copy;  ///< none if the buffer has memory of the host's
};

struct Buffer {
    std::size_t bytes;
    bool is_used = false;  ///< it has memory: that of a GPU gets it when a command uses it
};

/// A buffer that is gone, and the function to be told.
struct Release {
    void(CL_CALLBACK* notify)(cl_mem, void*);
    cl_mem buffer;
    void* user;
};

struct Memory {
    std::mutex mutex;
    std::map<cl_mem, unsigned> owners;  ///< callers, who retain and release, and parts; a driver counts commands, too
    std::map<cl_mem, Buffer> buffers;
    std::map<cl_mem, cl_mem> wholes;  ///< of sub-buffers
    std::map<cl_kernel, std::map<cl_uint, cl_mem>> arguments;
    std::map<cl_mem, std::byte*> host_memory;  ///< of buffers that were made with CL_MEM_USE_HOST_PTR
    std::multimap<const void*, Mapping> mappings;
    std::set<cl_event> pinned_reads;  ///< that nobody has waited for
    std::vector<Release> late;        ///< of Settings::ends_late
};
Memory& memory() {
    static auto* const only = new Memory;
    return *only;
}

void check_in(cl_mem buffer, std::byte* host) {
    const std::scoped_lock lock(memory().mutex);
    if (host != nullptr) memory().host_memory[buffer] = host;
}

/// Before one of its owners releases it: the last one, with the whole that it is a part of.
void check_out(cl_mem buffer) {
    const std::scoped_lock lock(memory().mutex);
    while (buffer != nullptr) {
        const auto owners = memory().owners.find(buffer);
        if (owners == memory().owners.end() || --owners->second > 0) return;
        memory().owners.erase(owners);
        memory().host_memory.erase(buffer);
        if (const auto found = memory().buffers.find(buffer); found != memory().buffers.end()) {
            if (found->second.is_used) count_memory(-static_cast<std::int64_t>(found->second.bytes));
            memory().buffers.erase(found);
        }
        const auto whole = memory().wholes.find(buffer);
        buffer = whole == memory().wholes.end() ? nullptr : whole->second;
        if (whole != memory().wholes.end()) memory().wholes.erase(whole);
    }
}

/// Under the mutex.
cl_int use_under_lock(cl_mem buffer) {
    if (const auto whole = memory().wholes.find(buffer); whole != memory().wholes.end()) buffer = whole->second;
    if (!is_usable(buffer)) return CL_INVALID_OPERATION;
    const auto found = memory().buffers.find(buffer);
    if (found == memory().buffers.end() || found->second.is_used) return CL_SUCCESS;
    if (record().bytes + found->second.bytes > record().settings.memory) return CL_MEM_OBJECT_ALLOCATION_FAILURE;
    count_memory(static_cast<std::int64_t>(found->second.bytes));
    found->second.is_used = true;
    count([](Counts& counts) { ++counts.first_uses; });
    return CL_SUCCESS;
}

std::byte* host_memory_of(cl_mem buffer) {
    const std::scoped_lock lock(memory().mutex);
    const auto found = memory().host_memory.find(buffer);
    return found == memory().host_memory.end() ? nullptr : found->second;
}

/// A new buffer with memory of the device.
void note_buffer(cl_mem buffer, std::size_t bytes, bool is_used) {
    const std::scoped_lock lock(memory().mutex);
    memory().owners[buffer] = 1;
    memory().buffers[buffer] = {bytes, is_used};
    if (is_used) count_memory(static_cast<std::int64_t>(bytes));
}

cl_mem create_on_gpu(cl_context context, cl_mem_flags flags, std::size_t bytes, void* host, cl_int* error) {
    const bool uses_host = (flags & CL_MEM_USE_HOST_PTR) != 0;
    if (uses_host) flags = (flags & ~cl_mem_flags{CL_MEM_USE_HOST_PTR}) | CL_MEM_COPY_HOST_PTR;
    std::vector<unsigned char> content;
    const void* from = host;
    if (from == nullptr && (flags & CL_MEM_COPY_HOST_PTR) == 0 && bytes > 0 && bytes <= largest_unset) {
        content.assign(bytes, unset);
        from = content.data();
        flags |= CL_MEM_COPY_HOST_PTR;
    }
    // The driver only reads it.
    const cl_mem buffer = CLSDF_NEXT(clCreateBuffer)(context, flags, bytes, const_cast<void*>(from), error);
    if (buffer != nullptr && uses_host) check_in(buffer, static_cast<std::byte*>(host));
    if (buffer == nullptr) return buffer;
    note_buffer(buffer, bytes, host != nullptr);  // else it does not hold data
    return buffer;
}

/// Null, and an error, if the driver does not take the command.
void* map_on_gpu(cl_command_queue queue, cl_mem buffer, bool blocking, cl_map_flags flags, std::size_t offset,
                 std::size_t bytes, cl_uint waits, const cl_event* wait_list, cl_event* event, cl_int* error) {
    Mapping mapping{buffer, offset, bytes, (flags & (CL_MAP_WRITE | CL_MAP_WRITE_INVALIDATE_REGION)) != 0, {}};
    std::byte* target = host_memory_of(buffer);
    if (target != nullptr) {
        target += offset;
    } else {
        mapping.copy = std::make_unique_for_overwrite<std::byte[]>(std::max<std::size_t>(bytes, 1));
        target = mapping.copy.get();
    }
    cl_int code = CL_SUCCESS;
    if ((flags & CL_MAP_WRITE_INVALIDATE_REGION) != 0) {
        cl_event reached = nullptr;
        code = CLSDF_NEXT(clEnqueueMarkerWithWaitList)(queue, waits, wait_list, &reached);
        if (code == CL_SUCCESS && blocking) code = CLSDF_NEXT(clWaitForEvents)(1, &reached);
        std::memset(target, unset, bytes);
        if (event != nullptr)
            *event = reached;
        else if (reached != nullptr)
            CLSDF_NEXT(clReleaseEvent)(reached);
    } else {
        code = CLSDF_NEXT(clEnqueueReadBuffer)(queue, buffer, blocking ? CL_TRUE : CL_FALSE, offset, bytes, target,
                                               waits, wait_list, event);
        count_down(bytes);
    }
    if (error != nullptr) *error = code;
    if (code != CL_SUCCESS) return nullptr;
    const std::scoped_lock lock(memory().mutex);
    memory().mappings.emplace(target, std::move(mapping));
    return target;
}

/// Under the mutex. Mappings do not overlap.
bool is_mapped(const void* host, std::size_t bytes) {
    const auto after = memory().mappings.upper_bound(host);
    if (after == memory().mappings.begin()) return false;
    const auto& [begin, mapping] = *std::prev(after);
    return static_cast<const std::byte*>(host) + bytes <= static_cast<const std::byte*>(begin) + mapping.bytes;
}

void CL_CALLBACK forget(cl_event event, cl_int, void* copy) {
    delete[] static_cast<std::byte*>(copy);
    CLSDF_NEXT(clReleaseEvent)(event);
}

cl_int unmap_on_gpu(cl_command_queue queue, cl_mem buffer, void* mapped, cl_uint waits, const cl_event* wait_list,
                    cl_event* event) {
    Mapping mapping{};
    {
        const std::scoped_lock lock(memory().mutex);
        const auto [begin, end] = memory().mappings.equal_range(mapped);
        const auto found = std::find_if(begin, end, [&](const auto& entry) { return entry.second.buffer == buffer; });
        if (found == end) return CL_INVALID_VALUE;
        mapping = std::move(found->second);
        memory().mappings.erase(found);
    }
    cl_event ended = nullptr;
    cl_int code = CL_SUCCESS;
    if (mapping.written) {
        code = CLSDF_NEXT(clEnqueueWriteBuffer)(queue, buffer, CL_FALSE, mapping.offset, mapping.bytes, mapped, waits,
                                                wait_list, &ended);
        count_up(mapping.bytes);
    } else {
        code = CLSDF_NEXT(clEnqueueMarkerWithWaitList)(queue, waits, wait_list, &ended);
    }
    if (code != CL_SUCCESS) return code;
    if (event != nullptr) {
        CLSDF_NEXT(clRetainEvent)(ended);
        *event = ended;
    }
    CLSDF_NEXT(clSetEventCallback)(ended, CL_COMPLETE, forget, mapping.copy.release());
    return CL_SUCCESS;
}

void CL_CALLBACK release_late(cl_mem, void* release) {
    const std::unique_ptr<Release> ended(static_cast<Release*>(release));
    const std::scoped_lock lock(memory().mutex);
    memory().late.push_back(*ended);
}

}  // namespace

void end_late_releases() {
    std::vector<Release> ended;
    {
        const std::scoped_lock lock(memory().mutex);
        ended.swap(memory().late);
    }
    for (const Release& release : ended) release.notify(release.buffer, release.user);
}

cl_int use(cl_mem buffer) {
    const std::scoped_lock lock(memory().mutex);
    return use_under_lock(buffer);
}

cl_int use_arguments(cl_kernel kernel) {
    const std::scoped_lock lock(memory().mutex);
    for (const auto& [index, buffer] : memory().arguments[kernel])
        if (const cl_int code = use_under_lock(buffer)) return code;
    return CL_SUCCESS;
}

void note_argument(cl_kernel kernel, cl_uint index, std::size_t bytes, const void* value) {
    if (!is_gpu()) return;
    cl_mem buffer = nullptr;
    if (value != nullptr && bytes == sizeof buffer) std::memcpy(&buffer, value, bytes);
    const std::scoped_lock lock(memory().mutex);
    if (memory().buffers.contains(buffer) || memory().wholes.contains(buffer) || is_external(buffer))
        memory().arguments[kernel][index] = buffer;
    else
        memory().arguments[kernel].erase(index);
}

void forget_arguments(cl_kernel kernel) {
    const std::scoped_lock lock(memory().mutex);
    memory().arguments.erase(kernel);
}

void note_transfer(const void* host, std::size_t bytes) {
    {
        const std::scoped_lock lock(memory().mutex);
        if (is_mapped(host, bytes)) return;
    }
    count([&](Counts& counts) { counts.pageable_bytes += bytes; });
}

void note_read(cl_event event, const void* target, std::size_t bytes) {
    constexpr std::size_t few = std::size_t{1} << 15;  // which the host waits for before it goes on
    const std::scoped_lock lock(memory().mutex);
    if (bytes > few && is_mapped(target, 1))
        memory().pinned_reads.insert(event);
    else
        memory().pinned_reads.erase(event);
}

bool is_pinned_read(cl_event event) {
    const std::scoped_lock lock(memory().mutex);
    return memory().pinned_reads.erase(event) > 0;
}

}  // namespace clsdf::disguise

using namespace clsdf::disguise;

extern "C" {

cl_mem clCreateBuffer(cl_context context, cl_mem_flags flags, std::size_t bytes, void* host, cl_int* error) {
    const InCall in_call;
    if (const cl_int code = begin("clCreateBuffer")) return refused(code, error);
    const cl_mem buffer = is_gpu() ? create_on_gpu(context, flags, bytes, host, error)
                                   : CLSDF_NEXT(clCreateBuffer)(context, flags, bytes, host, error);
    if (buffer == nullptr) return buffer;
    if (!is_gpu() && (flags & CL_MEM_USE_HOST_PTR) == 0) note_buffer(buffer, bytes, true);
    count([&](Counts& counts) {
        ++counts.allocations;
        counts.allocated_bytes += bytes;
    });
    if ((flags & (CL_MEM_COPY_HOST_PTR | CL_MEM_USE_HOST_PTR)) != 0) {
        count_up(bytes);
        note_transfer(host, bytes);
    }
    return buffer;
}

cl_mem clCreateSubBuffer(cl_mem buffer, cl_mem_flags flags, cl_buffer_create_type type, const void* region,
                         cl_int* error) {
    const InCall in_call;
    if (const cl_int code = begin("clCreateSubBuffer")) return refused(code, error);
    const cl_mem part = CLSDF_NEXT(clCreateSubBuffer)(buffer, flags, type, region, error);
    if (std::byte* const host = host_memory_of(buffer); host != nullptr && part != nullptr)
        check_in(part, host + static_cast<const cl_buffer_region*>(region)->origin);
    if (part != nullptr) {
        const std::scoped_lock lock(memory().mutex);
        memory().owners[part] = 1;
        ++memory().owners[buffer];
        memory().wholes[part] = buffer;
    }
    return part;
}

cl_int clRetainMemObject(cl_mem buffer) {
    const InCall in_call;
    {
        const std::scoped_lock lock(memory().mutex);
        if (const auto owners = memory().owners.find(buffer); owners != memory().owners.end()) ++owners->second;
    }
    return CLSDF_NEXT(clRetainMemObject)(buffer);
}

cl_int clReleaseMemObject(cl_mem buffer) {
    const InCall in_call;
    check_out(buffer);
    return CLSDF_NEXT(clReleaseMemObject)(buffer);
}

cl_int clSetMemObjectDestructorCallback(cl_mem buffer, void(CL_CALLBACK* notify)(cl_mem, void*), void* user) {
    const InCall in_call;
    if (const cl_int code = begin("clSetMemObjectDestructorCallback")) return code;
    if (!record().settings.ends_late || notify == nullptr)
        return CLSDF_NEXT(clSetMemObjectDestructorCallback)(buffer, notify, user);
    auto release = std::make_unique<Release>(Release{notify, buffer, user});
    const cl_int code = CLSDF_NEXT(clSetMemObjectDestructorCallback)(buffer, release_late, release.get());
    if (code == CL_SUCCESS) release.release();
    return code;
}

void* clEnqueueMapBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, cl_map_flags flags,
                         std::size_t offset, std::size_t bytes, cl_uint waits, const cl_event* wait_list,
                         cl_event* event, cl_int* error) {
    const InCall in_call;
    if (const cl_int code = begin("clEnqueueMapBuffer")) return refused(code, error);
    if (const cl_int code = use(buffer)) return refused(code, error);
    count_command();
    if (blocking != CL_FALSE) count_wait();
    if (is_failing(queue, waits, wait_list)) {  // the host sees what the buffer holds
        if (const cl_int code = fail_command(queue, blocking != CL_FALSE, event)) return refused(code, error);
        blocking = CL_TRUE;
        waits = 0;
        wait_list = nullptr;
        event = nullptr;
    }
    if (is_gpu())
        return map_on_gpu(queue, buffer, blocking != CL_FALSE, flags, offset, bytes, waits, wait_list, event, error);
    return CLSDF_NEXT(clEnqueueMapBuffer)(queue, buffer, blocking, flags, offset, bytes, waits, wait_list, event,
                                          error);
}

cl_int clEnqueueUnmapMemObject(cl_command_queue queue, cl_mem buffer, void* mapped, cl_uint waits,
                               const cl_event* wait_list, cl_event* event) {
    const InCall in_call;
    if (const cl_int code = begin("clEnqueueUnmapMemObject")) return code;
    count_command();
    if (is_failing(queue, waits, wait_list)) {
        if (const cl_int code = fail_command(queue, false, event)) return code;
        waits = 0;
        wait_list = nullptr;
        event = nullptr;
    }
    if (is_gpu()) return unmap_on_gpu(queue, buffer, mapped, waits, wait_list, event);
    return CLSDF_NEXT(clEnqueueUnmapMemObject)(queue, buffer, mapped, waits, wait_list, event);
}
}
