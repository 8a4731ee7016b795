#include "support/throws.hpp"

#include <clsdf/device.hpp>
#include <clsdf/error.hpp>

#include "device/context.hpp"

#include <algorithm>
#include <thread>
#include <utility>
#include <vector>

using namespace clsdf;

namespace {

cl_uint references_of(cl_context context) {
    return cl::Context(context, true).getInfo<CL_CONTEXT_REFERENCE_COUNT>() - 1;
}

/// A context and a queue as a simulation has them.
struct Callers {
    cl::Device device{Device::best().id(), true};
    cl::Context context{device};
    cl::CommandQueue queue{context, device};
};

}  // namespace

// Without a device nothing of this project works: its tests fail then, and do not skip.
BOOST_AUTO_TEST_CASE(there_is_a_device) {
    const Device device = Device::best();
    BOOST_TEST(!device.name().empty());
    BOOST_TEST(!device.platform().empty());
    BOOST_TEST(device::context_of(device).capabilities().compute_units >= 1);
    BOOST_TEST(device::context_of(device).capabilities().largest_allocation > 0);
}

BOOST_AUTO_TEST_CASE(the_callers_handles_are_used_as_they_are) {
    const Callers callers;
    const Device device = Device::from_handles(callers.context(), callers.device(), callers.queue());
    BOOST_TEST(device.context() == callers.context());
    BOOST_TEST(device.id() == callers.device());
    BOOST_TEST(device.queue() == callers.queue());
}

BOOST_AUTO_TEST_CASE(the_callers_handles_are_released_with_the_last_copy) {
    const Callers callers;
    const cl_uint before = references_of(callers.context());
    {
        const Device device = Device::from_handles(callers.context(), callers.device(), callers.queue());
        const cl_uint held = references_of(callers.context());
        BOOST_TEST(held > before);
        const Device copy = device;
        BOOST_TEST(references_of(callers.context()) == held);
    }
    BOOST_TEST(references_of(callers.context()) == before);
}

BOOST_AUTO_TEST_CASE(a_device_outlives_the_callers_own_references) {
    auto callers = std::make_unique<Callers>();
    const Device device = Device::from_handles(callers->context(), callers->device(), callers->queue());
    callers.reset();
    BOOST_TEST(!device.name().empty());
    const cl::Buffer buffer(device::context_of(device).context(), CL_MEM_READ_WRITE, 64);
    device::context_of(device).queue().enqueueFillBuffer(buffer, cl_uint{1}, 0, 64);
    device::context_of(device).queue().finish();
}

BOOST_AUTO_TEST_CASE(a_null_handle_is_an_error) {
    const Callers callers;
    test::check_throws(ErrorCode::invalid_argument, {"null"},
                       [&] { Device::from_handles(nullptr, callers.device(), callers.queue()); });
    test::check_throws(ErrorCode::invalid_argument, {"null"},
                       [&] { Device::from_handles(callers.context(), nullptr, callers.queue()); });
    test::check_throws(ErrorCode::invalid_argument, {"null"},
                       [&] { Device::from_handles(callers.context(), callers.device(), nullptr); });
}

BOOST_AUTO_TEST_CASE(a_limited_device_has_what_is_left_to_it_and_a_context_of_its_own) {
    const Device whole = Device::best();
    const unsigned all = device::context_of(whole).capabilities().compute_units;
    const Device half = whole.limited({.memory = 1 << 20});
    BOOST_TEST(half.context() != whole.context());
    BOOST_TEST(half.name() == whole.name());
    BOOST_TEST(device::context_of(half).capabilities().memory == 1U << 20);
    BOOST_TEST(device::context_of(half).capabilities().compute_units == all);
    half.set_program_cache("");
    const auto divisions = cl::Device(whole.id(), true).getInfo<CL_DEVICE_PARTITION_PROPERTIES>();
    if (std::ranges::count(divisions, CL_DEVICE_PARTITION_BY_COUNTS) > 0) {
        BOOST_TEST(device::context_of(half.limited({.compute_units = 1})).capabilities().memory == 1U << 20);
        BOOST_TEST(half.limited({.compute_units = 1}).program_cache().empty());
        BOOST_TEST(device::context_of(whole.limited({.compute_units = 1})).capabilities().compute_units == 1U);
    } else if (all > 1) {
        test::check_throws(ErrorCode::unsupported, {"cannot be divided", "POCL_CPU_MAX_CU_COUNT"},
                           [&] { whole.limited({.compute_units = 1}); });
    }
    BOOST_TEST(device::context_of(whole.limited({.compute_units = all})).capabilities().compute_units == all);
    test::check_throws(ErrorCode::invalid_argument, {"0 bytes"}, [&] { whole.limited({.memory = 0}); });
    test::check_throws(ErrorCode::invalid_argument, {"0 compute units"}, [&] { whole.limited({.compute_units = 0}); });
    test::check_throws(ErrorCode::invalid_argument, {std::to_string(all + 1) + " compute units", std::to_string(all)},
                       [&] { whole.limited({.compute_units = all + 1}); });
}

BOOST_AUTO_TEST_CASE(a_program_is_built_once_for_all_threads) {
    const Device device = Device::best();
    std::vector<cl::Program> programs(4);
    std::vector<std::thread> threads;
    for (cl::Program& program : programs)
        threads.emplace_back([&] { program = device::context_of(device).program("scan.cl", "-cl-std=CL1.2"); });
    for (std::thread& thread : threads) thread.join();
    for (const cl::Program& program : programs) BOOST_TEST(program() == programs.front()());
    const cl::Program other = device::context_of(device).program("scan.cl", "-cl-std=CL1.2 -DOTHER");
    BOOST_TEST(other() != programs.front()());
}
