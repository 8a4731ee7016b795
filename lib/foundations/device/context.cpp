#include "device/context.hpp"

#include "core/refuse.hpp"
#include "core/tuning_variables.hpp"
#include "device/find/bundled_driver.hpp"
#include "device/find/requirements.hpp"
#include "kernel_sources.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <set>
#include <system_error>

#ifdef __x86_64__
#include <cpuid.h>
#endif

namespace clsdf::device {

namespace {

const KernelFile* find_file(std::string_view name, KernelFiles files) {
    const auto found =
        std::find_if(files.begin(), files.end(), [&](const KernelFile& candidate) { return candidate.name == name; });
    return found != files.end() ? &*found : nullptr;
}

void append_file(std::string_view file_name, KernelFiles beside, std::set<std::string_view>& included,
                 std::string& text) {
    const KernelFile* file = find_file(file_name, beside);
    if (file == nullptr) file = find_file(file_name, kernels::files);
    if (file == nullptr)
        throw Error(ErrorCode::device_failure, fmt::format("the kernel file {} is not part of this build", file_name));
    if (!included.insert(file->name).second) return;
    constexpr std::string_view directive = "#include \"";
    for (std::string_view rest = file->text; !rest.empty();) {
        const std::size_t end = std::min(rest.find('\n'), rest.size() - 1);
        const std::string_view line = rest.substr(0, end + 1);
        rest.remove_prefix(end + 1);
        if (line.starts_with(directive)) {
            const std::string_view named = line.substr(directive.size());
            append_file(named.substr(0, named.find('"')), beside, included, text);
        } else {
            text += line;
        }
    }
}

}  // namespace

std::string kernel_text(std::string_view file_name, KernelFiles beside) {
    std::set<std::string_view> included;
    std::string text;
    append_file(file_name, beside, included, text);
    return text;
}

namespace {

/// A smaller device can be tried out on a larger one.
template <typename Number>
void limit_by_environment(const char* name, Number& number) {
    if (const char* limit = tuning_variable(name))
        if (const std::size_t most = std::strtoull(limit, nullptr, 10); most > 0)
            number = static_cast<Number>(std::min<std::size_t>(number, most));
}

/// Whether this processor gathers and scatters fast: Intel's from Sapphire Rapids on, which are those with AVX512-FP16.
/// Earlier ones gather slowly, since their microcode keeps gathered data from leaking, and AMD's scatter in more
/// operations than single stores take.
bool gathers_and_scatters_fast() {
#ifdef __x86_64__
    constexpr unsigned features_leaf = 7, has_fp16 = 1U << 23;
    unsigned eax = 0, ebx = 0, ecx = 0, edx = 0;
    const bool is_intel = __get_cpuid(0, &eax, &ebx, &ecx, &edx) != 0 && ebx == signature_INTEL_ebx &&
                          ecx == signature_INTEL_ecx && edx == signature_INTEL_edx;
    return is_intel && __get_cpuid_count(features_leaf, 0, &eax, &ebx, &ecx, &edx) != 0 && (edx & has_fp16) != 0;
#else
    return false;
#endif
}

/// The lines of Context::identity() without the environment. Throws cl::Error.
std::string identity_of(const cl::Device& device) {
    const cl::Platform platform(device.getInfo<CL_DEVICE_PLATFORM>());
    return fmt::format("{}\n{}\n{}\n{}\n{}\n{}\n", platform.getInfo<CL_PLATFORM_NAME>(),
                       platform.getInfo<CL_PLATFORM_VERSION>(), device.getInfo<CL_DEVICE_VENDOR>(),
                       device.getInfo<CL_DEVICE_NAME>(), device.getInfo<CL_DEVICE_VERSION>(),
                       device.getInfo<CL_DRIVER_VERSION>());
}

/// A relative path would be another one whenever the program goes to another folder. Empty if it cannot be found.
std::filesystem::path absolute_of(const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::path absolute = folder.empty() ? folder : std::filesystem::absolute(folder, error);
    if (error) absolute.clear();
    return absolute;
}

/// The compiler's log, as the end of a sentence; a remedy if the log is empty.
std::string build_log(const cl::Program& program, const cl::Device& device) {
    std::string log;
    try {
        log = program.getBuildInfo<CL_PROGRAM_BUILD_LOG>(device);
    } catch (const cl::Error&) {
        // As good as an empty one.
    }
    if (log.find_first_not_of(" \t\r\n") != std::string::npos) return ":\n" + log;
    return " nothing; update the driver, or choose another device (clsdf devices lists them)";
}

}  // namespace

Context::Capabilities capabilities_of(const cl::Device& device) {
    Context::Capabilities capabilities;
    capabilities.compute_units = device.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>();
    capabilities.float_width = device.getInfo<CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT>();
    capabilities.is_processor = (device.getInfo<CL_DEVICE_TYPE>() & CL_DEVICE_TYPE_CPU) != 0;
    capabilities.has_own_memory = device.getInfo<CL_DEVICE_HOST_UNIFIED_MEMORY>() == CL_FALSE;
    capabilities.scattered_access = capabilities.is_processor && gathers_and_scatters_fast();
    capabilities.rounds_roots =
        (device.getInfo<CL_DEVICE_SINGLE_FP_CONFIG>() & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
    // Oclgrind's compiler turns static functions into instructions that its simulator does not know.
    capabilities.plain_inline = platform_name(device) == "Oclgrind";
    capabilities.largest_group = device.getInfo<CL_DEVICE_MAX_WORK_GROUP_SIZE>();
    capabilities.largest_allocation = device.getInfo<CL_DEVICE_MAX_MEM_ALLOC_SIZE>();
    capabilities.memory = device.getInfo<CL_DEVICE_GLOBAL_MEM_SIZE>();
    limit_by_environment("CLSDF_MAX_ALLOCATION", capabilities.largest_allocation);
    limit_by_environment("CLSDF_MAX_FLOAT_WIDTH", capabilities.float_width);
    return capabilities;
}

void Context::limit_memory(std::size_t bytes) {
    capabilities_.memory = std::min(capabilities_.memory, bytes);
    capabilities_.largest_allocation = std::min(capabilities_.largest_allocation, bytes);
    limit_arena();
}

void Context::take_settings(const Context& other) {
    capabilities_.memory = std::min(capabilities_.memory, other.capabilities_.memory);
    capabilities_.largest_allocation =
        std::min(capabilities_.largest_allocation, other.capabilities_.largest_allocation);
    limit_arena();
    const std::scoped_lock lock(other.programs_mutex_);
    records_ = other.records_;
    prepared_ = other.prepared_;
    identity_ = other.identity_;
}

void Context::limit_arena() {
    if (!capabilities_.has_own_memory || capabilities_.is_processor) return;
    // What is kept is enough for the next transform of the same size, and a small part of a GPU's memory. A block is so
    // small a part that what is not lent of it is not missed.
    constexpr std::size_t most_kept = std::size_t{1} << 29, most_of_a_block = std::size_t{1} << 25;
    constexpr std::size_t share_kept = 32, share_of_a_block = 64, bits_of_a_byte = 8, least_alignment = 256;
    const std::size_t bits = device_.getInfo<CL_DEVICE_MEM_BASE_ADDR_ALIGN>();
    arena_.set_limits({.kept_bytes = std::min(capabilities_.memory / share_kept, most_kept),
                       .block_bytes = std::min({capabilities_.memory / share_of_a_block, most_of_a_block,
                                                capabilities_.largest_allocation}),
                       .alignment = std::max(bits / bits_of_a_byte, least_alignment)});
}

Context::Context(cl::Context context, cl::Device device, cl::CommandQueue queue)
    : context_(std::move(context)),
      device_(std::move(device)),
      callers_queue_(std::move(queue)),
      queue_(callers_queue_),
      pinned_(context_, device_) {
    guarded([&] {
        if (const std::string reason = missing_feature(device_); !reason.empty())
            refuse_unsupported("the device \"{}\" cannot be used: {}; choose another one",
                               device_.getInfo<CL_DEVICE_NAME>(), reason);
        capabilities_ = capabilities_of(device_);
        limit_arena();
        identity_ = identity_of(device_);
        if (is_bundled(device_)) prepared_.read_first(bundled_programs(device_));
        if (callers_queue_.getInfo<CL_QUEUE_PROPERTIES>() & CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE)
            queue_ = cl::CommandQueue(context_, device_);
    });
}

namespace {

/// Of a call that waits. Some drivers, as NVIDIA's, let it fail if a kernel has; then `fail` throws what is known.
template <class Fail>
[[noreturn]] void throw_from_wait(const cl::Error& error, const Fail& fail) {
    try {
        throw_device_error(error);
    } catch (const Error& of_call) {
        if (of_call.code() != ErrorCode::device_failure) throw;
        try {
            fail();
        } catch (const Error& failed) {
            throw Error(failed.code(), fmt::format("{}; perhaps {}", of_call.what(), failed.what()), error.err());
        }
        throw;
    }
}

}  // namespace

void Context::read(const cl::CommandQueue& queue, const cl::Buffer& from, std::size_t begin, std::size_t bytes,
                   std::byte* to, bool is_pinned, std::span<const Milestone> milestones) const {
    const std::size_t launched = kernels_.launched().count();
    try {
        if (capabilities_.has_own_memory && !is_pinned) {
            pinned_.read(queue, from, begin, bytes, to, milestones);
        } else {
            std::size_t done = 0;
            for (const Milestone& milestone : milestones) {
                read_blocking(queue, from, begin + done, milestone.end - done, to + done, milestone.reached);
                done = milestone.end;
            }
            if (done < bytes) read_blocking(queue, from, begin + done, bytes - done, to + done);
        }
    } catch (const CommandError& error) {
        throw_failed(error);
    } catch (const cl::Error& error) {
        throw_from_wait(error, [&] { throw_failed(CommandError(error.err())); });
    }
    if (queue() == queue_()) kernels_.launched().forget(launched);
}

bool Context::write(const cl::CommandQueue& queue, const std::byte* from, std::size_t bytes,
                    const cl::Buffer& to) const {
    try {
        return capabilities_.has_own_memory && pinned_.write(queue, from, bytes, to);
    } catch (const CommandError& error) {
        throw_failed(error);
    } catch (const cl::Error& error) {
        throw_from_wait(error, [&] { throw_failed(CommandError(error.err())); });
    }
}

void Context::wait(const cl::Event& event, std::size_t launched) const {
    try {
        wait_for(event);
    } catch (const CommandError& error) {
        throw_failed(error);
    } catch (const cl::Error& error) {
        throw_from_wait(error, [&] { throw_failed(CommandError(error.err())); });
    }
    kernels_.launched().forget(launched);
}

void Context::finish() const {
    const std::size_t launched = kernels_.launched().count();
    cl::Event end;
    queue_.enqueueMarkerWithWaitList(nullptr, &end);
    try {
        queue_.finish();
    } catch (const cl::Error& error) {
        throw_from_wait(error, [&] { throw_failed(CommandError(error.err())); });
    }
    wait(end, launched);
}

void Context::throw_failed(const CommandError& error) const {
    const std::scoped_lock lock(failure_mutex_);
    ++failures_;
    const std::size_t launched = kernels_.launched().count();
    const std::string names = kernels_.launched().names();
    kernels_.launched().forget(launched);
    // PoCL's status of a command that did not run because of another, whose status it does not tell, is -1.
    const bool has_code = error.err() != -1 && error.err() != CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST;
    const std::string text =
        fmt::format("{} failed on \"{}\"{}", names.empty() ? "a command" : "the kernel " + names,
                    device_.getInfo<CL_DEVICE_NAME>(), has_code ? fmt::format(" ({})", code_name(error.err())) : "");
    // Later commands may fail for the same reason.
    if (!names.empty() || failure_.empty()) failure_ = text;
    throw Error(ErrorCode::device_failure,
                text + "; update the driver, or choose another device (clsdf devices lists them)", error.err());
}

void Context::require_none_failed(std::size_t failures) const {
    if (failures == failures_) return;
    const std::scoped_lock lock(failure_mutex_);
    throw Error(ErrorCode::device_failure,
                fmt::format("what the transform or plan has kept may be wrong, because of an earlier call: {}; make "
                            "the transform and its plans anew",
                            failure_));
}

void Context::require_usable() const {
    if (lost_)
        throw Error(ErrorCode::device_failure,
                    fmt::format("\"{}\" cannot be used any more in this process: an earlier call of OpenCL failed, and "
                                "its commands may still use memory of the host; start the program again",
                                device_.getInfo<CL_DEVICE_NAME>()));
}

void Context::begin_call() const {
    require_usable();
    const std::size_t runs = waiting_runs_;
    if (runs == ended_runs_) return;
    guarded([&] { queue_.finish(); });
    ended_runs_ = runs;
}

bool Context::drain() const noexcept {
    if (lost_) return false;
    cl::Event end;
    const bool has_end = clEnqueueMarkerWithWaitList(queue_(), 0, nullptr, &end()) == CL_SUCCESS;
    if (clFinish(queue_()) != CL_SUCCESS) lost_ = true;
    try {
        if (has_end && !lost_) wait(end, kernels_.launched().count());
    } catch (const std::exception&) {
        // On the way out after another error; failures() counts it.
    }
    return !lost_;
}

void Context::keep_records(const std::filesystem::path& folder) {
    guarded([&] {
        std::filesystem::path absolute = absolute_of(folder);
        std::string identity = identity_of(device_);
        if (!absolute.empty()) identity += compiler_environment();
        const std::scoped_lock lock(programs_mutex_);
        identity_ = std::move(identity);
        records_ = Records(std::move(absolute), ".tested");
    });
}

void Context::read_programs(const std::filesystem::path& folder) {
    const std::scoped_lock lock(programs_mutex_);
    prepared_.read_from(absolute_of(folder));
}

void Context::write_programs(const std::filesystem::path& folder) {
    const std::scoped_lock lock(programs_mutex_);
    prepared_.write_to(absolute_of(folder));
}

std::string Context::description() const {
    const cl::Platform platform(device_.getInfo<CL_DEVICE_PLATFORM>());
    return fmt::format("\"{}\" (platform {}, {}, driver {})", device_.getInfo<CL_DEVICE_NAME>(),
                       platform.getInfo<CL_PLATFORM_NAME>(), platform.getInfo<CL_PLATFORM_VERSION>(),
                       device_.getInfo<CL_DRIVER_VERSION>());
}

std::string Context::identity() const {
    const std::scoped_lock lock(programs_mutex_);
    return identity_;
}

Records Context::records() const {
    const std::scoped_lock lock(programs_mutex_);
    return records_;
}

bool Context::is_tested(const std::string& test_case) const {
    const std::scoped_lock lock(tested_mutex_);
    return tested_.contains(test_case);
}
void Context::set_tested(const std::string& test_case) {
    const std::scoped_lock lock(tested_mutex_);
    tested_.insert(test_case);
}
void Context::forget_records() {
    const std::scoped_lock lock(tested_mutex_);
    tested_.clear();
}

cl::Program Context::program(const ProgramSource& source, const BuildWatch& watch) {
    std::unique_lock lock(programs_mutex_);
    Slot& slot = programs_[fmt::format("{} {}", source.kernel_file, source.options)];
    lock.unlock();
    const std::scoped_lock building(slot.building);
    if (!slot.built) {
        Built made = build(source, watch);
        lock.lock();
        slot.built = std::move(made);
    }
    return slot.built->program;
}

Context::Built Context::build(const ProgramSource& source, const BuildWatch& watch) const {
    std::unique_lock lock(programs_mutex_);
    const PreparedPrograms prepared = prepared_;
    lock.unlock();
    std::string text = kernel_text(source.kernel_file, source.files);
    if (text_edit_) text_edit_(source.kernel_file, text);
    const std::string key = fmt::format("{} {} {:016x}", source.kernel_file, source.options, hash_of(text));
    if (const std::optional<cl::Program> program = prepared.find(context_, device_, source.options, text))
        return {*program, key + " prepared"};
    if (is_bundled(device_))
        refuse_unsupported(
            "{} with the options \"{}\" is not among the programs that are bundled with clsdf for this "
            "processor, and the bundled driver has no compiler; for this call {}",
            source.kernel_file, source.options, how_to_install);
    if (watch.begins) watch.begins();
    const cl::Program program = compile(source, text);
    const cl::Program written = prepared.write(program, context_, device_, source.options, text);
    return {written, key + (written() == program() ? " source" : " prepared")};
}

std::string Context::key_of(const cl::Program& program) const {
    const std::scoped_lock lock(programs_mutex_);
    for (const auto& [name, slot] : programs_)
        if (slot.built && slot.built->program() == program()) return slot.built->key;
    return {};
}

bool Context::is_first_use_of(const cl::Kernel& kernel) {
    const std::scoped_lock lock(programs_mutex_);
    return used_programs_.insert(kernel.getInfo<CL_KERNEL_PROGRAM>()()).second;
}

cl::Program Context::compile(const ProgramSource& source, const std::string& text) const {
    cl::Program program(context_, text);
    // The binding's build() asks for a log in any case, and reports that there is none in place of the failure.
    // No warnings: PoCL writes their number to standard error.
    const cl_int code = clBuildProgram(program(), 1, &device_(), (source.options + " -w").c_str(), nullptr, nullptr);
    if (code == CL_SUCCESS) return program;
    throw Error(
        ErrorCode::device_failure,
        fmt::format("the OpenCL call clBuildProgram failed for {}: {}; options \"{}\" on \"{}\"; the compiler said{}",
                    source.kernel_file, code_name(code), source.options, device_.getInfo<CL_DEVICE_NAME>(),
                    build_log(program, device_)),
        code);
}

}  // namespace clsdf::device
