#pragma once

#include "core/call_mutex.hpp"
#include "device/arena.hpp"
#include "device/kernel_shelf.hpp"
#include "device/opencl.hpp"
#include "device/pinned_copies.hpp"
#include "device/prepared_programs.hpp"
#include "device/records.hpp"
#include "device/spare_arrays.hpp"

#include <clsdf/device.hpp>

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>

namespace clsdf::device {

/// A kernel file that the build has embedded.
struct KernelFile {
    std::string_view name;
    std::string_view text;
};
using KernelFiles = std::span<const KernelFile>;

/// The text of an embedded kernel file, of the core or of `beside`, with its #include "..." lines replaced by the files
/// they name, each once: OpenCL compilers look for nothing at run time.
std::string kernel_text(std::string_view file_name, KernelFiles beside = {});

/// A program before it is compiled.
struct ProgramSource {
    std::string kernel_file;
    std::string options;  ///< of clBuildProgram
    KernelFiles files{};  ///< of another library, beside the core's
};

/// Callback of a build, on the thread that waits for it. It may be empty, and may throw.
struct BuildWatch {
    std::function<void()> begins{};  ///< a program is compiled, or a part of one
    std::function<void()> tests{};   ///< a program computes a known field
};

/// One OpenCL device with its context, its queue and the programs built for it.
class Context {
public:
    Context(cl::Context context, cl::Device device, cl::CommandQueue queue);

    const cl::Context& context() const { return context_; }
    const cl::Device& device() const { return device_; }
    /// A queue in order: the caller's if it is in order, else one of the library's own.
    const cl::CommandQueue& queue() const { return queue_; }
    const cl::CommandQueue& callers_queue() const { return callers_queue_; }

    /// The properties of a device on which kernels and launches depend.
    struct Capabilities {
        unsigned compute_units = 1;
        unsigned float_width = 1;       ///< native vector width of float; 1 on most GPUs
        bool is_processor = false;      ///< shares the host's memory and runs one work-item a core
        bool has_own_memory = false;    ///< beside the host's
        bool scattered_access = false;  ///< has instructions that gather and scatter, and they are fast
        bool rounds_roots = false;      ///< can round quotients and square roots of float correctly
        bool plain_inline = false;      ///< its compiler needs helper functions without "static"
        std::size_t largest_group = 1;  ///< work-items
        std::size_t largest_allocation = 0;
        std::size_t memory = 0;
        double launch_seconds = 0.1;  ///< how long a launch may last, about: displays and cancellations wait for it
    };
    const Capabilities& capabilities() const { return capabilities_; }
    /// Before anything is computed.
    void limit_memory(std::size_t bytes);
    /// The limits and folders of another context of the device, before anything is computed.
    void take_settings(const Context& other);

    /// Builds an embedded kernel file, once per options, or takes a prepared program.
    /// Throws Error(device_failure) with the build log.
    cl::Program program(const ProgramSource& source, const BuildWatch& watch = {});

    /// Of those programs.
    KernelShelf& kernels() const { return kernels_; }

    /// All that the code of a program depends on beside the device, in a line: file, options, a hash of the text, and
    /// whether it was built from source or is a prepared one.
    std::string key_of(const cl::Program& program) const;

    /// Platform, device and driver with their versions, a line each, the last one ended. If records are kept, also the
    /// environment variables that change what compilers make: all that code depends on beside its text and options.
    std::string identity() const;
    /// Device, platform and driver with their versions, for messages. Throws cl::Error.
    std::string description() const;

    // Waits. PoCL's blocking calls, and waits for its queues, succeed if a command has failed. So each wait looks at an
    // event, and throws Error(device_failure) that names the kernels which may have failed: those that were launched
    // since the last wait. The values that the kernels have left are not used then: see failures().

    /// Waits for a command, and so for those before it in its queue. launched: kernels().launched().count() when it was
    /// enqueued. Also throws cl::Error.
    void wait(const cl::Event& event, std::size_t launched) const;
    /// Waits for all commands in queue(). Also throws cl::Error.
    void finish() const;
    /// enqueue(event): a blocking command in queue(). Also throws cl::Error.
    template <class Enqueue>
    void run_blocking(const Enqueue& enqueue) const {
        const std::size_t launched = kernels_.launched().count();
        cl::Event ended;
        enqueue(&ended);
        wait(ended, launched);
    }
    /// How many waits have found that a command had failed. Objects that keep what kernels have made note it when they
    /// are made.
    std::size_t failures() const { return failures_; }
    /// Throws Error(device_failure) that names the kernels if a command has failed since then.
    void require_none_failed(std::size_t failures) const;

    /// Returns when `to` holds `bytes` bytes of `from`, from byte `begin` on, which are computed earlier in the queue
    /// or by the milestones (PinnedCopies::read()). is_pinned: `to` is pinned memory. Also throws cl::Error.
    void read(const cl::CommandQueue& queue, const cl::Buffer& from, std::size_t begin, std::size_t bytes,
              std::byte* to, bool is_pinned = false, std::span<const Milestone> milestones = {}) const;
    /// A queue for reads while queue() computes. Throws cl::Error.
    cl::CommandQueue transfers() const { return pinned_.queue(); }

    /// Enqueues the copy of an array in the device's own memory by way of pinned memory; `from` is not needed any more
    /// when it returns. Returns false, and has done nothing, if the driver should copy. Throws cl::Error.
    bool write(const cl::CommandQueue& queue, const std::byte* from, std::size_t bytes, const cl::Buffer& to) const;

    /// Memory of the host for a few values that commands read: pinned, because some drivers let the device wait while
    /// they read into memory that is not. Null if there is none; see ReadBack.
    std::byte* take_room(std::size_t bytes) const {
        return capabilities_.has_own_memory ? pinned_.take_room(bytes) : nullptr;
    }
    void give_back_room(std::byte* room, std::size_t bytes) const { pinned_.give_back_room(room, bytes); }

    /// The memory of a device of its own, of which transforms take parts.
    Arena& arena() { return arena_; }
    SpareArrays& spare_arrays() const { return spare_arrays_; }
    /// Bytes of the host's memory that is kept for copies: pinned memory, by way of which arrays are copied, and spare
    /// arrays.
    std::size_t shared_host_bytes() const { return pinned_.bytes() + spare_arrays_.bytes(); }
    /// See Device::release_memory().
    std::size_t release_memory() { return arena_.release() + pinned_.release() + spare_arrays_.release(); }

    /// Which subjects of the self-test (checks/self_test.hpp), by name, this process need not run any more.
    bool is_tested(const std::string& subject) const;
    void set_tested(const std::string& subject);
    void forget_records();
    /// Held while a subject is tested: other threads wait.
    CallMutex& test_mutex() const { return test_mutex_; }

    /// True the first time that it is called with a kernel of that program. Compilers specialise a kernel at its first
    /// launch; after an empty launch, the next one does not wait for the compiler.
    bool is_first_use_of(const cl::Kernel& kernel);

    /// Waits for all that was enqueued in queue(), on the way out after an error. False if the driver cannot tell that
    /// it has ended: commands may then use the host's memory as long as the process lives.
    bool drain() const noexcept;
    /// As guarded(). If the function throws, drains: commands may use memory that its caller gets back.
    template <class Function>
    void run_or_drain(const Function& function) const {
        guarded([&] {
            try {
                function();
            } catch (...) {
                drain();
                throw;
            }
        });
    }
    /// Whether a drain has failed.
    bool is_lost() const noexcept { return lost_; }
    /// Throws Error(device_failure) if so.
    void require_usable() const;
    /// The same, before the first command of a call that waits for its commands. Waits for waiting runs: such a run
    /// fails if an event of its wait list does, and drivers may then leave out the commands behind it in silence.
    void begin_call() const;
    /// A run in queue() that waits for events of the caller was enqueued.
    void add_waiting_run() { ++waiting_runs_; }

    /// See Device::keep_records().
    void keep_records(const std::filesystem::path& folder);
    Records records() const;
    /// See Device::read_programs() and write_programs().
    void read_programs(const std::filesystem::path& folder);
    void write_programs(const std::filesystem::path& folder);

    /// Changes the kernels' text before it is compiled, for tests of what a wrong compiler makes.
    using TextEdit = std::function<void(std::string_view kernel_file, std::string& text)>;
    void set_text_edit(TextEdit edit) { text_edit_ = std::move(edit); }

private:
    /// Prepared or from the source, and which of both.
    struct Built {
        cl::Program program;
        std::string key;
    };

    static constexpr const char* transforms_of_device = "a transform of the call's device";

    /// A program that is built, or will be. The thread that builds it holds `building`, and no other mutex: callbacks
    /// of the caller run meanwhile.
    struct Slot {
        CallMutex building{transforms_of_device};
        std::optional<Built> built;  // is set by the holder of both mutexes, and read by the holder of one
    };

    void limit_arena();
    [[noreturn]] void throw_failed(const CommandError& error) const;
    Built build(const ProgramSource& source, const BuildWatch& watch) const;
    cl::Program compile(const ProgramSource& source, const std::string& text) const;

    cl::Context context_;
    cl::Device device_;
    cl::CommandQueue callers_queue_;
    cl::CommandQueue queue_;
    Capabilities capabilities_;
    mutable PinnedCopies pinned_;
    mutable SpareArrays spare_arrays_;
    Arena arena_;
    mutable std::mutex programs_mutex_;  // several transforms may share a device, each on a thread of its own
    std::map<std::string, Slot> programs_;
    std::set<cl_program> used_programs_;  // of those above, which stay
    mutable KernelShelf kernels_;         // of the same
    PreparedPrograms prepared_;
    Records records_{{}, {}};
    std::string identity_;
    TextEdit text_edit_;
    mutable CallMutex test_mutex_{transforms_of_device};
    mutable std::mutex tested_mutex_;
    std::set<std::string> tested_;
    mutable std::atomic<bool> lost_ = false;
    mutable std::mutex failure_mutex_;
    mutable std::string failure_;  // the latest
    mutable std::atomic<std::size_t> failures_ = 0;
    std::atomic<std::size_t> waiting_runs_ = 0;
    mutable std::atomic<std::size_t> ended_runs_ = 0;  // of those: begin_call() has waited for so many
};

/// For the library's stages. Throws Error(invalid_argument) if the device was moved from.
Context& context_of(const Device& device);
std::shared_ptr<Context> shared_context_of(const Device& device);

/// Throws cl::Error.
Context::Capabilities capabilities_of(const cl::Device& device);

}  // namespace clsdf::device

namespace clsdf::detail {

/// What a Device holds.
class DeviceContext final : public device::Context {
public:
    using Context::Context;

    static const std::shared_ptr<DeviceContext>& of(const Device& device);
    /// With a context and a queue of its own. Throws cl::Error.
    static Device open(const DeviceInfo& info);
};

}  // namespace clsdf::detail
