#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/device.hpp>

#include <cstdlib>

using namespace clsdf;

BOOST_AUTO_TEST_CASE(a_machine_without_a_driver_is_told_what_to_install) {
    const test::TemporaryFolder no_drivers;
    const std::string folder = std::filesystem::path(no_drivers.file("x")).parent_path().string();
    // The loader's folder of drivers, read at the first call.
    BOOST_REQUIRE(setenv("OCL_ICD_VENDORS", folder.c_str(), 1) == 0);
    test::check_throws(ErrorCode::no_device, {"no OpenCL device", "pocl-opencl-icd", "nvidia-opencl-icd"},
                       [] { Device::strongest(); });
    test::check_throws(ErrorCode::no_device, {"no OpenCL device", "pocl-opencl-icd"}, [] { Device::select("0"); });
    BOOST_TEST(Device::all().empty());
}
