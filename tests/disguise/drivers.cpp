// Drivers that are not at hand: PoCL with two devices gives their answers.
#include "support/supposes.hpp"
#include "support/throws.hpp"

#include <clsdf/device.hpp>

#include "device/context.hpp"
#include "disguise/disguise.hpp"

#include <cstdlib>
#include <string>
#include <vector>

using namespace clsdf;
using clsdf::disguise::Answers;
using clsdf::test::check_throws;

namespace {

/// PoCL tells two devices, from before the first call of OpenCL on.
struct TwoDevices {
    TwoDevices() { ::setenv("POCL_DEVICES", "pthread basic", 1); }
};
BOOST_TEST_GLOBAL_FIXTURE(TwoDevices);

/// Drivers' answers for as long as this lives.
class Drivers {
public:
    explicit Drivers(const disguise::Settings& settings) { disguise::set(settings); }
    ~Drivers() { disguise::set({}); }
    Drivers(const Drivers&) = delete;
    Drivers& operator=(const Drivers&) = delete;
};

constexpr unsigned intel = 0x8086, nvidia = 0x10DE;

Answers gpu(const std::string& name, unsigned vendor, unsigned units, unsigned megahertz, bool has_own_memory) {
    return {{{CL_DEVICE_NAME, name}},
            {{CL_DEVICE_TYPE, CL_DEVICE_TYPE_GPU},
             {CL_DEVICE_VENDOR_ID, vendor},
             {CL_DEVICE_MAX_COMPUTE_UNITS, units},
             {CL_DEVICE_MAX_CLOCK_FREQUENCY, megahertz},
             {CL_DEVICE_HOST_UNIFIED_MEMORY, has_own_memory ? CL_FALSE : CL_TRUE}}};
}

/// Device::strongest() of two devices, in either order.
void check_best(const Answers& best, const Answers& other) {
    const std::string name = best.texts.at(CL_DEVICE_NAME);
    for (const bool is_first : {true, false}) {
        const Drivers drivers({.devices = is_first ? std::vector{best, other} : std::vector{other, best}});
        BOOST_TEST_REQUIRE(Device::all().size() == 2U);
        BOOST_TEST(Device::strongest().name() == name);
    }
}

/// Both devices have these answers, so none is usable.
void check_unusable(const Answers& answers, const std::string& why_not, const Answers& platform = {}) {
    // As the caller's handles, from before the driver's answers.
    const Device device = Device::strongest();
    const Drivers drivers({.platform = platform, .devices = {answers, answers}});
    for (const DeviceInfo& info : Device::all()) BOOST_TEST(info.why_not == why_not);
    // Another device or driver may have what is missing.
    check_throws(ErrorCode::no_device, {why_not, "install an OpenCL driver"}, [] { Device::strongest(); });
    check_throws(ErrorCode::no_device, {why_not}, [] { Device::select("0"); });
    check_throws(ErrorCode::unsupported, {why_not, "choose another"},
                 [&] { Device::from_handles(device.context(), device.id(), device.queue()); });
}

}  // namespace

BOOST_AUTO_TEST_SUITE(drivers_that_are_not_at_hand, *boost::unit_test::precondition(clsdf::test::on_pocl))

BOOST_AUTO_TEST_CASE(opencl_1_1_is_refused_in_any_driver) {
    const std::string why_not = "it has OpenCL 1.1, and 1.2 is needed";
    Answers clover{
        {{CL_DEVICE_NAME, "AMD Radeon RX 6650 XT (radeonsi, navi23)"}, {CL_DEVICE_VERSION, "OpenCL 1.1 Mesa 22.3.6"}}};
    check_unusable(clover, why_not);
    {
        const Drivers drivers({.devices = {clover, clover}});
        BOOST_TEST(Device::all().front().memory > 0U);
    }
    // It need not know the questions of later versions.
    clover.refused = {CL_DEVICE_DOUBLE_FP_CONFIG, CL_DEVICE_HOST_UNIFIED_MEMORY};
    check_unusable(clover, why_not);
}

BOOST_AUTO_TEST_CASE(later_versions_are_not_refused) {
    for (const char* version : {"OpenCL 1.2 CUDA", "OpenCL 2.0 AMD-APP (3406.0)", "OpenCL 3.0 ", "OpenCL 1.10 NEO",
                                "OpenCL 12.0", "no version"}) {
        const Answers answers{{{CL_DEVICE_VERSION, version}}};
        const Drivers drivers({.devices = {answers, answers}});
        for (const DeviceInfo& info : Device::all()) BOOST_TEST(info.usable(), version << ": " << info.why_not);
    }
}

BOOST_AUTO_TEST_CASE(a_device_without_double_precision_is_refused_with_the_reason) {
    const std::string why_not = "it has no double precision (cl_khr_fp64)";
    Answers device;
    device.numbers[CL_DEVICE_DOUBLE_FP_CONFIG] = 0;
    check_unusable(device, why_not);
    check_unusable(
        device, why_not + "; from Mesa 23.2 on, RUSTICL_FEATURES=fp64 in the environment enables it, as an experiment",
        {{{CL_PLATFORM_NAME, "rusticl"}}});
    // Or it refuses the question.
    device.refused = {CL_DEVICE_DOUBLE_FP_CONFIG};
    device.texts[CL_DEVICE_EXTENSIONS] = "cl_khr_byte_addressable_store cl_khr_fp64_not";
    check_unusable(device, why_not);
    device.texts[CL_DEVICE_EXTENSIONS] = "cl_khr_byte_addressable_store cl_khr_fp64";
    const Drivers drivers({.devices = {device, device}});
    for (const DeviceInfo& info : Device::all()) BOOST_TEST((info.fp64 && info.usable()));
}

BOOST_AUTO_TEST_CASE(a_platform_without_devices_is_named_with_a_remedy) {
    for (const std::string platform :
         {"rusticl", "Portable Computing Language", "AMD Accelerated Parallel Processing"}) {
        const Drivers drivers({.platform = {{{CL_PLATFORM_NAME, platform}}}, .without_devices = true});
        BOOST_TEST(Device::all().empty());
        std::vector<std::string> fragments{
            "no OpenCL device was found", platform, "has no devices", "/dev/dri", "render", "pocl-opencl-icd"};
        if (platform == "rusticl") fragments.emplace_back("RUSTICL_ENABLE=radeonsi");
        if (platform == "Portable Computing Language") fragments.emplace_back("POCL_CACHE_DIR");
        check_throws(ErrorCode::no_device, fragments, [] { Device::strongest(); });
        check_throws(ErrorCode::no_device, fragments, [] { Device::select("0"); });
    }
}

BOOST_AUTO_TEST_CASE(gpus_with_memory_of_their_own_are_the_strongest) {
    const Answers integrated = gpu("Intel(R) Arc(TM) Graphics", intel, 128, 2250, false);
    check_best(gpu("NVIDIA GeForce RTX 4070 Laptop GPU", nvidia, 36, 2175, true), integrated);
    check_best(gpu("NVIDIA T500", nvidia, 14, 1125, true), integrated);
}

BOOST_AUTO_TEST_CASE(an_execution_unit_of_intel_counts_eight_lanes_and_a_multiprocessor_sixty_four) {
    const Answers small_nvidia = gpu("NVIDIA T1000", nvidia, 14, 1395, true);
    const Answers large_nvidia = gpu("NVIDIA GeForce RTX 4090", nvidia, 128, 2520, true);
    const Answers arc = gpu("Intel(R) Arc(TM) A770 Graphics", intel, 512, 2400, true);
    check_best(arc, small_nvidia);
    check_best(large_nvidia, arc);
}

BOOST_AUTO_TEST_CASE(processors_come_before_accelerators_also_without_a_clock) {
    const Answers processor{{{CL_DEVICE_NAME, "Intel(R) Xeon(R) Processor"}}, {{CL_DEVICE_MAX_CLOCK_FREQUENCY, 0}}};
    const Answers emulator{{{CL_DEVICE_NAME, "Intel(R) FPGA Emulation Device"}},
                           {{CL_DEVICE_TYPE, CL_DEVICE_TYPE_ACCELERATOR}}};
    check_best(processor, emulator);
    const Answers large{{{CL_DEVICE_NAME, "larger"}},
                        {{CL_DEVICE_MAX_CLOCK_FREQUENCY, 0}, {CL_DEVICE_MAX_COMPUTE_UNITS, 3000}}};
    const Answers small{{{CL_DEVICE_NAME, "smaller"}},
                        {{CL_DEVICE_MAX_CLOCK_FREQUENCY, 2000}, {CL_DEVICE_MAX_COMPUTE_UNITS, 1}}};
    check_best(large, small);
}

BOOST_AUTO_TEST_CASE(a_compiler_that_says_nothing_is_an_error_with_a_remedy) {
    const Device device = Device::strongest();
    disguise::restart({.call = "clBuildProgram", .number = 1, .code = CL_BUILD_PROGRAM_FAILURE});
    check_throws(ErrorCode::device_failure,
                 {"clBuildProgram", "CL_BUILD_PROGRAM_FAILURE", "said nothing", "update the driver"}, [&] {
                     device::context_of(device).program({"scan.cl", "-cl-std=CL1.2"});
                 });
    disguise::restart();
}

BOOST_AUTO_TEST_SUITE_END()
