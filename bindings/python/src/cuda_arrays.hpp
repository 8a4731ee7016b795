#pragma once

#include "cuda_memory.hpp"

#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace clsdf::python::cuda {

/// An array in memory of CUDA.
struct View {
    Pointer address = 0;  ///< of the first element
    Pointer begin = 0;    ///< of the lowest byte, and after the highest one
    Pointer end = 0;
    bool is_packed = true;    ///< no bytes between its elements
    Stream stream = nullptr;  ///< on which its package works
    std::string what;         ///< in messages
};

/// The arrays in memory of CUDA that one call uses. A SharedArray of the call's context is used where it lies. All
/// others are copied within the device, to and from kept memory; those that overlap stay as they lie to each other.
class Arrays {
public:
    explicit Arrays(std::shared_ptr<Link> link) : link_(std::move(link)) {}
    ~Arrays();
    Arrays(const Arrays&) = delete;
    Arrays& operator=(const Arrays&) = delete;

    /// Returns a stand-in for the array's buffer, for replace(). Throws Error(invalid_argument) for memory of another
    /// device.
    cl_mem add(const View& view, bool is_written);
    /// When all have been added: takes the memory for the copies.
    void place();
    /// The buffer and the offset of an array in place of what add() returned; others stay.
    void replace(cl_mem& buffer, std::size_t& offset) const;

    /// The streams on which the arrays' packages work now, in place of those of add().
    void follow(const std::vector<Stream>& streams);

    /// For a call that blocks: the arrays are OpenCL's from acquire() to release(), which return when that is so. The
    /// results follow in the order of the streams.
    void acquire();
    void release();

    /// For a call that does not block. acquire() returns the event after which OpenCL may use the arrays; `waits` are
    /// events of the caller. release() is called with the event of the end; the streams wait for it. If the driver has
    /// no semaphores, both wait on the host.
    ClEvent acquire(cl_command_queue queue, std::span<const cl_event> waits);
    void release(std::span<const cl_event> done);

    /// After an error since acquire() began, also in release(): waits for all that was enqueued, and gives the memory
    /// back to CUDA. Else without effect.
    void abandon() noexcept;

private:
    struct Entry {
        View view;
        bool is_written;
        std::shared_ptr<SharedMemory> shared{};
        std::size_t offset = 0;  ///< in its buffer
    };
    /// Bytes that are copied together.
    struct Span {
        Pointer begin, end;
        bool is_read, is_written;
        std::size_t offset;  ///< in the staging memory
    };

    void add_stream(Stream stream);
    void lock();
    void unlock() noexcept;
    void join_streams();
    void copy_in() const;
    void copy_out();
    std::vector<cl_mem> buffers() const;
    cl_command_queue own_queue() const { return link_->device().queue(); }

    std::shared_ptr<Link> link_;
    std::deque<Entry> entries_;
    std::vector<Span> spans_;
    std::unique_ptr<Lane> lane_;
    std::vector<Stream> streams_;                        ///< the first one copies and waits; each once
    std::vector<std::shared_ptr<SharedMemory>> shared_;  ///< each once, in the order in which they are locked
    std::vector<cl_mem> taken_;                          ///< acquired, to be released
    cl_command_queue queue_ = nullptr;                   ///< on which
    bool is_locked_ = false;                             ///< from the begin of acquire() to the end of release()
};

/// Copies an array to the host, or back, in the order of its stream. Blocks.
void copy_to_host(const Link& link, const View& view, void* to);
void copy_from_host(const Link& link, const View& view, const void* from);

}  // namespace clsdf::python::cuda
