#include "device/prepared_programs.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <vector>

namespace clsdf::device {

namespace {

constexpr std::string_view pocl = "Portable Computing Language";

/// The text behind the mark; empty if the mark is not there.
std::string_view behind(std::string_view text, std::string_view mark) {
    const std::size_t found = text.find(mark);
    return found == text.npos ? std::string_view() : text.substr(found + mark.size());
}

/// "6.0" of "OpenCL 3.0 PoCL 6.0  Linux, ..., LLVM 18.1.8, ...": the form of its binaries depends on it.
std::string_view pocl_version(std::string_view platform_version) {
    const std::string_view version = behind(platform_version, "PoCL ");
    return version.substr(0, version.find_first_not_of("0123456789."));
}

/// "cpu-x86_64-pc-linux-gnu-haswell" of "OpenCL 3.0 PoCL HSTR: cpu-...", in the bundled driver
/// "cpu-x86_64-clsdf-x86-64-v3": PoCL takes binaries that have the same text.
std::string_view hash_text(std::string_view device_version) {
    return behind(device_version, "HSTR: ");
}

std::optional<cl::Program> from_binary(const std::string& binary, const cl::Context& context, const cl::Device& device,
                                       const std::string& options) {
    try {
        const cl::Program program(context, {device}, {std::vector<unsigned char>(binary.begin(), binary.end())});
        if (clBuildProgram(program(), 1, &device(), options.c_str(), nullptr, nullptr) == CL_SUCCESS) return program;
    } catch (const cl::Error&) {
        // Refused.
    }
    return std::nullopt;
}

/// Empty if the driver gives none. A context may have devices beside the one that the program was built for, whose
/// binaries are empty.
std::string binary_of(const cl::Program& program) {
    try {
        for (const std::vector<unsigned char>& binary : program.getInfo<CL_PROGRAM_BINARIES>())
            if (!binary.empty()) return {binary.begin(), binary.end()};
    } catch (const cl::Error&) {
        // As good as none.
    }
    return {};
}

}  // namespace

std::string compiler_environment() {
    std::string values;
    for (const char* name :
         {"POCL_WORK_GROUP_METHOD", "POCL_KERNELLIB_NAME", "POCL_WORK_GROUP_SPECIALIZATION", "POCL_PREGION_VALUE_REMAT",
          "POCL_FORCE_PARALLEL_OUTER_LOOP", "AMD_OCL_BUILD_OPTIONS", "AMD_OCL_BUILD_OPTIONS_APPEND",
          "IGC_EnableDPEmulation", "OverrideDefaultFP64Settings", "NEO_FP64_EMULATION"})
        if (const char* value = std::getenv(name)) values += fmt::format("{}={}\n", name, value);
    return values;
}

std::string processor_level(const cl::Device& device) {
    const std::string version = device.getInfo<CL_DEVICE_VERSION>();
    const std::string_view target = hash_text(version), of_installed = behind(target, "-gnu-");
    return std::string(of_installed.empty() ? behind(target, "-clsdf-") : of_installed);
}

std::string target_of(const cl::Device& device) {
    const cl::Platform platform(device.getInfo<CL_DEVICE_PLATFORM>());
    const std::string name = platform.getInfo<CL_PLATFORM_NAME>(), version = platform.getInfo<CL_PLATFORM_VERSION>();
    if (name == pocl)
        return fmt::format("{}\n{}\n{}", name, pocl_version(version), hash_text(device.getInfo<CL_DEVICE_VERSION>()));
    return fmt::format("{}\n{}\n{}\n{}\n{}", name, version, device.getInfo<CL_DEVICE_NAME>(),
                       device.getInfo<CL_DEVICE_VERSION>(), device.getInfo<CL_DRIVER_VERSION>());
}

std::string program_key(std::string_view target, std::string_view environment, std::string_view options,
                        std::string_view text) {
    return fmt::format("{}\n{}{}\n{}", target, environment, options, text);
}

std::optional<cl::Program> PreparedPrograms::find(const cl::Context& context, const cl::Device& device,
                                                  const std::string& options, const std::string& source) const {
    std::optional<std::string> binary;
    if (!bundled_.folder().empty()) binary = bundled_.find(program_key(target_of(device), "", options, source));
    if (!binary && !read_.folder().empty())
        binary = read_.find(program_key(target_of(device), compiler_environment(), options, source));
    return binary ? from_binary(*binary, context, device, options) : std::nullopt;
}

cl::Program PreparedPrograms::write(const cl::Program& program, const cl::Context& context, const cl::Device& device,
                                    const std::string& options, const std::string& source) const {
    if (written_.folder().empty()) return program;
    const std::string binary = binary_of(program);
    if (binary.empty()) return program;
    written_.store(program_key(target_of(device), compiler_environment(), options, source), binary);
    return from_binary(binary, context, device, options).value_or(program);
}

}  // namespace clsdf::device
