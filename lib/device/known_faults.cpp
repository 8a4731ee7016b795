#include "device/known_faults.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace clsdf::device {

namespace {

constexpr KnownFault known_faults[] = {
    // LLVM 14 takes processors after Zen 3 for a Zen 3, which lacks AVX-512, while PoCL 3.0 links built-in functions
    // made for AVX-512: "Cannot emit physreg copy instruction". With vectors of eight: "Cannot select VFPROUND".
    // PoCL 3.1 names the processor itself.
    {.platform = "Portable Computing Language",
     .version = {"PoCL 3.0", "LLVM 14"},
     .device = "AMD",
     .least_float_width = 16,
     .body = "by_vector",
     .symptom = "cannot compile vectors for AMD's processors with AVX-512 and ends the process",
     .remedy =
         "install PoCL 3.1 or later (Debian's pocl-opencl-icd; PyPI's pocl-binary-distribution ends with 3.0), or "
         "choose another device (clsdf devices lists them), or in a program Device::from_handles and "
         "TransformOptions::body = by_group"},
};

bool has(std::string_view text, std::string_view part) {
    return text.find(part) != std::string_view::npos;
}

}  // namespace

Implementation implementation_of(const cl::Device& device) {
    const cl::Platform platform(device.getInfo<CL_DEVICE_PLATFORM>());
    return {platform.getInfo<CL_PLATFORM_NAME>(), platform.getInfo<CL_PLATFORM_VERSION>(),
            device.getInfo<CL_DEVICE_NAME>(), device.getInfo<CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT>()};
}

const KnownFault* known_fault(const Implementation& implementation, std::string_view body) {
    const auto found = std::find_if(std::begin(known_faults), std::end(known_faults), [&](const KnownFault& fault) {
        return has(implementation.platform, fault.platform) && has(implementation.version, fault.version[0]) &&
               has(implementation.version, fault.version[1]) && has(implementation.device, fault.device) &&
               implementation.float_width >= fault.least_float_width && has(body, fault.body);
    });
    return found == std::end(known_faults) ? nullptr : found;
}

void refuse_known_fault(const cl::Device& device, std::string_view body) {
    const Implementation implementation = guarded([&] { return implementation_of(device); });
    if (const KnownFault* fault = known_fault(implementation, body))
        throw Error(ErrorCode::unsupported,
                    fmt::format("\"{}\" ({}) on \"{}\" {}, so the kernel body {} is not tried there; {}",
                                implementation.platform, implementation.version, implementation.device, fault->symptom,
                                body, fault->remedy));
}

std::string_view options_around_faults(const Implementation& implementation, std::string_view kernel_file) {
    // With optimisation, coarse bricks' lists hold numbers of polyhedra that do not exist; with LLVM 14, 18 and 21 they
    // are right. PoCL's pass implicit-loop-barriers makes coarse_count wrong; LLVM's own passes do not.
    const bool makes_wrong_lists = has(implementation.platform, "Portable Computing Language") &&
                                   has(implementation.version, "PoCL 7.") && has(implementation.version, "LLVM 19");
    return makes_wrong_lists && kernel_file == "coarse_lists.cl" ? " -cl-opt-disable" : "";
}

}  // namespace clsdf::device
