// A kernel that fails is seen by every call: as an error that names it or, by calls that do not wait, as an event that
// has failed. Afterwards the same transform gives the right bytes, or refuses and names the kernel. A sample of the
// kernels, or with CLSDF_FAULT_PART=N/PARTS in the environment all of that part.
#include "disguise/as_gpu.hpp"
#include "disguise/uses.hpp"
#include "support/supposes.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

void check_error(const Error& error, const std::string& kernel) {
    BOOST_TEST_CONTEXT("message: " << error.what()) {
        BOOST_CHECK(error.code() == ErrorCode::device_failure);
        BOOST_TEST(std::string(error.what()).find(kernel) != std::string::npos);
        BOOST_TEST(std::string(error.what()).find("internal error") == std::string::npos);
    }
}

/// The kernel of this launch fails.
void check_failing(const Use& use, std::uint64_t launch, const Bytes& right) {
    // CL_OUT_OF_RESOURCES, and that of NVIDIA for an illegal address.
    const int code = launch % 2 == 0 ? -5 : -9999;
    disguise::restart({.call = "clEnqueueNDRangeKernel", .number = launch, .code = code, .in_kernel = true});
    Call call;
    std::optional<Error> error;
    bool has_failed = false;
    try {
        call = use.make();
        call();
    } catch (const Error& thrown) {
        error = thrown;
    } catch (const EventHasFailed&) {
        has_failed = true;
    }
    const std::string kernel = disguise::counts().failed;
    disguise::restart();
    BOOST_TEST_CONTEXT(use.name << ", launch " << launch << ", kernel " << kernel) {
        BOOST_TEST(!kernel.empty());
        BOOST_TEST((error.has_value() || has_failed), "nobody has seen it");
        if (error) check_error(*error, kernel);
        if (!call) return;
        try {
            BOOST_TEST((call() == right), "wrong bytes afterwards");
        } catch (const Error& thrown) {
            check_error(thrown, kernel);
        } catch (const EventHasFailed&) {
            BOOST_ERROR("an event of the next call has failed");
        }
    }
}

}  // namespace

BOOST_AUTO_TEST_SUITE(failing_kernels, *boost::unit_test::precondition(on_pocl))

BOOST_AUTO_TEST_CASE(a_kernel_that_fails_is_seen_by_every_call) {
    BOOST_REQUIRE(Device::all().size() > 0U);
    BOOST_REQUIRE(disguise::counts().all_calls > 0U);  // else the library is not between this program and the loader
    const char* const chosen = std::getenv("CLSDF_FAULT_USE");
    std::vector<Use> all = uses();
    all.insert(all.end(), uses_of_rows().begin(), uses_of_rows().end());
    for (const Use& use : all) {
        if (chosen != nullptr && use.name != chosen) continue;
        use.make()();  // programs are compiled and tested
        disguise::restart();
        const Call call = use.make();
        const Bytes right = call();
        const std::uint64_t launches = disguise::counts().launches;
        BOOST_TEST((call() == right));
        const std::vector<std::uint64_t> numbers = chosen_faults(launches);
        BOOST_TEST_MESSAGE(use.name << ": " << launches << " kernels, " << numbers.size() << " of them fail");
        for (const std::uint64_t launch : numbers) check_failing(use, launch, right);
    }
    // The device is as before.
    BOOST_TEST((uses().front().make()() == uses().front().make()()));
}

/// A call that is stopped waits for the device, and tells nothing of a kernel that has failed.
BOOST_AUTO_TEST_CASE(a_kernel_that_fails_in_a_call_that_is_stopped_is_seen_by_the_next_one) {
    const auto compute = [](const DistanceTransform& used, const CallOptions& call = {}) {
        return bytes_of_field(used.compute(small_grid(), small_band(), outputs_of_uses, call).slab());
    };
    const Bytes right = compute(*transform_of(mesh()));
    for (std::uint64_t launch = 1; launch <= 20; ++launch) {
        const auto used = transform_of(mesh());
        int asked = 0;
        const CallOptions stopped{.should_stop = [&] { return ++asked > 3; }};
        disguise::restart({.call = "clEnqueueNDRangeKernel", .number = launch, .in_kernel = true});
        BOOST_CHECK_THROW(compute(*used, stopped), Error);
        const std::string kernel = disguise::counts().failed;
        disguise::restart();
        BOOST_TEST_CONTEXT("launch " << launch << ", kernel " << kernel) {
            try {
                BOOST_TEST((compute(*used) == right), "wrong bytes afterwards");
            } catch (const Error& thrown) {
                check_error(thrown, kernel);
            }
        }
    }
}

BOOST_AUTO_TEST_SUITE_END()
