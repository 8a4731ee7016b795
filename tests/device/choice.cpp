#include "support/throws.hpp"

#include <clsdf/device.hpp>
#include <clsdf/error.hpp>

#include "device/context.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <string>

using namespace clsdf;

namespace {

/// CLSDF_DEVICE for as long as this lives.
class EnvironmentChoice {
public:
    explicit EnvironmentChoice(const std::string& value) {
        if (const char* const before = std::getenv("CLSDF_DEVICE")) before_ = before;
        ::setenv("CLSDF_DEVICE", value.c_str(), 1);
    }
    ~EnvironmentChoice() { ::setenv("CLSDF_DEVICE", before_.c_str(), 1); }
    EnvironmentChoice(const EnvironmentChoice&) = delete;
    EnvironmentChoice& operator=(const EnvironmentChoice&) = delete;

private:
    std::string before_;
};

std::string upper_case(std::string text) {
    for (char& letter : text) letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
    return text;
}

std::ptrdiff_t usable_with(const std::string& part) {
    const std::vector<DeviceInfo> infos = Device::all();
    return std::count_if(infos.begin(), infos.end(), [&](const DeviceInfo& info) {
        return info.usable() && (upper_case(info.name).find(upper_case(part)) != std::string::npos ||
                                 upper_case(info.platform).find(upper_case(part)) != std::string::npos);
    });
}

}  // namespace

BOOST_AUTO_TEST_SUITE(the_choice_of_a_device)

BOOST_AUTO_TEST_CASE(tells_of_every_device_what_its_context_believes) {
    const std::vector<DeviceInfo> infos = Device::all();
    BOOST_TEST(!infos.empty());
    for (const DeviceInfo& info : infos) {
        BOOST_TEST_CONTEXT("device " << info.index << " " << info.name) {
            BOOST_TEST(&info == &infos.at(info.index));
            BOOST_TEST(info.version.starts_with("OpenCL "));
            BOOST_TEST(!info.driver.empty());
            BOOST_TEST(info.compute_units >= 1U);
            BOOST_TEST(info.largest_allocation <= info.memory);
            if (!info.usable()) continue;
            BOOST_TEST(info.fp64);
            const Device device = Device::select(std::to_string(info.index));
            BOOST_TEST(device.id() == info.id);
            BOOST_TEST(device.name() == info.name);
            BOOST_TEST(device.platform() == info.platform);
            BOOST_TEST(device::context_of(device).capabilities().largest_allocation == info.largest_allocation);
            BOOST_TEST(device::context_of(device).capabilities().is_processor == (info.kind == DeviceKind::processor));
        }
    }
}

BOOST_AUTO_TEST_CASE(takes_no_processor_where_a_gpu_is_usable) {
    const std::vector<DeviceInfo> infos = Device::all();
    const bool gpu = std::any_of(infos.begin(), infos.end(),
                                 [](const DeviceInfo& info) { return info.usable() && info.kind == DeviceKind::gpu; });
    const cl_device_id best = Device::strongest().id();
    const auto taken =
        std::find_if(infos.begin(), infos.end(), [&](const DeviceInfo& info) { return info.id == best; });
    BOOST_TEST_REQUIRE((taken != infos.end()));
    BOOST_TEST((taken->kind == DeviceKind::gpu) == gpu);
}

BOOST_AUTO_TEST_CASE(knows_a_device_by_a_part_of_its_name_or_its_platforms_in_any_case) {
    for (const DeviceInfo& info : Device::all()) {
        for (const std::string& name : {info.name, info.platform}) {
            for (const std::string& part : {name, upper_case(name), name.substr(1, name.size() - 2)}) {
                BOOST_TEST_CONTEXT("\"" << part << "\"") {
                    if (usable_with(part) == 1 && info.usable()) BOOST_TEST(Device::select(part).id() == info.id);
                    if (usable_with(part) > 1)
                        test::check_throws(ErrorCode::no_device, {"fits", "by index", info.name},
                                           [&] { Device::select(part); });
                }
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(knows_a_device_by_its_number) {
    for (const DeviceInfo& info : Device::all())
        if (info.usable()) BOOST_TEST(Device::select(info.index).id() == info.id);
    test::check_throws(ErrorCode::no_device, {}, [] { Device::select(Device::all().size()); });
}

BOOST_AUTO_TEST_CASE(lists_what_there_is_where_the_name_is_unknown) {
    const std::vector<DeviceInfo> infos = Device::all();
    const std::string too_large = std::to_string(infos.size());
    for (const std::string& unknown : {std::string("xyzzy"), too_large, std::string(30, '9')})
        for (const DeviceInfo& info : infos)
            test::check_throws(ErrorCode::no_device,
                               {unknown, std::to_string(info.index) + ": \"" + info.name + "\"", info.platform},
                               [&] { Device::select(unknown); });
    test::check_throws(ErrorCode::no_device, {infos.front().name}, [] { Device::select(""); });
}

BOOST_AUTO_TEST_CASE(is_the_environments_for_automatic_alone) {
    const cl_device_id best = Device::strongest().id();
    {
        const EnvironmentChoice nothing("");
        BOOST_TEST(Device::automatic().id() == best);
    }
    for (const DeviceInfo& info : Device::all()) {
        if (!info.usable()) continue;
        const EnvironmentChoice choice(std::to_string(info.index));
        BOOST_TEST(Device::automatic().id() == info.id);
        BOOST_TEST(Device::strongest().id() == best);
    }
    const EnvironmentChoice unknown("xyzzy");
    test::check_throws(ErrorCode::no_device, {"CLSDF_DEVICE=xyzzy", Device::strongest().name()},
                       [] { Device::automatic(); });
    BOOST_TEST(Device::strongest().id() == best);
}

BOOST_AUTO_TEST_SUITE_END()
