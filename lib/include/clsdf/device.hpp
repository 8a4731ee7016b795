#pragma once

#include <clsdf/export.hpp>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

// The handles of OpenCL's C interface, so that this header needs none of OpenCL's.
typedef struct _cl_context* cl_context;
typedef struct _cl_device_id* cl_device_id;
typedef struct _cl_command_queue* cl_command_queue;

namespace clsdf {

class Device;

namespace device {
class Context;
const std::shared_ptr<Context>& shared_context_of(const Device& device);
}  // namespace device

enum class DeviceKind { gpu, processor, accelerator, other };

/// "gpu", "processor", "accelerator" or "other".
CLSDF_EXPORT std::string name_of(DeviceKind kind);

/// The properties that an OpenCL device reports. Those that its driver does not tell stay empty or 0. If
/// `compute_units` is 0, all from `kind` to `float_width` are unknown. A device without a name is named after its
/// platform.
struct DeviceInfo {
    std::size_t index = 0;  ///< in Device::all()
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

    bool usable() const { return why_not.empty(); }
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

/// An OpenCL device with a context and a queue. Cheap to copy; copies share them. Once moved from, every member but
/// assignment and the destructor throws Error(invalid_argument).
class CLSDF_EXPORT Device {
public:
    /// Every device of every platform, in the order of OpenCL's loader, also those that cannot be used.
    static std::vector<DeviceInfo> all();

    /// The strongest GPU, else the strongest other device. Throws Error(no_device) that says why each device
    /// cannot be used, and the remedy.
    static Device best();

    /// A whole number is an index in all(). Any other text is a part of the name or of the platform's name of exactly
    /// one usable device, in upper or lower case. Throws Error(no_device) that lists the devices, Error(device_failure)
    /// if the device cannot be opened.
    static Device select(const std::string& index_or_substring);

    /// select() with the environment variable CLSDF_DEVICE if it is set and not empty, else best(). No other function
    /// of the library reads that variable.
    static Device preferred();

    /// The value of CLSDF_DEVICE that preferred() uses; empty if it is not set.
    static std::string environment_choice();

    /// Retains the caller's objects. Throws Error(invalid_argument) if one is null or they do not belong together;
    /// Error(unsupported) if the device has no OpenCL 1.2 or no double precision, or is known to fail;
    /// Error(device_failure).
    static Device from_handles(cl_context context, cl_device_id id, cl_command_queue queue);

    /// The same device with limits, with a context and a queue of its own. Programs are kept and tested as those of
    /// select(). The library's loops on the host are oneTBB's: tbb::global_control limits their threads. Throws
    /// Error(invalid_argument) for a limit of 0, or for more compute units than there are; Error(unsupported) if the
    /// device cannot be divided, as most GPUs.
    Device limited(const DeviceLimits& limits) const;

    std::string name() const;
    std::string platform() const;
    cl_context context() const;
    cl_device_id id() const;
    cl_command_queue queue() const;

    /// The folder in which compiled programs are kept between runs, for this device and its copies: the environment
    /// variable CLSDF_CACHE_DIR if it is set, from the current folder if it is relative, else $XDG_CACHE_HOME/clsdf,
    /// else $HOME/.cache/clsdf. Empty (no program is kept) if CLSDF_CACHE_DIR is set to an empty string, if no folder
    /// is known, or if the driver is PoCL, which keeps programs itself, and CLSDF_CACHE_DIR is not set.
    std::string program_cache() const;

    /// The folder of two kinds of small files: records of tested programs, and markers of programs that are being
    /// compiled. It is program_cache(), except with PoCL if CLSDF_CACHE_DIR is not set: then it is
    /// $XDG_CACHE_HOME/clsdf, else $HOME/.cache/clsdf. Empty: no file is written, and every process tests anew.
    std::string record_folder() const;

    /// Sets the folder of both for programs that are built from now on: call it before the first DistanceTransform is
    /// made. With an empty string the library reads and writes only files that the caller names, and tests programs
    /// once in every process. A folder that cannot be written, or a damaged file in it, is no error: the programs are
    /// compiled and tested anew.
    void set_program_cache(const std::string& folder) const;

    /// Deletes the records and markers of this device: its programs are tested again, and those whose compilation ended
    /// a process are tried again.
    void forget_tests() const;

private:
    friend const std::shared_ptr<device::Context>& device::shared_context_of(const Device& device);
    explicit Device(std::shared_ptr<device::Context> context) : context_(std::move(context)) {}

    /// With a context and a queue of its own. Throws the exceptions of OpenCL's C++ binding.
    static Device open(const DeviceInfo& info);

    std::shared_ptr<device::Context> context_;
};

}  // namespace clsdf
