#include "device/prepared_programs.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <vector>

namespace clsdf::device {

namespace {

/// Throws cl::Error.
std::string key_of(const cl::Device& device, const std::string& options, const std::string& source) {
    const cl::Platform platform(device.getInfo<CL_DEVICE_PLATFORM>());
    const std::string name = platform.getInfo<CL_PLATFORM_NAME>();
    // The version of a device of PoCL ends with the processor's level, its name with the model.
    return fmt::format("{}\n{}\n{}\n{}\n{}\n{}{}\n{}", name, platform.getInfo<CL_PLATFORM_VERSION>(),
                       name == "Portable Computing Language" ? "" : device.getInfo<CL_DEVICE_NAME>(),
                       device.getInfo<CL_DEVICE_VERSION>(), device.getInfo<CL_DRIVER_VERSION>(), compiler_environment(),
                       options, source);
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
    for (const char* name : {"POCL_WORK_GROUP_METHOD", "POCL_KERNELLIB_NAME", "POCL_WORK_GROUP_SPECIALIZATION",
                             "POCL_PREGION_VALUE_REMAT", "POCL_FORCE_PARALLEL_OUTER_LOOP", "AMD_OCL_BUILD_OPTIONS",
                             "AMD_OCL_BUILD_OPTIONS_APPEND", "IGC_EnableDPEmulation", "OverrideDefaultFP64Settings"})
        if (const char* value = std::getenv(name)) values += fmt::format("{}={}\n", name, value);
    return values;
}

std::optional<cl::Program> PreparedPrograms::find(const cl::Context& context, const cl::Device& device,
                                                  const std::string& options, const std::string& source) const {
    if (read_.folder().empty()) return std::nullopt;
    const std::optional<std::string> binary = read_.find(key_of(device, options, source));
    return binary ? from_binary(*binary, context, device, options) : std::nullopt;
}

cl::Program PreparedPrograms::write(const cl::Program& program, const cl::Context& context, const cl::Device& device,
                                    const std::string& options, const std::string& source) const {
    if (written_.folder().empty()) return program;
    const std::string binary = binary_of(program);
    if (binary.empty()) return program;
    written_.store(key_of(device, options, source), binary);
    return from_binary(binary, context, device, options).value_or(program);
}

}  // namespace clsdf::device
