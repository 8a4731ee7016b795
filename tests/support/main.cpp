#include <boost/test/unit_test.hpp>

#include <clsdf/tuning.hpp>

// Without BOOST_TEST_MODULE, which would have to come before the precompiled header includes Boost.Test.
int main(int argument_count, char** arguments) {
    clsdf::tuning::read_environment();  // tests set variables as CLSDF_MAX_ALLOCATION
    const auto name_suite = [] {
        boost::unit_test::framework::master_test_suite().p_name.value = "clsdf";
        return true;
    };
    return boost::unit_test::unit_test_main(name_suite, argument_count, arguments);
}
