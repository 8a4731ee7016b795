#pragma once

#include <clsdf/error.hpp>

#include <boost/test/unit_test.hpp>

#include <functional>
#include <string>
#include <vector>

namespace clsdf::test {

/// Checks that the action throws clsdf::Error with this code and a message that has each of the fragments.
inline void check_throws(ErrorCode code, const std::vector<std::string>& fragments,
                         const std::function<void()>& action) {
    try {
        action();
        BOOST_ERROR("nothing was thrown");
    } catch (const Error& error) {
        const std::string message = error.what();
        BOOST_TEST_CONTEXT("message: " << message) {
            BOOST_CHECK(error.code() == code);
            for (const std::string& fragment : fragments)
                BOOST_CHECK_MESSAGE(message.find(fragment) != std::string::npos, "no '" << fragment << "'");
        }
    }
}

}  // namespace clsdf::test
