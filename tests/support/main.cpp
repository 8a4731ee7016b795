#define BOOST_TEST_MODULE clsdf
#include <boost/test/unit_test.hpp>
