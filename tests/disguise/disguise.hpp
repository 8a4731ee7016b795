#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

/// A library between a program and the loader of OpenCL, by LD_PRELOAD or linked before it. It makes processors answer
/// as GPUs with memory of their own, counts calls and bytes, and makes calls fail on purpose. Thread-safe.
///
/// A program that does not know of it is told by the environment:
///   CLSDF_DISGUISE=gpu            as Settings::gpu
///   CLSDF_DISGUISE=pocl-3.0       as Settings::pocl_3_0
///   CLSDF_DISGUISE_PLATFORMS=0    as Settings::without_platforms
///   CLSDF_DISGUISE_INTEL=NAME     the first device is a GPU of Intel with this name, in Settings::devices
///   CLSDF_DISGUISE_UNITS=NUMBER   as Settings::compute_units
///   CLSDF_DISGUISE_EXTERNAL=memory, memory+semaphores or memory+unshared-semaphores   as Settings::external_memory,
///                                 external_semaphores and unshared_semaphores
///   CLSDF_DISGUISE_COUNTS=FILE    each process appends its counts to the file when it ends, a line of JSON
///   CLSDF_DISGUISE_FAULT=[CALL:]NUMBER[+]   as Fault; + for `onwards`; CALL is `kernel` for in_kernel
///   CLSDF_DISGUISE_CODE=CODE      as Fault::code
namespace clsdf::disguise {

/// Answers in place of a driver's own, by the number of the question, e.g. CL_DEVICE_NAME. The number of a question
/// that the driver does not know is a cl_uint.
struct Answers {
    std::map<unsigned, std::string> texts{};
    std::map<unsigned, std::uint64_t> numbers{};
    std::set<unsigned> refused{};  ///< with CL_INVALID_VALUE
};

/// The properties of the simulated GPU: its type, vectors of one float, groups of at most 128 work-items, launches of
/// at most 65,535 groups along y and z and fewer than 2^32 work-items, 48 KiB of local memory, and memory that is not
/// the host's, which a buffer gets at its first use by a command, as NVIDIA's do. New buffers, and memory that is
/// mapped to be overwritten, hold bytes of 0xFF. Mapped memory is a copy, which ends with the mapping;
/// CL_MEM_USE_HOST_PTR copies at creation and while it is mapped.
struct Settings {
    bool gpu = false;
    unsigned compute_units = 0;        ///< of a GPU; 0: as many as the processor has
    bool pocl_3_0 = false;             ///< names and versions are those of PoCL 3.0 on a Zen 4, whose compiler crashes
    Answers platform{};                ///< of every platform
    std::vector<Answers> devices{};    ///< of the first device, the second, ...
    bool without_platforms = false;    ///< the loader lists none, as without files in /etc/OpenCL/vendors
    bool without_devices = false;      ///< platforms have none
    bool external_memory = false;      ///< a GPU takes memory of the stand-in for CUDA's driver (cuda/driver.cpp)
    bool external_semaphores = false;  ///< and shares semaphores with it
    bool unshared_semaphores = false;  ///< whose signals do not reach the other driver, with external_semaphores
    /// What depends on the driver's threads is the same in each run: commands that have ended are said to run, and the
    /// functions for buffers that are gone are called by restart().
    bool ends_late = false;
    std::uint64_t memory =
        UINT64_MAX;  ///< bytes of a GPU; a first use beyond fails with CL_MEM_OBJECT_ALLOCATION_FAILURE
};

/// To be called before the first call of OpenCL.
void set(const Settings& settings);

/// The call that fails: number `number`, counted from 1 since restart(), of the calls named `call`, or of all calls if
/// `call` is empty. A call that fails has no other effect. clRetain... and clRelease... never fail and are not counted:
/// OpenCL does not define the reference count after their failure, and the C++ binding releases the object twice.
struct Fault {
    std::string call{};
    std::uint64_t number = 0;  ///< 0: none fails
    int code = -5;             ///< CL_OUT_OF_RESOURCES
    bool onwards = false;      ///< and all of these calls after it
    bool in_kernel = false;    ///< the call, clEnqueueNDRangeKernel, succeeds, and its kernel fails: see failing.hpp
};

struct KernelCounts {
    std::uint64_t launches = 0;
    std::uint64_t runs = 0;  ///< launches that follow another kernel's, or none: a stage may be divided into launches
    std::uint64_t work_items = 0;
};

struct Counts {
    std::map<std::string, std::uint64_t> calls;   ///< by name, those that failed on purpose included
    std::map<std::string, KernelCounts> kernels;  ///< by name
    std::uint64_t all_calls = 0;
    std::uint64_t blocking_waits = 0;  ///< clFinish, clWaitForEvents, and blocking transfers and mappings
    std::uint64_t pinned_reads = 0;  ///< waits, not counted above, for reads of many bytes into mapped (pinned) memory
    std::uint64_t launches = 0;      ///< kernels
    std::uint64_t fills = 0;
    std::uint64_t copies = 0;  ///< within the device
    std::uint64_t transfers_up = 0, transfers_down = 0;
    std::uint64_t bytes_up = 0, bytes_down = 0;
    std::uint64_t pageable_bytes = 0;  ///< of those, by host pointers in no mapping: of memory that is not pinned
    std::uint64_t commands = 0;        ///< launches, fills, copies, reads, writes, maps and their ends
    std::uint64_t allocations = 0;     ///< buffers
    std::uint64_t first_uses = 0;      ///< commands that are the first to use a buffer of a GPU
    std::uint64_t allocated_bytes = 0;
    std::uint64_t peak_bytes = 0;  ///< the most that buffers had at once, with those of before; not of memory that is
                                   ///< the host's
    std::uint64_t programs_built = 0;
    std::uint64_t host_ns = 0;  ///< see time_host()
    std::string failed;         ///< the first call, or the kernel, that failed on purpose; empty: none
};

/// The counts since restart().
Counts counts();
/// Resets the counts and the numbers of calls, and sets the calls that fail.
void restart(const Fault& fault = {});

/// Counts, from now to end_host_time(), the processor time of the calling thread between calls of OpenCL: from the
/// return of one to the begin of the next, without the clock's own cost. Other threads are not counted: the caller
/// holds oneTBB to one. To be called after restart().
void time_host();
void end_host_time();

/// Whether this thread is in a call of OpenCL.
bool is_in_call();

/// Counts as one line of JSON.
std::string to_json(const Counts& counts);

}  // namespace clsdf::disguise
