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

/// A variable of the environment for as long as this lives.
class Variable {
public:
    Variable(const char* name, const char* value) : name_(name) { ::setenv(name, value, 1); }
    ~Variable() { ::unsetenv(name_); }
    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;

private:
    const char* name_;
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

/// A GPU of Intel's driver from 2021 on, which has double precision or says so.
Answers gpu_of_intel(unsigned pci_number) {
    constexpr unsigned pci_number_of_intel = 0x4251;  // CL_DEVICE_ID_INTEL
    Answers answers = gpu("Intel(R) Graphics", intel, 512, 2400, true);
    answers.texts[CL_DEVICE_EXTENSIONS] = "cl_khr_fp64 cl_intel_device_attribute_query";
    answers.numbers[pci_number_of_intel] = pci_number;
    return answers;
}

const Answers processor{{{CL_DEVICE_NAME, "Intel(R) Xeon(R) Processor"}}, {{CL_DEVICE_VENDOR_ID, intel}}};

/// The GPU is listed with the reason, never taken by itself, and used if it is named.
void check_used_only_if_named(const Answers& gpu, const std::vector<std::string>& reason) {
    const std::string name = gpu.texts.at(CL_DEVICE_NAME);
    {
        const Drivers drivers({.devices = {gpu, processor}});
        const std::vector<DeviceInfo> listed = Device::all();
        BOOST_TEST_REQUIRE(listed.size() == 2U);
        BOOST_TEST((listed[0].usable() && listed[0].fp64 && !listed[0].may_be_taken()));
        for (const std::string& part : reason)
            BOOST_TEST(listed[0].only_if_named.find(part) != std::string::npos, listed[0].only_if_named);
        BOOST_TEST((listed[1].may_be_taken() && listed[1].only_if_named.empty()));
        for (const Device& taken : {Device::strongest(), Device::automatic(), Device::of_rank(0, 1)})
            BOOST_TEST(taken.id() == listed[1].id);
        const Device named = Device::select(name);
        BOOST_TEST(named.id() == listed[0].id);
        BOOST_TEST(named.info().only_if_named == listed[0].only_if_named);
        BOOST_TEST(Device::select(0).id() == named.id());
        BOOST_TEST(Device::from_handles(named.context(), named.id(), named.queue()).id() == named.id());
    }
    const Drivers drivers({.devices = {gpu, gpu}});
    std::vector<std::string> fragments{name, "used only if it is named", "install an OpenCL driver"};
    fragments.insert(fragments.end(), reason.begin(), reason.end());
    check_throws(ErrorCode::no_device, fragments, [] { Device::strongest(); });
}

void check_taken(const Answers& gpu) {
    const Drivers drivers({.devices = {processor, gpu}});
    BOOST_TEST_REQUIRE(Device::all().size() == 2U);
    BOOST_TEST(Device::all()[1].only_if_named == "");
    BOOST_TEST(Device::strongest().id() == Device::all()[1].id);
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

BOOST_AUTO_TEST_CASE(a_gpu_of_intel_that_emulates_doubles_is_used_only_if_it_is_named) {
    const std::vector<std::string> reason{"Intel's driver emulates its double precision", "take another device"};
    // Ice Lake, Elkhart Lake, Tiger Lake, DG1, Rocket Lake, Alder Lake, Raptor Lake, Arc A770, Flex 170.
    for (const unsigned number : {0x8A52U, 0x4571U, 0x9A49U, 0x4905U, 0x4C8AU, 0x46A6U, 0xA7A0U, 0x56A0U, 0x56C0U})
        BOOST_TEST_CONTEXT("PCI number " << number) {
            check_used_only_if_named(gpu_of_intel(number), reason);
        }
    // Older drivers tell the number in the name.
    check_used_only_if_named(gpu("Intel(R) UHD Graphics 770 [0x4680]", intel, 32, 1550, false), reason);
    // It need not say that it emulates.
    const Variable unset("OverrideDefaultFP64Settings", "0");
    check_used_only_if_named(gpu_of_intel(0x56A0), reason);
}

BOOST_AUTO_TEST_CASE(a_gpu_of_intel_with_doubles_is_taken_whatever_is_set) {
    const Variable emulates("OverrideDefaultFP64Settings", "1");
    // Broadwell, Skylake, Coffee Lake, Gemini Lake, Max 1550, Meteor Lake, Arrow Lake, Lunar Lake, B580, Panther Lake.
    for (const unsigned number :
         {0x1616U, 0x1912U, 0x3E92U, 0x3185U, 0x0BD5U, 0x7D55U, 0x7D67U, 0x64A0U, 0xE20BU, 0xB080U})
        BOOST_TEST_CONTEXT("PCI number " << number) {
            check_taken(gpu_of_intel(number));
        }
    // Other makers' doubles are their own.
    check_taken(gpu("NVIDIA T1000", nvidia, 14, 1395, true));
}

BOOST_AUTO_TEST_CASE(a_gpu_of_intel_of_unknown_generation_is_taken_unless_the_environment_asks_for_emulation) {
    const Answers unknown = gpu_of_intel(0xFFFF), nameless = gpu("Intel(R) Graphics", intel, 32, 1550, false);
    for (const char* variable : {"OverrideDefaultFP64Settings", "IGC_EnableDPEmulation", "NEO_FP64_EMULATION"}) {
        const Variable emulates(variable, "1");
        for (const Answers& answers : {unknown, nameless})
            check_used_only_if_named(answers, {variable, "it is not known whether", "unset the variable"});
    }
    for (const Answers& answers : {unknown, nameless}) {
        check_taken(answers);
        const Variable off("IGC_EnableDPEmulation", "0");
        check_taken(answers);
    }
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
