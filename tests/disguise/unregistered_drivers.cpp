// Drivers of GPUs that OpenCL's loader does not know: the command, with files of GPUs in a folder of the test's own.
#include "apps/process.hpp"
#include "support/pocl.hpp"
#include "support/supposes.hpp"

#include <clsdf/device.hpp>

#include "device/find/system_library.hpp"

#include <nlohmann/json.hpp>

#include <dlfcn.h>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

const std::string nvidia = "libnvidia-opencl.so.1";
const std::string preload = "LD_PRELOAD=" + path_of_build("CLSDF_DISGUISE_LIBRARY", CLSDF_DISGUISE_LIBRARY);
const std::string refused_driver = path_of_build("CLSDF_REFUSED_DRIVER", CLSDF_REFUSED_DRIVER);

/// Files of GPUs as in /dev, and a folder of libraries.
class Machine {
public:
    explicit Machine(const std::vector<std::string>& gpus) {
        fs::create_directories(devices() / "dri");
        fs::create_directories(libraries());
        for (const std::string& gpu : gpus) files_.file("dev/" + gpu, "");
    }

    fs::path devices() const { return files_.file("dev"); }
    fs::path libraries() const { return files_.file("lib/gpu"); }

    void link(const fs::path& driver, const std::string& name) const { fs::create_symlink(driver, libraries() / name); }
    /// PoCL finds its own files beside the name by which it was opened.
    void link_pocl(const std::string& name) const {
        const fs::path pocl = file_of_pocl(), folder = pocl.parent_path();
        link(pocl, name);
        link(folder / "pocl", "pocl");
        fs::create_symlink(fs::weakly_canonical(folder / "../../share"), files_.file("share"));
    }

    std::vector<std::string> environment(const std::vector<std::string>& more = {}) const {
        std::vector<std::string> all{"CLSDF_DEVICE_FILES=" + devices().string(),
                                     "CLSDF_DEVICE=", "LD_LIBRARY_PATH=" + libraries().string()};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }

    json list(const std::vector<std::string>& more = {}) const {
        return json::parse(run_command({"devices", "--json", "--quiet"}, environment(more)).out);
    }

private:
    TemporaryFolder files_;
};

/// Without a file in /etc/OpenCL/vendors, and PoCL as a GPU.
const std::vector<std::string> unregistered_gpu{preload, "CLSDF_DISGUISE=gpu", "CLSDF_DISGUISE_PLATFORMS=0"};

std::vector<json> with_source(const json& found, const std::string& source) {
    std::vector<json> chosen;
    for (const json& device : found["devices"])
        if (device["source"] == source) chosen.push_back(device);
    return chosen;
}

boost::test_tools::assertion_result pocl_alone(boost::unit_test::test_unit_id) {
    const std::vector<DeviceInfo> all = Device::all();
    bool is_so = !file_of_pocl().empty() && !all.empty();
    for (const std::string& library : {nvidia, std::string("libamdocl64.so"), std::string("libigdrcl.so")})
        is_so &= device::system_libraries(library).empty();
    for (const DeviceInfo& info : all)
        is_so &= info.source == DeviceSource::registered && info.kind == DeviceKind::processor;
    return supposed(is_so, "PoCL, registered, and no other device or driver");
}

/// oclgrind's device is a GPU that computes.
const fs::path simulator = CLSDF_OCLGRIND_DRIVER;
boost::test_tools::assertion_result has_simulator(boost::unit_test::test_unit_id) {
    return supposed(fs::exists(simulator), "oclgrind's driver for OpenCL's loader");
}

/// Computes a small field; returns the command's outcome and the field's bytes.
std::pair<Outcome, std::string> compute(const std::vector<std::string>& environment,
                                        const std::vector<std::string>& more = {}) {
    const TemporaryFolder folder;
    const std::string output = folder.file("field.npy");
    std::vector<std::string> arguments{
        "compute",  folder.file("mesh.off", tetrahedron), "-o", output, "--resolution", "16", "--json", "--quiet",
        "--verbose"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    Outcome outcome = run_command(arguments, environment);
    BOOST_TEST(outcome.status == 0, outcome.error);
    return {std::move(outcome), content_of(output)};
}

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
    return found;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(a_driver_that_is_not_registered, *boost::unit_test::precondition(pocl_alone))

BOOST_AUTO_TEST_CASE(is_found_and_computes_the_bytes_of_a_registered_one) {
    const Machine machine({"nvidia0"});
    machine.link_pocl(nvidia);
    const std::vector<std::string> environment = machine.environment(unregistered_gpu);
    const Outcome listed = run_command({"devices", "--json"}, environment);
    BOOST_TEST(listed.status == 0);
    const std::string file = (machine.libraries() / nvidia).string();
    BOOST_TEST(count(listed.error, "a driver that OpenCL's loader does not know: " + file) == 1U, listed.error);
    const json found = json::parse(listed.out);
    BOOST_TEST_REQUIRE(found["devices"].size() == 1U);
    BOOST_TEST(found["devices"][0]["source"] == "unregistered");
    BOOST_TEST(found["devices"][0]["driver_file"] == file);
    BOOST_TEST(found["devices"][0]["kind"] == "gpu");
    BOOST_TEST(found["taken"]["index"] == 0);

    const auto [outcome, bytes] = compute(environment);
    BOOST_TEST(json::parse(outcome.out)["warnings"].empty());
    BOOST_TEST((bytes == compute({preload, "CLSDF_DISGUISE=gpu"}).second));
    // By its name or number, too.
    compute(environment, {"--device", "0"});
    compute(environment, {"--device", "portable computing"});
}

BOOST_AUTO_TEST_CASE(comes_after_a_registered_processor_and_is_taken, *boost::unit_test::precondition(has_simulator)) {
    const std::size_t registered = Device::all().size();
    for (const auto& [gpu, library] : std::vector<std::pair<std::string, std::string>>{
             {"nvidia3", nvidia}, {"kfd", "libamdocl64.so"}, {"dri/renderD128", "libigdrcl.so"}})
        BOOST_TEST_CONTEXT(gpu) {
            const Machine machine({gpu});
            machine.link(simulator, library);
            const json found = machine.list();
            BOOST_TEST_REQUIRE(found["devices"].size() == registered + 1);
            for (std::size_t n = 0; n < registered; ++n) {
                BOOST_TEST(found["devices"][n]["source"] == "registered");
                BOOST_TEST(found["devices"][n]["driver_file"].is_null());
            }
            BOOST_TEST(found["devices"][registered]["source"] == "unregistered");
            BOOST_TEST(found["devices"][registered]["driver_file"] == (machine.libraries() / library).string());
            BOOST_TEST(found["taken"]["index"] == registered);
            BOOST_TEST(machine.list({"CLSDF_DEVICE=0"})["taken"]["index"] == 0);
        }
    // Another maker's file, or none: not looked for.
    for (const char* gpu : {"kfd", "nvidiactl", "nvidia-uvm", "kfd2"}) {
        const Machine machine({gpu});
        machine.link(simulator, nvidia);
        BOOST_TEST(with_source(machine.list(), "unregistered").empty(), gpu);
    }
}

BOOST_AUTO_TEST_CASE(is_left_out_if_its_platform_is_registered) {
    const Machine machine({"nvidia0"});
    machine.link_pocl(nvidia);
    const json found = machine.list();
    BOOST_TEST(with_source(found, "registered").size() == Device::all().size());
    BOOST_TEST(with_source(found, "unregistered").empty());
    BOOST_TEST(with_source(found, "device_file").size() == 1U);
}

BOOST_AUTO_TEST_CASE(is_not_looked_for_if_a_gpu_is_registered_or_the_user_has_chosen_the_vendors) {
    const Machine machine({"nvidia0"});
    machine.link_pocl(nvidia);
    const json beside = machine.list({preload, "CLSDF_DISGUISE=gpu"});
    BOOST_TEST(with_source(beside, "registered").size() == beside["devices"].size());
    for (const char* variable : {"OCL_ICD_VENDORS", "OPENCL_VENDOR_PATH"}) {
        std::vector<std::string> environment = unregistered_gpu;
        environment.push_back(std::string(variable) + "=" + machine.devices().string());
        BOOST_TEST(machine.list(environment)["devices"].empty(), variable);
    }
}

BOOST_AUTO_TEST_CASE(is_never_opened_from_the_working_folder) {
    const Machine machine({"nvidia0"});
    machine.link_pocl(nvidia);
    const std::string folder = machine.libraries();
    for (const std::string& path : {std::string(), std::string(":"), std::string("/nonexistent:"), std::string("."),
                                    std::string("../gpu;/nonexistent"), std::string("$ORIGIN")}) {
        std::vector<std::string> environment = machine.environment(unregistered_gpu);
        environment.push_back("LD_LIBRARY_PATH=" + path);
        Process process({"devices", "--json", "--quiet"}, environment, {}, [&] {
            if (::chdir(folder.c_str()) != 0) ::_exit(126);
        });
        const Outcome outcome = process.wait();
        const json found = json::parse(outcome.out);
        BOOST_TEST_REQUIRE(found["devices"].size() == 1U, "LD_LIBRARY_PATH=" << path);
        BOOST_TEST(found["devices"][0]["source"] == "device_file");
    }
}

BOOST_AUTO_TEST_CASE(is_refused_with_the_reason_if_its_objects_do_not_carry_its_table) {
    const Machine machine({"nvidia0"});
    machine.link(refused_driver, nvidia);
    const std::string file = (machine.libraries() / nvidia).string();
    for (const auto& [wrong, reason] : std::vector<std::pair<std::string, std::string>>{
             {"no table", file + " is refused, since its platform has no dispatch table"},
             {"the loader's table", "since only OpenCL's loader can set the dispatch table"},
             {"other devices", "since its devices do not carry the dispatch table of their platform"},
             {"no platform", file + " has no platform"},
             {"no driver", file + " is no driver of OpenCL"}}) {
        const json found = machine.list({"REFUSED_DRIVER=" + wrong});
        const std::vector<json> gpus = with_source(found, "device_file");
        BOOST_TEST_REQUIRE(gpus.size() == 1U, wrong);
        const std::string why_not = gpus[0]["why_not"];
        BOOST_TEST(why_not.find(reason) != std::string::npos, "no '" << reason << "' in " << why_not);
    }
}

BOOST_AUTO_TEST_CASE(is_told_once_if_it_is_missing_and_no_device_is_named) {
    const Machine machine({"nvidia0", "nvidia1", "kfd", "dri/renderD128"});
    const std::vector<std::string> environment = machine.environment();
    const json found = machine.list();
    const std::vector<json> gpus = with_source(found, "device_file");
    BOOST_TEST_REQUIRE(gpus.size() == 2U);
    BOOST_TEST(gpus[0]["name"] == "a GPU of NVIDIA");
    BOOST_TEST(gpus[0]["driver_file"] == (machine.devices() / "nvidia0").string());
    BOOST_TEST(gpus[1]["name"] == "a GPU of AMD");
    for (const json& gpu : gpus) BOOST_TEST(gpu["usable"] == false);
    BOOST_TEST(found["taken"]["index"] == 0);

    const auto [outcome, bytes] = compute(environment);
    for (const char* part : {"libnvidia-opencl.so.1, NVIDIA's driver of OpenCL, is in no folder",
                             "NVIDIA_DRIVER_CAPABILITIES=compute,utility", "libamdocl64.so", "rocm-opencl-icd"})
        BOOST_TEST(count(outcome.error, part) == 1U, part << " in " << outcome.error);
    BOOST_TEST(json::parse(outcome.out)["warnings"].size() == 2U);
    for (const auto& [variables, options] : std::vector<std::pair<std::vector<std::string>, std::vector<std::string>>>{
             {machine.environment({"CLSDF_DEVICE=0"}), {}}, {environment, {"--device", "0"}}}) {
        const auto [named, same_bytes] = compute(variables, options);
        BOOST_TEST(named.error.empty(), named.error);
        BOOST_TEST((same_bytes == bytes));
    }
    // Named itself, it is refused with the same reason.
    const Outcome refused = run_command({"devices", "--prepare", "--device", "nvidia"}, environment);
    check_refused(refused, 4, {"a GPU of NVIDIA", "NVIDIA_DRIVER_CAPABILITIES=compute,utility"});
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(the_list_of_devices, *boost::unit_test::precondition(pocl_alone))

BOOST_AUTO_TEST_CASE(tells_of_the_drivers_for_wsl2_if_a_gpu_is_there_and_none_can_be_used) {
    const Machine machine({"dxg"});
    const std::string hint =
        "This is WSL2, by " + (machine.devices() / "dxg").string() + ": a GPU of Intel computes if";
    const Outcome listed = run_command({"devices"}, machine.environment());
    BOOST_TEST(listed.status == 0);
    for (const std::string& part :
         {hint, std::string("intel-opencl-icd"), std::string("NVIDIA and AMD have no OpenCL")})
        BOOST_TEST(count(listed.error, part) == 1U, "no '" << part << "' in " << listed.error);
    // Not if a GPU can be used, or if Windows shows none.
    const Outcome with_gpu = run_command({"devices"}, machine.environment({preload, "CLSDF_DISGUISE=gpu"}));
    BOOST_TEST(count(with_gpu.error, "WSL2") == 0U, with_gpu.error);
    const Machine other({"kfd"});
    BOOST_TEST(count(run_command({"devices"}, other.environment()).error, "WSL2") == 0U);
}

BOOST_AUTO_TEST_CASE(says_that_a_gpu_that_emulates_doubles_is_used_only_if_it_is_named) {
    const Machine machine({});
    const std::string name = "Intel(R) Arc(TM) A770 Graphics [0x56a0]";
    const std::vector<std::string> emulated{preload, "CLSDF_DISGUISE_INTEL=" + name, "POCL_DEVICES=pthread basic"};
    const Outcome listed = run_command({"devices", "--json"}, machine.environment(emulated));
    BOOST_TEST(listed.status == 0);
    const std::string reason = "Intel's driver emulates its double precision";
    for (const std::string& part : {name, "usable    only if it is named: " + reason,
                                    std::string("Taken is device 1: no other one is used unless it is named.")})
        BOOST_TEST(count(listed.error, part) == 1U, "no '" << part << "' in " << listed.error);
    const json found = json::parse(listed.out);
    BOOST_TEST_REQUIRE(found["devices"].size() == 2U);
    BOOST_TEST(found["devices"][0]["usable"] == true);
    BOOST_TEST(found["devices"][0]["why_not"].is_null());
    BOOST_TEST(count(found["devices"][0]["only_if_named"], reason) == 1U);
    BOOST_TEST(found["devices"][1]["only_if_named"].is_null());
    for (const char* choice : {"0", "a770"}) {
        std::vector<std::string> named = emulated;
        named.push_back(std::string("CLSDF_DEVICE=") + choice);
        BOOST_TEST(machine.list(named)["taken"]["index"] == 0);
    }
}

BOOST_AUTO_TEST_CASE(looks_for_another_gpu_if_one_emulates_doubles) {
    const Machine machine({"nvidia0"});
    const std::vector<std::string> emulated{preload, "CLSDF_DISGUISE_INTEL=Intel(R) UHD Graphics 770 [0x4680]"};
    BOOST_TEST(with_source(machine.list(emulated), "device_file").size() == 1U);
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_CASE(libraries_of_the_system_are_found_where_its_loader_finds_them) {
    void* const loader = ::dlopen("libOpenCL.so.1", RTLD_NOW | RTLD_LOCAL);
    BOOST_REQUIRE(loader != nullptr);
    Dl_info info{};
    BOOST_REQUIRE(::dladdr(::dlsym(loader, "clGetPlatformIDs"), &info) != 0);
    bool is_there = false;
    for (const fs::path& file : device::system_libraries("libOpenCL.so.1"))
        is_there |= fs::equivalent(file, info.dli_fname);
    BOOST_TEST(is_there, info.dli_fname);
    BOOST_TEST(device::system_libraries("libclsdf-no-such-library.so.1").empty());
}
