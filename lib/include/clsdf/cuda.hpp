#pragma once

#include <clsdf/arrays.hpp>
#include <clsdf/device.hpp>
#include <clsdf/export.hpp>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>

typedef struct _cl_event* cl_event;

/// Memory of CUDA as inputs and outputs of clsdf's calls: a library of its own, clsdf::cuda. Nothing of CUDA is needed
/// to build it. NVIDIA's driver, libcuda.so.1, is opened when the first SharedDevice is made.
///
/// Addresses are those of cudaMalloc or cuMemAlloc (CUdeviceptr). Streams are a cudaStream_t or a CUstream; null is
/// CUDA's default stream, as cudaStreamLegacy is.
///
/// Unless a comment says otherwise, functions throw Error(device_failure) if a call of CUDA or OpenCL fails, which the
/// message names with its code, and Error(out_of_memory) if CUDA has no memory. CUDA's current context is as before
/// after each of them. A process that was forked must not use these objects, nor destroy them.
namespace clsdf::cuda {

class Link;
class Block;
struct ArraysState;

/// The use of an array in a call. The values of the enumerators never change.
enum class Access : std::int32_t {
    read = 0,
    write = 1,   ///< every byte gets a new value
    update = 2,  ///< some bytes keep their value, as those between the values of an array with strides
};

/// An array in memory of CUDA: all bytes from its lowest one to its highest one.
struct Array {
    std::uint64_t address = 0;  ///< of the lowest byte
    std::size_t bytes = 0;      ///< at least 1
    Access access = Access::read;
    /// The call comes after what this stream had to do before it, and what the stream has to do later comes after the
    /// call.
    void* stream = nullptr;
    std::string name = "the array";  ///< in messages
};

/// An NVIDIA GPU as a device of OpenCL and of CUDA. Retains CUDA's primary context, that of cudaMalloc. Cheap to copy;
/// copies share it, and it ends with the last object that uses it. Thread-safe.
class CLSDF_EXPORT SharedDevice {
public:
    /// Finds CUDA's device by the UUID. Throws Error(unsupported) if the driver of OpenCL shares no memory
    /// (cl_khr_device_uuid, cl_khr_external_memory_opaque_fd), Error(no_device) if CUDA has no driver or does not list
    /// the device; the message has the remedy.
    explicit SharedDevice(const Device& device);
    SharedDevice(const SharedDevice&) = default;
    SharedDevice& operator=(const SharedDevice&) = default;

    const Device& device() const;
    /// CUDA's number of the device, as of cudaSetDevice().
    int ordinal() const;

    /// Whether CUDA and OpenCL wait for each other's semaphores, so that Arrays::begin(queue) and end(done) return
    /// before the device is done. If not, both wait. Tried out at the first call, which may take a second; false after
    /// any failure.
    bool has_semaphores() const;

    /// Frees memory that is kept for copies and that no call uses. Returns its bytes.
    std::size_t release_memory() const;

    /// What `later` gets to do from now on comes after all that `earlier` has to do now.
    void order(void* earlier, void* later) const;

    /// Copies array.bytes bytes to or from memory of the host, in the order of the array's stream. Blocks.
    void copy_to_host(const Array& array, void* to) const;
    void copy_from_host(const void* from, const Array& array) const;

private:
    friend class SharedMemory;
    friend class Arrays;
    std::shared_ptr<Link> link_;
};

/// Memory that CUDA and OpenCL both have. Arrays of the same SharedDevice's context that lie in it are used without a
/// copy; calls that use it take turns. Cheap to copy; copies share it. It is freed when the last copy and the last
/// Arrays that use it have ended, which waits for the device, as cudaFree() does. Thread-safe.
class CLSDF_EXPORT SharedMemory {
public:
    /// Its content is undefined. Also throws what Device::import_memory() throws.
    SharedMemory(const SharedDevice& device, std::size_t bytes);
    SharedMemory(const SharedMemory&) = default;
    SharedMemory& operator=(const SharedMemory&) = default;

    std::uint64_t address() const;  ///< for CUDA, on all streams
    std::size_t bytes() const;      ///< as asked for, or up to 2 MiB more
    /// For OpenCL, as long as this lives. Commands of the caller's may use it only between
    /// clEnqueueAcquireExternalMemObjectsKHR and clEnqueueReleaseExternalMemObjectsKHR.
    cl_mem buffer() const;

private:
    std::shared_ptr<Block> block_;
};

/// The arrays in memory of CUDA that a call of clsdf uses, as buffers of OpenCL. Arrays that lie in SharedMemory are
/// used there. All others are copied within the GPU, to and from memory that the SharedDevice keeps; those that overlap
/// stay as they lie to each other. No other stream may write to an array's bytes during the call. One thread at a time.
///
///     cuda::Arrays arrays(gpu, {{positions, 12 * vertices, cuda::Access::read, stream},
///                               {field, 4 * samples, cuda::Access::write, stream}});
///     arrays.begin();
///     transform.set_positions(arrays.input(0, ElementType::float32, vertices));
///     transform.compute(grid, band, arrays.output(1));
///     arrays.end();
class CLSDF_EXPORT Arrays {
public:
    /// Throws Error(invalid_argument) without arrays, for an array of 0 bytes, for one on another device of CUDA or at
    /// an address that its driver does not know, and for one that reaches beyond the SharedMemory in which it begins.
    Arrays(const SharedDevice& device, std::span<const Array> arrays);
    Arrays(const SharedDevice& device, std::initializer_list<Array> arrays)
        : Arrays(device, std::span<const Array>(arrays.begin(), arrays.size())) {}
    /// As abandon(). Work that was enqueued goes on.
    ~Arrays();
    Arrays(const Arrays&) = delete;
    Arrays& operator=(const Arrays&) = delete;

    /// The buffer of an array, and the bytes before its lowest byte. Throws Error(invalid_argument) if there is no
    /// array of this number.
    DeviceRange operator[](std::size_t number) const;
    /// The same as packed items for a call: InputArray, OutputArray. An array with strides also needs these.
    InputArray input(std::size_t number, ElementType type, std::size_t count) const;
    OutputArray output(std::size_t number, ElementType type = ElementType::automatic) const;

    /// Around a call that blocks, on one thread. begin() waits for the streams, and the arrays are OpenCL's until
    /// end(). The results arrive in the order of the streams. Both throw Error(invalid_argument) in the wrong order.
    void begin();
    void end();

    /// Around a run of a plan, which does not block, on one thread:
    ///
    ///     plan.enqueue(queue, arrays.output(0), arrays.begin(queue), &done);
    ///     arrays.end(done);
    ///
    /// begin() gives the event after which OpenCL may use the arrays; it comes after the caller's events `wait_list`,
    /// and lives until the next begin(). end() takes the event of the run's end; the streams wait for it. A null queue
    /// is the device's own. May be repeated at once, and the arrays may end before the run does. Throws
    /// Error(invalid_argument) for a queue of another context than the device's, for a null event, and in the wrong
    /// order.
    std::span<const cl_event> begin(cl_command_queue queue, std::span<const cl_event> wait_list = {});
    void end(cl_event done);

    /// After an error since begin(), on its thread: waits for all that was enqueued, and gives the memory back to CUDA.
    /// The arrays of Access::write and Access::update are undefined then. Without effect after end().
    void abandon() noexcept;

    /// Later calls follow these streams in place of those of the arrays. Throws Error(invalid_argument) for none, and
    /// between begin() and end().
    void follow(std::span<void* const> streams);

private:
    std::unique_ptr<ArraysState> state_;
};

}  // namespace clsdf::cuda
