#include <clsdf/tuning.hpp>

#include "device/opencl.hpp"

#include <boost/test/unit_test.hpp>

using namespace clsdf;

namespace {

// As PyPI's pocl-binary-distribution answers on a Zen 4.
const device::Implementation pocl_30_on_zen_4{"Portable Computing Language",
                                              "OpenCL 3.0 PoCL 3.0-rc2  Linux, Release, RELOC, LLVM 14.0.6, SLEEF",
                                              "pthread-AMD EPYC", 16};

}  // namespace

BOOST_AUTO_TEST_CASE(pocl_30_is_refused_where_its_compiler_ends_the_process) {
    const device::KnownFault* fault = device::known_fault(pocl_30_on_zen_4, KernelBody::by_vector);
    BOOST_REQUIRE(fault != nullptr);
    BOOST_TEST(fault->remedy.find("PoCL 3.1") != std::string_view::npos);
}

BOOST_AUTO_TEST_CASE(rusticl_is_refused_for_processors_alone) {
    const device::Implementation llvmpipe{"rusticl", "OpenCL 3.0 ", "llvmpipe (LLVM 19.1.7, 256 bits)", 8};
    const device::KnownFault* fault = device::known_fault(llvmpipe, KernelBody::by_vector);
    BOOST_REQUIRE(fault != nullptr);
    BOOST_TEST(fault->remedy.find("PoCL") != std::string_view::npos);
    BOOST_TEST(device::known_fault(llvmpipe, KernelBody::by_group) == nullptr);
}

BOOST_AUTO_TEST_CASE(what_works_is_not_refused) {
    BOOST_TEST(device::known_fault(pocl_30_on_zen_4, KernelBody::by_group) == nullptr);
    device::Implementation other = pocl_30_on_zen_4;
    other.float_width = 8;
    BOOST_TEST(device::known_fault(other, KernelBody::by_vector) == nullptr);
    other = pocl_30_on_zen_4;
    other.version = "OpenCL 3.0 PoCL 3.1+debian  Linux, None+Asserts, RELOC, SPIR, LLVM 14.0.6, SLEEF, DISTRO";
    BOOST_TEST(device::known_fault(other, KernelBody::by_vector) == nullptr);
    other = pocl_30_on_zen_4;
    other.device = "pthread-Intel(R) Xeon(R) Platinum 8481C";
    BOOST_TEST(device::known_fault(other, KernelBody::by_vector) == nullptr);
}

BOOST_AUTO_TEST_CASE(lists_are_compiled_plainly_by_the_one_compiler_that_makes_them_wrong) {
    device::Implementation pocl{"Portable Computing Language",
                                "OpenCL 3.0 PoCL 7.1  Linux, Release, LLVM 19.1.7, SLEEF", "cpu-znver4-AMD EPYC", 16};
    BOOST_TEST(device::options_around_faults(pocl, "coarse_lists.cl") == " -cl-opt-disable");
    BOOST_TEST(device::options_around_faults(pocl, "bricks_by_vector.cl") == "");
    pocl.version = "OpenCL 3.0 PoCL 7.1+debian  Linux, None+Asserts, RELOC, SPIR-V, LLVM 21.1.8, SLEEF, DISTRO";
    BOOST_TEST(device::options_around_faults(pocl, "coarse_lists.cl") == "");
}
