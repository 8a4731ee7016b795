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
    cl::Device device{Device::strongest().id(), true};
    cl::Context context{device};
    cl::CommandQueue queue{context, device};
};

}  // namespace

// Without a device nothing of this project works: its tests fail then, and do not skip.
BOOST_AUTO_TEST_CASE(there_is_a_device) {
    const Device device = Device::strongest();
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
    const Device whole = Device::strongest();
    const unsigned all = device::context_of(whole).capabilities().compute_units;
    const Device half = whole.limited({.memory = 1 << 20});
    BOOST_TEST(half.context() != whole.context());
    BOOST_TEST(half.name() == whole.name());
    BOOST_TEST(device::context_of(half).capabilities().memory == 1U << 20);
    BOOST_TEST(device::context_of(half).capabilities().compute_units == all);
    half.keep_records("/records");
    const auto divisions = cl::Device(whole.id(), true).getInfo<CL_DEVICE_PARTITION_PROPERTIES>();
    if (std::ranges::count(divisions, CL_DEVICE_PARTITION_BY_COUNTS) > 0) {
        BOOST_TEST(device::context_of(half.limited({.compute_units = 1})).capabilities().memory == 1U << 20);
        BOOST_TEST(half.limited({.compute_units = 1}).record_folder() == "/records");
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

// PoCL's threads use a part after its last command, which ended one process in fifty.
BOOST_AUTO_TEST_CASE(parts_of_a_device_come_and_go) {
    const Device whole = Device::automatic();
    const auto divisions = cl::Device(whole.id(), true).getInfo<CL_DEVICE_PARTITION_PROPERTIES>();
    if (std::ranges::count(divisions, CL_DEVICE_PARTITION_BY_COUNTS) == 0) return;
    for (int i = 0; i < 200; ++i) {
        const Device part = whole.limited({.compute_units = 1});
        const device::Context& context = device::context_of(part);
        const cl::Buffer buffer(context.context(), CL_MEM_READ_WRITE, std::size_t{1} << 20);
        for (cl_uint n = 0; n < 8; ++n) context.queue().enqueueFillBuffer(buffer, n, 0, std::size_t{1} << 20);
        context.queue().flush();
    }
}

BOOST_AUTO_TEST_CASE(each_process_of_a_machine_gets_a_share) {
    const Device whole = Device::automatic();
    const DeviceInfo info = whole.info();
    BOOST_TEST(Device::of_rank(0, 1).info().compute_units == info.compute_units);
    const auto divisions = cl::Device(whole.id(), true).getInfo<CL_DEVICE_PARTITION_PROPERTIES>();
    if (info.kind == DeviceKind::processor && std::ranges::count(divisions, CL_DEVICE_PARTITION_BY_COUNTS) > 0)
        for (const std::size_t ranks : {2U, 3U, 1000U})
            for (const std::size_t rank : {std::size_t{0}, ranks - 1})
                BOOST_TEST(Device::of_rank(rank, ranks).info().compute_units ==
                           std::max(std::size_t{1}, info.compute_units / ranks));
    test::check_throws(ErrorCode::invalid_argument, {"rank is 2 of 2"}, [] { Device::of_rank(2, 2); });
    test::check_throws(ErrorCode::invalid_argument, {"rank is 0 of 0"}, [] { Device::of_rank(0, 0); });
}

BOOST_AUTO_TEST_CASE(a_device_tells_its_properties_as_the_list_does) {
    for (const DeviceInfo& listed : Device::all()) {
        if (!listed.usable()) continue;
        const Device device = Device::select(std::to_string(listed.index));
        const DeviceInfo info = device.info();
        BOOST_TEST(info.index == listed.index);
        BOOST_TEST(info.id == listed.id);
        BOOST_TEST(info.name == listed.name);
        BOOST_TEST(info.platform == listed.platform);
        BOOST_TEST(info.version == listed.version);
        BOOST_TEST(info.driver == listed.driver);
        BOOST_TEST((info.kind == listed.kind));
        BOOST_TEST(info.compute_units == listed.compute_units);
        BOOST_TEST(info.clock_megahertz == listed.clock_megahertz);
        BOOST_TEST(info.memory == listed.memory);
        BOOST_TEST(info.largest_allocation == listed.largest_allocation);
        BOOST_TEST(info.fp64 == listed.fp64);
        BOOST_TEST(info.atomics64 == listed.atomics64);
        BOOST_TEST(info.float_width == listed.float_width);
        BOOST_TEST(info.usable());
    }
    const Callers callers;
    BOOST_TEST(Device::from_handles(callers.context(), callers.device(), callers.queue()).info().index ==
               Device::strongest().info().index);
}

BOOST_AUTO_TEST_CASE(a_limited_device_tells_its_limits) {
    const Device whole = Device::strongest();
    const DeviceInfo half = whole.limited({.memory = 1 << 20}).info();
    BOOST_TEST(half.index == whole.info().index);
    BOOST_TEST(half.memory == 1U << 20);
    BOOST_TEST(half.largest_allocation == 1U << 20);
    const auto divisions = cl::Device(whole.id(), true).getInfo<CL_DEVICE_PARTITION_PROPERTIES>();
    if (std::ranges::count(divisions, CL_DEVICE_PARTITION_BY_COUNTS) == 0 || whole.info().compute_units < 2) return;
    const Device part = whole.limited({.compute_units = 1});
    BOOST_TEST(part.info().compute_units == 1U);
    BOOST_TEST(part.info().index == DeviceInfo::not_listed);
    BOOST_TEST(part.info().id == part.id());
    BOOST_TEST(part.info().name == whole.name());
}

// Bindings of other languages have these numbers.
BOOST_AUTO_TEST_CASE(kinds_of_devices_and_errors_keep_their_numbers_and_names) {
    const std::pair<DeviceKind, const char*> kinds[] = {{DeviceKind::gpu, "gpu"},
                                                        {DeviceKind::processor, "processor"},
                                                        {DeviceKind::accelerator, "accelerator"},
                                                        {DeviceKind::other, "other"}};
    std::int32_t number = 0;
    for (const auto& [kind, name] : kinds) {
        BOOST_TEST(static_cast<std::int32_t>(kind) == number++);
        BOOST_TEST(name_of(kind) == std::string(name));
    }
    const std::pair<ErrorCode, const char*> codes[] = {
        {ErrorCode::invalid_mesh, "invalid_mesh"},         {ErrorCode::unreadable_input, "unreadable_input"},
        {ErrorCode::invalid_argument, "invalid_argument"}, {ErrorCode::no_device, "no_device"},
        {ErrorCode::device_failure, "device_failure"},     {ErrorCode::out_of_memory, "out_of_memory"},
        {ErrorCode::unsupported, "unsupported"},           {ErrorCode::cancelled, "cancelled"},
        {ErrorCode::output_failure, "output_failure"},     {ErrorCode::wrong_results, "wrong_results"}};
    number = 1;
    for (const auto& [code, name] : codes) {
        BOOST_TEST(static_cast<std::int32_t>(code) == number++);
        BOOST_TEST(name_of(code) == std::string(name));
    }
    BOOST_TEST(name_of(ErrorCode{0}) == std::string("unknown"));
}

BOOST_AUTO_TEST_CASE(a_program_is_built_once_for_all_threads) {
    const Device device = Device::strongest();
    std::vector<cl::Program> programs(4);
    std::vector<std::thread> threads;
    for (cl::Program& program : programs)
        threads.emplace_back([&] { program = device::context_of(device).program({"scan.cl", "-cl-std=CL1.2"}); });
    for (std::thread& thread : threads) thread.join();
    for (const cl::Program& program : programs) BOOST_TEST(program() == programs.front()());
    const cl::Program other = device::context_of(device).program({"scan.cl", "-cl-std=CL1.2 -DOTHER"});
    BOOST_TEST(other() != programs.front()());
}
