#pragma once

#include "device/context.hpp"
#include "mesh/input_arrays.hpp"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace clsdf::targets {

/// The caller's memory, queue and events. All throw Error(invalid_argument) for what belongs to another context.
/// owner: begins the message. Memory that is no buffer is refused, too.
void require_buffer(const device::Context& context, const cl::Memory& memory, const std::string& owner);
/// Without a queue: that of the device.
cl::CommandQueue queue_of(const device::Context& context, cl_command_queue queue);
/// Throws Error(device_failure) for an event that has failed.
std::vector<cl::Event> events_of(const device::Context& context, std::span<const cl_event> wait_list);
void wait_for(const device::Context& context, std::span<const cl_event> wait_list);

/// A byte of a buffer that is no part of another one.
struct BufferPlace {
    cl::Buffer memory;
    std::size_t byte;
};
/// The place of a byte of a buffer or sub-buffer. Throws cl::Error.
BufferPlace place_of(cl_mem memory, std::size_t byte);

/// The buffer of a range that commands of the device write so many bytes to, from a multiple of `alignment` on. name:
/// begins a sentence. Throws Error(invalid_argument).
cl::Buffer checked_range(const device::Context& context, const DeviceRange& range, std::size_t bytes,
                         std::size_t alignment, const char* name);

/// Buffers of the caller's in the host's address space for the time of a call. A buffer is mapped once, whatever lies
/// in it; a sub-buffer counts as a part of its buffer. First add() what is used, then map().
class MappedMemory {
public:
    explicit MappedMemory(const device::Context& context) : context_(context) {}
    MappedMemory(const MappedMemory&) = delete;
    MappedMemory& operator=(const MappedMemory&) = delete;
    /// Gives the buffers back, also after an error.
    ~MappedMemory();

    enum class Use {
        read,
        write,      ///< of some bytes of the range
        overwrite,  ///< of every byte
    };
    /// what: follows "the buffer of the" in messages. Throws Error(invalid_argument) if the buffer belongs to
    /// another context or the range does not lie in it, Error(unsupported) if its flags forbid the use.
    void add(cl_mem memory, const ByteRange& range, Use use, const std::string& what);
    /// Does nothing for memory of the host. what: a plural.
    void add_triples(const InputArray& triples, const std::string& what);

    /// Returns when the events have ended and the memory is there.
    void map(std::span<const cl_event> wait_list);
    /// The address of a byte of a range that was added.
    std::byte* at(cl_mem memory, std::size_t byte) const;
    /// The same triples in memory of the host.
    InputArray mapped(const InputArray& triples) const;

    /// Returns when the device has what was written.
    void unmap();

private:
    struct Buffer {
        cl::Buffer memory;
        ByteRange range;
        cl_map_flags flags = 0;
        std::byte* mapped = nullptr;
    };

    const device::Context& context_;
    std::vector<Buffer> buffers_;
};

}  // namespace clsdf::targets
