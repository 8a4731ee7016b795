#include "device/context.hpp"
#include "support/supposes.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/tuning.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>

using namespace clsdf;
using namespace clsdf::test;

// Runs in an environment in which OpenCL's loader finds no driver, and CLSDF_DRIVER names a bundled one: that of a
// package, or one that write_bundle_stand_in made.

namespace {

/// To the surface of the unit cube, negative inside.
double distance_to_cube(const Vec3& position) {
    std::array<double, 3> beyond{};
    for (std::size_t axis = 0; axis < 3; ++axis) beyond[axis] = std::max(-position[axis], position[axis] - 1);
    const double inside = std::min(*std::max_element(beyond.begin(), beyond.end()), 0.0);
    double squares = 0;
    for (const double distance : beyond) squares += distance > 0 ? distance * distance : 0;
    return std::sqrt(squares) + inside;
}

boost::test_tools::assertion_result in_its_environment(boost::unit_test::test_unit_id) {
    return supposed(std::getenv("CLSDF_DRIVER") != nullptr, "the folder of a driver in CLSDF_DRIVER");
}

}  // namespace

BOOST_AUTO_TEST_SUITE(the_bundled_driver, *boost::unit_test::precondition(in_its_environment))

BOOST_AUTO_TEST_CASE(has_a_device_that_is_taken_if_no_driver_is_installed) {
    const std::vector<DeviceInfo> infos = Device::all();
    BOOST_REQUIRE(infos.size() == 1U);
    BOOST_TEST(infos[0].usable(), infos[0].why_not);
    BOOST_TEST(infos[0].platform == "Portable Computing Language, bundled with clsdf");
    BOOST_TEST((infos[0].kind == DeviceKind::processor));
    for (const Device& device : {Device::strongest(), Device::select("bundled"), Device::select("portable")}) {
        BOOST_TEST(device.id() == infos[0].id);
        BOOST_TEST(device.platform() == infos[0].platform);
        BOOST_TEST(device.info().index == 0U);
    }
}

BOOST_AUTO_TEST_CASE(computes_exact_fields_with_programs_that_are_not_compiled) {
    const Mesh mesh = make_shape("cube");
    const Band band = Band::symmetric(0.2);
    const Grid grid = Grid::around(mesh, 32, band);
    const TemporaryFolder scratch;
    const std::string folder = scratch.file("written");
    Device whole = Device::strongest();
    whole.write_programs(folder);
    for (const Device& device : {whole, whole.limited({.memory = std::size_t{1} << 28U})}) {
        const Field field = DistanceTransform(device, mesh).compute(grid, band);
        double largest = 0;
        std::size_t sample = 0;
        for (std::int64_t k = 0; k < grid.size[2]; ++k)
            for (std::int64_t j = 0; j < grid.size[1]; ++j)
                for (std::int64_t i = 0; i < grid.size[0]; ++i, ++sample) {
                    const double exact = std::clamp(distance_to_cube(grid.position(i, j, k)), -0.2, 0.2);
                    largest = std::max(largest, std::abs(double{field.distance()[sample]} - exact));
                }
        BOOST_TEST(largest < 1e-6);
    }
    BOOST_TEST(!std::filesystem::exists(folder), "its programs are there already");
}

BOOST_AUTO_TEST_CASE(says_which_program_it_lacks_and_what_to_install) {
    TransformOptions by_group;
    by_group.body = KernelBody::by_group;
    const Mesh mesh = make_shape("cube");
    const Band band = Band::symmetric(0.2);
    check_throws(ErrorCode::unsupported, {"_by_group.cl", "-DLANES=1", "bundled", "pocl-opencl-icd"}, [&] {
        DistanceTransform(Device::strongest(), mesh, by_group).compute(Grid::around(mesh, 8, band), band);
    });
}

BOOST_AUTO_TEST_CASE(keeps_its_programs_whatever_the_environment_says_to_compilers) {
    BOOST_REQUIRE(setenv("POCL_WORK_GROUP_METHOD", "loopvec", 1) == 0);
    const Device device = Device::strongest();
    bool is_compiled = false;
    device::context_of(device).program(
        {"sign_sweep.cl", "-cl-std=CL1.2 -DLANES=1 -cl-fp32-correctly-rounded-divide-sqrt"},
        {[&] { is_compiled = true; }});
    BOOST_TEST(!is_compiled);
    BOOST_REQUIRE(unsetenv("POCL_WORK_GROUP_METHOD") == 0);
}

BOOST_AUTO_TEST_SUITE_END()
