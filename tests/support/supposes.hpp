#pragma once

#include <clsdf/device.hpp>
#include <clsdf/error.hpp>

#include <boost/test/unit_test.hpp>

#include <cstdlib>
#include <filesystem>
#include <string>

/// Tests that suppose more than a device: elsewhere they are skipped, and Boost.Test says why.
namespace clsdf::test {

inline boost::test_tools::assertion_result supposed(bool is_so, const std::string& what) {
    boost::test_tools::assertion_result result(is_so);
    if (!is_so) result.message() << "it supposes " << what;
    return result;
}

/// BOOST_AUTO_TEST_SUITE(name, *boost::unit_test::precondition(on_pocl)): the tests know PoCL's names, its folder of
/// compiled programs or its devices. Without a device they fail.
inline boost::test_tools::assertion_result on_pocl(boost::unit_test::test_unit_id) {
    std::string platform = "Portable Computing Language";
    try {
        platform = Device::strongest().platform();
    } catch (const Error&) {
        // The test fails for the same reason.
    }
    return supposed(platform == "Portable Computing Language", "PoCL, and the device is one of " + platform);
}

/// An allocation beyond a process's addresses fails with std::bad_alloc. The sanitizers end the process instead, with
/// allocator_may_return_null, too.
inline boost::test_tools::assertion_result on_usual_memory(boost::unit_test::test_unit_id) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    constexpr bool is_usual = false;
#else
    constexpr bool is_usual = true;
#endif
    return supposed(is_usual, "an allocator that throws, and this is a sanitizer's");
}

/// A path of the build; a bundle of the programs on another machine names it in the environment.
inline std::string path_of_build(const char* variable, const char* path) {
    const char* const named = std::getenv(variable);
    return named == nullptr ? path : named;
}

}  // namespace clsdf::test
