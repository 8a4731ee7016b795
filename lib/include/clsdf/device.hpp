#pragma once

#include <clsdf/export.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

// The handles of OpenCL's C interface, so that this header needs none of OpenCL's.
typedef struct _cl_context* cl_context;
typedef struct _cl_device_id* cl_device_id;
typedef struct _cl_command_queue* cl_command_queue;
typedef struct _cl_mem* cl_mem;

namespace clsdf {

namespace detail {
class DeviceContext;
}

/// What a device is. A number never changes its meaning, so other languages may use them.
enum class DeviceKind : std::int32_t { gpu = 0, processor = 1, accelerator = 2, other = 3 };

/// "gpu", "processor", "accelerator" or "other". The text lives as long as the process. Thread-safe.
CLSDF_EXPORT const char* name_of(DeviceKind kind) noexcept;

/// How a device was found. A number never changes its meaning, so other languages may use them.
enum class DeviceSource : std::int32_t {
    registered = 0,    ///< OpenCL's loader lists it
    bundled = 1,       ///< of the driver that the package with this library contains
    unregistered = 2,  ///< of a GPU's driver in the path of the system's loader, which OpenCL's loader does not know
    device_file = 3,   ///< a GPU's file in /dev, and no device that can be used: DeviceInfo::why_not has the remedy
};

/// "registered", "bundled", "unregistered" or "device_file". The text lives as long as the process. Thread-safe.
CLSDF_EXPORT const char* name_of(DeviceSource source) noexcept;

/// The properties that an OpenCL device reports. Those that its driver does not tell stay empty or 0. If
/// `compute_units` is 0, all from `kind` to `float_width` are unknown. A device without a name is named after its
/// platform.
struct DeviceInfo {
    /// `index` of a device that is not in Device::all(), as a part of a device.
    static constexpr std::size_t not_listed = static_cast<std::size_t>(-1);

    std::size_t index = not_listed;  ///< in Device::all()
    cl_device_id id = nullptr;
    std::string name;
    std::string platform;
    std::string version;  ///< of OpenCL, e.g. "OpenCL 3.0 CUDA"
    std::string driver;   ///< its version
    DeviceKind kind = DeviceKind::other;
    unsigned compute_units = 0;
    unsigned clock_megahertz = 0;
    std::size_t memory = 0;              ///< bytes
    std::size_t largest_allocation = 0;  ///< bytes
    bool fp64 = false;                   ///< double precision, which this library needs
    bool atomics64 = false;              ///< atomic operations on 64 bits, which it does not need
    unsigned float_width = 0;            ///< floats in a native vector; 1 on most GPUs
    std::string why_not;                 ///< why this library cannot use it; empty if it can
    /// Why this library takes it only if it is named (Device::select); empty if it may take it by itself, and if it
    /// cannot use it. So of a GPU whose driver emulates double precision: docs/devices.md.
    std::string only_if_named;
    DeviceSource source = DeviceSource::registered;
    std::string driver_file;  ///< the driver's if this library opened it; of device_file, the file in /dev; else empty

    bool usable() const { return why_not.empty(); }
    /// Whether strongest(), automatic() and of_rank() may take it.
    bool may_be_taken() const { return usable() && only_if_named.empty(); }
};

/// Limits for Device::limited().
struct DeviceLimits {
    /// Compute units to use (on a processor, cores). Not set: all.
    std::optional<unsigned> compute_units{};
    /// Bytes that the buffers of one DistanceTransform and of its plans may take at once; the caller's own do not
    /// count. A field that needs more is computed in smaller slabs, or the call ends with Error(out_of_memory). Not
    /// set: the device's memory.
    std::optional<std::size_t> memory{};
};

/// An OpenCL device with a context and a queue. Cheap to copy; copies share them. Any number of threads may call the
/// functions of one device at the same time. Once moved from, every member but assignment and the destructor throws
/// Error(invalid_argument). A function that asks the driver throws Error(device_failure) if a call of OpenCL fails.
///
/// Unless it is given a folder, the library writes no file by itself, and reads only those of the bundled driver, if
/// the package that contains the library has one, and of GPUs' drivers that are not registered (docs/devices.md). Its
/// device has programs that were compiled ahead, and no compiler: a call that needs another program throws
/// Error(unsupported).
class CLSDF_EXPORT Device {
public:
    /// Every device of every platform, in the order of OpenCL's loader, then that of the bundled driver, then those of
    /// drivers that are not registered, also those that cannot be used. Empty if there is none. Throws
    /// Error(device_failure) if the platforms cannot be listed.
    ///
    /// If the loader shows no GPU that may be taken, and /dev has one (nvidia<N>, kfd, dri/renderD<N>), the driver of
    /// its maker is opened from the path of the system's loader: docs/devices.md. Not if OCL_ICD_VENDORS is set. If
    /// there is still no GPU that may be taken, /dev/nvidia<N> and /dev/kfd have an entry each that says why.
    static std::vector<DeviceInfo> all();
    /// The entries of all() whose source is DeviceSource::device_file, without their index: GPUs that this machine has
    /// and that cannot be used. The bundled driver is not opened; without such a file in /dev no driver is asked.
    /// Throws Error(device_failure) if the platforms cannot be listed.
    static std::vector<DeviceInfo> unused_gpus();

    /// The strongest GPU, also of a driver that is not registered, else the strongest other device, else that of the
    /// bundled driver; none that is used only if it is named. Throws Error(no_device) that says why each device is not
    /// taken, and the remedy.
    static Device strongest();

    /// A whole number is an index in all(). Any other text is a part of the name or of the platform's name of exactly
    /// one usable device, in upper or lower case; the bundled driver's does not count if it fits another one's, too
    /// ("bundled" fits it alone). Throws Error(no_device) that lists the devices, Error(device_failure) if the device
    /// cannot be opened.
    static Device select(const std::string& index_or_substring);
    /// The same for a number in all() (DeviceInfo::index).
    static Device select(std::size_t index) { return select(std::to_string(index)); }

    /// The user's choice: select() with the environment variable CLSDF_DEVICE if it is set and not empty, else
    /// strongest(). No other function of the library reads that variable. Throws as these do; an error of select()
    /// names the variable.
    static Device automatic();

    /// The share of a process: `rank` of the `ranks` processes on this machine, 0 <= rank < ranks. GPUs that may be
    /// taken are dealt out in turn. If there is none, or if CLSDF_DEVICE names a device, it is that of automatic(), of
    /// a processor an equal part of the compute units, at least one. The library's loops on the host are oneTBB's:
    /// tbb::global_control limits their threads. Throws Error(invalid_argument) for a rank out of range,
    /// Error(unsupported) that names the driver's variable if a processor cannot be divided, and what automatic()
    /// throws.
    static Device of_rank(std::size_t rank, std::size_t ranks);

    /// Retains the caller's objects. Throws Error(invalid_argument) if one is null or they do not belong together;
    /// Error(unsupported) if the device has no OpenCL 1.2 or no double precision, or is known to fail;
    /// Error(device_failure).
    static Device from_handles(cl_context context, cl_device_id id, cl_command_queue queue);

    /// The same device with limits, with a context and a queue of its own. It keeps records where this one does. The
    /// library's loops on the host are oneTBB's: tbb::global_control limits their threads. Throws
    /// Error(invalid_argument) for a limit of 0, or for more compute units than there are; Error(unsupported) if the
    /// device cannot be divided, as most GPUs.
    Device limited(const DeviceLimits& limits) const;

    /// The properties of this device, as in all(). `compute_units`, `memory` and `largest_allocation` are those that
    /// limited() left. `index` is DeviceInfo::not_listed if all() has no device of this id(): a part of a device, made
    /// by limited() or by the caller, has an id of its own. Asks every driver. Throws Error(device_failure).
    DeviceInfo info() const;

    std::string name() const;
    std::string platform() const;
    /// The handles belong to this device and its copies: retain those that you keep for longer.
    cl_context context() const;
    cl_device_id id() const;
    cl_command_queue queue() const;

    /// A buffer of `bytes` bytes, of this device's context, that is memory of another interface: of CUDA for instance,
    /// exported as a POSIX file descriptor (cuMemExportToShareableHandle). On success the driver owns the descriptor,
    /// and the caller releases the buffer (clReleaseMemObject); after an error the caller still owns the descriptor.
    /// Commands may use the buffer only between clEnqueueAcquireExternalMemObjectsKHR and
    /// clEnqueueReleaseExternalMemObjectsKHR, which the caller enqueues. Throws Error(unsupported) if the driver has no
    /// cl_khr_external_memory_opaque_fd; Error(invalid_argument) for 0 bytes, for a descriptor that is not open, and if
    /// the driver does not take it as memory of this size; Error(out_of_memory); Error(device_failure).
    cl_mem import_memory(int descriptor, std::size_t bytes) const;

    /// Keeps records of passed tests in the folder, for this device and its copies and for programs that are built from
    /// now on: call it before the first DistanceTransform is made. Later processes that call it with the same folder do
    /// not test again what is recorded as tested.
    ///
    /// The folder is made when the first file is written. A folder that cannot be written, or a damaged file in it, is
    /// no error: programs are then tested anew. An empty text, as at the start: no file is read or written, and each
    /// process tests what it uses.
    void keep_records(const std::string& folder) const;

    /// Takes compiled programs from a folder that write_programs() filled, for this device and its copies and for
    /// programs that are built from now on. Writes nothing. A program is compiled as before if it is not in the folder
    /// or damaged there, if it is one of another driver's version, device or version of clsdf, or if the driver refuses
    /// it. An empty text, as at the start: all programs are compiled.
    ///
    /// The process runs the code in the folder: name one in which nobody else can write.
    void read_programs(const std::string& folder) const;

    /// Writes programs that are compiled from now on to the folder, too, which is made. Then a call that compiles
    /// throws Error(output_failure) if it cannot write. Some drivers compile a program once more to give it away. An
    /// empty text, as at the start: nothing is written.
    void write_programs(const std::string& folder) const;

    /// The folder that clsdf's command passes to keep_records() and read_programs(): the environment variable
    /// CLSDF_CACHE_DIR if it is set, from the current folder if it is relative, else $XDG_CACHE_HOME/clsdf, else
    /// $HOME/.cache/clsdf. Empty if CLSDF_CACHE_DIR is set and empty, or if no folder is known. No other function of
    /// the library reads these variables.
    static std::string default_record_folder();

    /// The folder of keep_records(); empty at the start.
    std::string record_folder() const;

    /// Gives back what this device and its copies keep for later calls, beside what transforms and plans hold: arrays
    /// of the host, at most 32 MiB; and, of a device with memory of its own, memory of the device that no transform
    /// uses, at most 512 MiB and 1/32 of its memory, and pinned memory of the host, by way of which arrays are copied,
    /// 40 MiB. KeptMemory has them. Returns the bytes. Waits for copies that are under way, and leaves pinned memory
    /// that another thread's call uses; the next call makes what it needs anew.
    std::size_t release_memory() const;

    /// Deletes the records of this device in its folder: programs are tested again, also in this process. A file that
    /// cannot be deleted stays; that is no error.
    void forget_records() const;

private:
    friend class detail::DeviceContext;
    explicit Device(std::shared_ptr<detail::DeviceContext> context) : context_(std::move(context)) {}

    std::shared_ptr<detail::DeviceContext> context_;
};

}  // namespace clsdf
