// Every call of OpenCL may fail, in every call of the library: it is then an error that names the call or, by calls
// that do not wait, an event that has failed; or it costs only time, and the bytes are right. Afterwards the same
// transform gives the right bytes. One process fails a call, resets and goes on. A sample of the calls, or with
// CLSDF_FAULT_PART=N/PARTS in the environment all of that part.
#include "disguise/as_gpu.hpp"
#include "disguise/uses.hpp"
#include "support/supposes.hpp"

#include <cstdint>
#include <cstdlib>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// Calls whose failure may cost only time.
const std::set<std::string> passed_over{
    "clCreateProgramWithBinary",    // the program is compiled from its source
    "clBuildProgram",               // likewise, if it was a stored one
    "clGetProgramInfo",             // its binary is not kept
    "clCreateBuffer",               // memory is divided, or given back first
    "clGetEventInfo",               // the library waits for the event
    "clSetEventCallback",           // likewise
    "clEnqueueMarkerWithWaitList",  // without the marker the library waits for the whole queue
    "clEnqueueMapBuffer",           // copies go from and to memory that is not pinned
    "clEnqueueUnmapMemObject",      // pinned memory is given back
};

void check_error(const Error& error, const std::string& call) {
    BOOST_TEST_CONTEXT("message: " << error.what()) {
        BOOST_CHECK((error.code() == ErrorCode::device_failure || error.code() == ErrorCode::out_of_memory));
        BOOST_TEST(std::string(error.what()).find(call) != std::string::npos);
        BOOST_TEST(std::string(error.what()).find("internal error") == std::string::npos);
    }
}

/// Call `number` of a use fails. Returns whether it was made.
bool check_failing(const Use& use, std::uint64_t number, const Bytes& right) {
    disguise::restart({.number = number});
    Call call;
    Bytes found;
    std::optional<Error> error;
    bool has_failed = false, is_bare = false;
    try {
        call = use.make();
        found = call();
    } catch (const Error& thrown) {
        error = thrown;
    } catch (const OwnCallFailed&) {
        has_failed = true;
    } catch (const EventHasFailed&) {
        has_failed = true;
    } catch (const cl::Error&) {
        is_bare = true;
    }
    const std::string failed = disguise::counts().failed;
    disguise::restart();
    BOOST_TEST_CONTEXT(use.name << ", call " << number << ", " << failed) {
        BOOST_TEST(!is_bare, "the library has let the exception of the C++ binding out");
        if (error)
            check_error(*error, failed);
        else if (!has_failed && !is_bare) {
            BOOST_TEST((found == right), "nobody has seen it, and the bytes are wrong");
            BOOST_TEST((failed.empty() || passed_over.contains(failed)), "nobody has seen it");
        }
        if (!call) return !failed.empty();
        try {
            BOOST_TEST((call() == right), "wrong bytes afterwards");
        } catch (const Error& thrown) {
            // A wait that failed says nothing of the call: the kernels before it count as failed.
            const bool is_refused =
                std::string(thrown.what()).find("make the transform and its plans anew") != std::string::npos;
            if (!is_refused) check_error(thrown, failed);
        } catch (const EventHasFailed&) {
            BOOST_ERROR("an event of the next call has failed");
        } catch (const OwnCallFailed&) {
            BOOST_ERROR("a call of the test has failed afterwards");
        }
    }
    return !failed.empty();
}

}  // namespace

BOOST_AUTO_TEST_SUITE(failing_calls, *boost::unit_test::precondition(on_pocl))

BOOST_AUTO_TEST_CASE(a_call_that_fails_is_seen_by_every_call_of_the_library) {
    BOOST_REQUIRE(Device::all().size() > 0U);
    BOOST_REQUIRE(disguise::counts().all_calls > 0U);  // else the library is not between this program and the loader
    const char* const chosen = std::getenv("CLSDF_FAULT_USE");
    std::size_t made = 0, chosen_in_all = 0;
    for (const std::vector<Use>* const all : {&uses(), &uses_of_rows()})
        for (const Use& use : *all) {
            if (chosen != nullptr && use.name != chosen) continue;
            use.make()();  // programs are compiled and tested
            disguise::restart();
            const Call call = use.make();
            const Bytes right = call();
            const std::uint64_t calls = disguise::counts().all_calls;
            const std::vector<std::uint64_t> numbers = chosen_faults(calls);
            BOOST_TEST_MESSAGE(use.name << ": " << calls << " calls, " << numbers.size() << " of them fail");
            for (const std::uint64_t number : numbers) made += check_failing(use, number, right) ? 1U : 0U;
            chosen_in_all += numbers.size();
        }
    // How often the library looks whether an event has ended depends on the time.
    BOOST_TEST(10 * made > 9 * chosen_in_all, made << " of " << chosen_in_all << " calls were made");
    // The device is as before.
    BOOST_TEST((uses().front().make()() == uses().front().make()()));
}

BOOST_AUTO_TEST_SUITE_END()
