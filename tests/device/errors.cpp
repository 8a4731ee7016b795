#include "support/throws.hpp"

#include <clsdf/device.hpp>

#include "device/context.hpp"

#include <vector>

using namespace clsdf;

BOOST_AUTO_TEST_CASE(a_failed_call_is_named_with_its_code) {
    const Device device = Device::strongest();
    const device::Context& context = device::context_of(device);
    const cl::Buffer buffer(context.context(), CL_MEM_READ_WRITE, 64);
    std::vector<char> beyond(128);
    test::check_throws(ErrorCode::device_failure, {"clEnqueueReadBuffer", "CL_INVALID_VALUE"}, [&] {
        device::guarded([&] { context.queue().enqueueReadBuffer(buffer, CL_TRUE, 0, beyond.size(), beyond.data()); });
    });
    test::check_throws(ErrorCode::device_failure, {"clCreateKernel", "CL_INVALID_KERNEL_NAME"}, [&] {
        device::guarded([&] {
            cl::Kernel(device::context_of(device).program({"scan.cl", "-cl-std=CL1.2"}), "absent");
        });
    });
}

BOOST_AUTO_TEST_CASE(an_error_carries_the_code_of_the_call) {
    try {
        device::guarded([] { throw cl::Error(CL_INVALID_BUFFER_SIZE, "clCreateBuffer"); });
        BOOST_ERROR("nothing was thrown");
    } catch (const Error& error) {
        BOOST_TEST(error.opencl_code() == CL_INVALID_BUFFER_SIZE);
    }
    BOOST_TEST(Error(ErrorCode::invalid_mesh, "").opencl_code() == 0);
}

// As OpenCL spells it, also if the C++ binding does not.
BOOST_AUTO_TEST_CASE(a_failed_call_has_the_name_that_opencl_gives_it) {
    const Device device = Device::strongest();
    const device::Context& context = device::context_of(device);
    const cl::Buffer buffer(context.context(), CL_MEM_READ_WRITE, 64);
    test::check_throws(ErrorCode::device_failure, {"clEnqueueUnmapMemObject", "CL_INVALID_VALUE"},
                       [&] { device::guarded([&] { context.queue().enqueueUnmapMemObject(buffer, nullptr); }); });
    test::check_throws(ErrorCode::device_failure, {"clGetEventProfilingInfo"}, [&] {
        device::guarded([&] { return cl::UserEvent(context.context()).getProfilingInfo<CL_PROFILING_COMMAND_END>(); });
    });
}

BOOST_AUTO_TEST_CASE(memory_of_another_context_is_a_failed_call) {
    const Device device = Device::strongest();
    const cl::Context other(cl::Device(device.id(), true));
    const cl::Buffer foreign(other, CL_MEM_READ_WRITE, 64);
    test::check_throws(ErrorCode::device_failure, {"clEnqueueFillBuffer", "CL_INVALID_CONTEXT"}, [&] {
        device::guarded([&] { device::context_of(device).queue().enqueueFillBuffer(foreign, cl_uint{0}, 0, 64); });
    });
}

BOOST_AUTO_TEST_CASE(a_failed_allocation_is_a_lack_of_memory_with_a_remedy) {
    const Device device = Device::strongest();
    test::check_throws(ErrorCode::out_of_memory, {"clCreateBuffer", "CL_INVALID_BUFFER_SIZE", "smaller part"}, [&] {
        device::guarded([&] { cl::Buffer(device::context_of(device).context(), CL_MEM_READ_WRITE, 0); });
    });
}

BOOST_AUTO_TEST_CASE(every_code_has_a_text) {
    BOOST_TEST(device::code_name(CL_OUT_OF_RESOURCES) == "CL_OUT_OF_RESOURCES");
    BOOST_TEST(device::code_name(CL_INVALID_COMMAND_QUEUE) == "CL_INVALID_COMMAND_QUEUE");
    BOOST_TEST(device::code_name(-1001) == "CL_PLATFORM_NOT_FOUND_KHR");
    BOOST_TEST(device::code_name(-9999).find("illegal read or write") != std::string::npos);
    BOOST_TEST(device::code_name(-12345) == "OpenCL error -12345");
    for (int code = -72; code < 0; ++code) {
        if (code < -19 && code > -30) continue;  // OpenCL has none
        BOOST_TEST(device::code_name(code).starts_with("CL_"), device::code_name(code));
    }
}

BOOST_AUTO_TEST_CASE(a_kernel_that_does_not_build_is_an_error_with_the_compilers_words) {
    const Device device = Device::strongest();
    // The kernels' vectors have 8 or 16 lanes.
    test::check_throws(
        ErrorCode::device_failure,
        {"clBuildProgram", "CL_BUILD_PROGRAM_FAILURE", "coarse_lists.cl", "-DLANES=3", device.name(), "floatL"}, [&] {
            device::context_of(device).program({"coarse_lists.cl", "-cl-std=CL1.2 -DLANES=3"});
        });
}

BOOST_AUTO_TEST_CASE(a_kernel_file_that_is_not_there_is_named) {
    test::check_throws(ErrorCode::device_failure, {"absent.cl"}, [] { device::kernel_text("absent.cl"); });
}

BOOST_AUTO_TEST_CASE(the_core_has_no_kernels_of_pictures_and_benchmarks) {
    for (const char* file : {"render.cl", "bench_floors.cl"})
        test::check_throws(ErrorCode::device_failure, {file}, [&] { device::kernel_text(file); });
}

BOOST_AUTO_TEST_CASE(a_kernels_text_holds_each_included_file_once) {
    const std::string text = device::kernel_text("coarse_lists.cl");
    BOOST_TEST(text.find("#include \"") == std::string::npos);
    const std::size_t first = text.find("typedef struct Polyhedron {");
    BOOST_TEST(first != std::string::npos);
    BOOST_TEST(text.find("typedef struct Polyhedron {", first + 1) == std::string::npos);
}
