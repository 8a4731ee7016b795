#include "apps/process.hpp"

#include <clsdf/device.hpp>

#include <boost/test/unit_test.hpp>
#include <nlohmann/json.hpp>

#include <filesystem>

using clsdf::Device;
using clsdf::DeviceInfo;
using clsdf::test::check_refused;
using clsdf::test::no_devices;
using clsdf::test::Outcome;
using clsdf::test::run_command;
using clsdf::test::TemporaryFolder;
using clsdf::test::tetrahedron;
using nlohmann::json;

namespace {

const std::string no_choice = "CLSDF_DEVICE=";

/// The index of the device that is taken by default.
DeviceInfo best_info() {
    const Device best = Device::strongest();
    for (const DeviceInfo& info : Device::all())
        if (info.id == best.id()) return info;
    BOOST_FAIL("the best device is not among all");
    return {};
}

}  // namespace

BOOST_AUTO_TEST_SUITE(devices)

BOOST_AUTO_TEST_CASE(are_listed_for_people_and_as_json) {
    const DeviceInfo best = best_info();
    const Outcome outcome = run_command({"devices", "--json"}, {no_choice});
    BOOST_TEST(outcome.status == 0);
    for (const std::string& fragment : {best.name, best.platform, best.driver, std::string("usable    yes"),
                                        "Taken is device " + std::to_string(best.index)})
        BOOST_TEST(outcome.error.find(fragment) != std::string::npos, "no '" << fragment << "' in " << outcome.error);
    const json found = json::parse(outcome.out);
    BOOST_TEST(found["devices"].size() == Device::all().size());
    BOOST_TEST(found["taken"]["index"] == best.index);
    BOOST_TEST(!found["taken"]["reason"].get<std::string>().empty());
    const json& device = found["devices"][best.index];
    BOOST_TEST(device["name"] == best.name);
    BOOST_TEST(device["memory_bytes"] == best.memory);
    BOOST_TEST(device["largest_allocation_bytes"] == best.largest_allocation);
    BOOST_TEST(device["float_width"] == best.float_width);
    BOOST_TEST(device["fp64"] == true);
    BOOST_TEST(device["atomics64"] == best.atomics64);
    BOOST_TEST(device["usable"] == true);
    BOOST_TEST(device["why_not"].is_null());
    BOOST_TEST(run_command({"devices", "--quiet"}, {no_choice}).error.empty());
}

BOOST_AUTO_TEST_CASE(are_taken_as_the_environment_says) {
    for (const DeviceInfo& info : Device::all()) {
        if (!info.usable()) continue;
        const std::string choice = "CLSDF_DEVICE=" + std::to_string(info.index);
        const Outcome outcome = run_command({"devices", "--json", "--quiet"}, {choice});
        BOOST_TEST(outcome.status == 0);
        const json taken = json::parse(outcome.out)["taken"];
        BOOST_TEST(taken["index"] == info.index);
        BOOST_TEST(taken["reason"] == choice + " asks for it");
    }
    const Outcome unknown = run_command({"devices", "--json"}, {"CLSDF_DEVICE=xyzzy"});
    BOOST_TEST(unknown.status == 4);
    BOOST_TEST(unknown.error.find("CLSDF_DEVICE=xyzzy") != std::string::npos);
    BOOST_TEST(json::parse(unknown.out)["taken"].is_null());
    BOOST_TEST(json::parse(unknown.out)["devices"].size() == Device::all().size());
}

BOOST_AUTO_TEST_CASE(of_one_platform_are_told_apart_by_index_alone) {
    // PoCL then lists one processor as two devices; other drivers ignore the variable.
    const std::string two_devices = "POCL_DEVICES=pthread basic";
    const Outcome listed = run_command({"devices", "--json", "--quiet"}, {two_devices, no_choice});
    const std::string platform = "Portable Computing Language";
    std::vector<std::string> names, indices;
    const json devices = json::parse(listed.out)["devices"];
    for (const json& device : devices)
        if (device["platform"] == platform) {
            names.push_back(device["name"]);
            indices.push_back(device["index"].dump());
        }
    if (names.empty()) {
        BOOST_TEST_MESSAGE("skipped: PoCL is not installed");
        return;
    }
    BOOST_TEST_REQUIRE(names.size() == 2U);
    const Outcome both = run_command({"devices", "--quiet"}, {two_devices, "CLSDF_DEVICE=" + platform});
    check_refused(both, 4, {"fits 2 devices", "by index", indices[0] + ": ", indices[1] + ": ", names[0], names[1]});
    for (const std::string& index : indices) {
        const Outcome one = run_command({"devices", "--json", "--quiet"}, {two_devices, "CLSDF_DEVICE=" + index});
        BOOST_TEST(json::parse(one.out)["taken"]["index"].dump() == index);
    }
}

BOOST_AUTO_TEST_CASE(are_none_and_the_message_says_what_to_install) {
    const Outcome outcome = run_command({"devices", "--json"}, no_devices);
    BOOST_TEST(outcome.status == 4);
    const json found = json::parse(outcome.out);
    BOOST_TEST(found["devices"].dump() == "[]");
    BOOST_TEST(found["taken"].is_null());
    BOOST_TEST(found["error"]["code"] == "no_device");
    for (const char* fragment : {"pocl-opencl-icd", "nvidia-opencl-icd", "rocm-opencl-icd", "intel-opencl-icd"})
        BOOST_TEST(outcome.error.find(fragment) != std::string::npos, "no '" << fragment << "' in " << outcome.error);
}

BOOST_AUTO_TEST_CASE(compute_as_the_option_says_before_the_environment) {
    const TemporaryFolder folder;
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    const std::string output = folder.file("field.nrrd");
    const DeviceInfo best = best_info();
    const auto computed_by = [&](const std::string& environment, const std::vector<std::string>& device) {
        std::vector<std::string> arguments{"compute", mesh, "-o", output, "--resolution", "16", "--json", "--quiet"};
        arguments.insert(arguments.end(), device.begin(), device.end());
        const Outcome outcome = run_command(arguments, {environment});
        BOOST_TEST_CONTEXT("message: " << outcome.error)
        BOOST_REQUIRE(outcome.status == 0);
        return json::parse(outcome.out)["device"]["name"].get<std::string>();
    };
    const std::string index = std::to_string(best.index);
    BOOST_TEST(computed_by("CLSDF_DEVICE=" + index, {}) == best.name);
    BOOST_TEST(computed_by("CLSDF_DEVICE=xyzzy", {"--device", index}) == best.name);
    std::filesystem::remove(output);

    check_refused(run_command({"compute", mesh, "-o", output, "--device", "xyzzy"}), 4, {"xyzzy", best.name});
    check_refused(run_command({"compute", mesh, "-o", output}, {"CLSDF_DEVICE=xyzzy"}), 4, {"CLSDF_DEVICE", best.name});
    check_refused(run_command({"compute", mesh, "-o", output, "--device", ""}), 2, {"--device", "missing"});
    // The device is opened before a mesh is read, also if no field would be computed.
    const std::string missing = folder.file("missing.off");
    check_refused(run_command({"compute", missing, "-o", output, "--device", "xyzzy"}), 4, {"--device xyzzy"});
    check_refused(run_command({"compute", missing, "--dry-run", "--device", "xyzzy"}), 4, {"--device xyzzy"});
    check_refused(run_command({"compute", missing, "--dry-run"}, {"CLSDF_DEVICE=xyzzy"}), 4, {"CLSDF_DEVICE=xyzzy"});
    const Outcome dry = run_command({"compute", mesh, "--dry-run", "--device", index});
    BOOST_TEST(dry.status == 0);
    BOOST_TEST(dry.error.find("device  " + best.name) != std::string::npos);
    BOOST_TEST(!std::filesystem::exists(output));
}

BOOST_AUTO_TEST_SUITE_END()
