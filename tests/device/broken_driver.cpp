#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/device.hpp>

#include <cstdlib>

using namespace clsdf;

// A process of its own: a bundled driver is opened once.
BOOST_AUTO_TEST_CASE(a_bundled_driver_that_cannot_be_loaded_is_listed_with_the_reason) {
    const test::TemporaryFolder scratch;
    const std::filesystem::path file = scratch.file("libclsdf_pocl.so", "no library");
    const std::string folder = file.parent_path().string();
    BOOST_REQUIRE(setenv("OCL_ICD_VENDORS", folder.c_str(), 1) == 0);
    BOOST_REQUIRE(setenv("CLSDF_DRIVER", folder.c_str(), 1) == 0);
    const std::vector<DeviceInfo> infos = Device::all();
    BOOST_REQUIRE(infos.size() == 1U);
    BOOST_TEST(!infos[0].usable());
    BOOST_TEST(infos[0].index == 0U);
    for (const auto& open : {+[] { Device::strongest(); }, +[] { Device::select("bundled"); }})
        test::check_throws(ErrorCode::no_device, {"bundled", "cannot be loaded", file.string()}, open);
    test::check_throws(ErrorCode::no_device, {"pocl-opencl-icd"}, [] { Device::strongest(); });
}
