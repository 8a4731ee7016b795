// Memory of another interface as a buffer: Device::import_memory, on a GPU that takes memory of CUDA.
#include "disguise/disguise.hpp"
#include "disguise/external.hpp"
#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/throws.hpp"

#include <clsdf/clsdf.hpp>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>
#include <array>
#include <chrono>
#include <cstring>
#include <span>
#include <string>
#include <thread>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// A processor as a GPU, from before the first call of OpenCL on.
struct AsGpu {
    AsGpu() { disguise::set({.gpu = true, .external_memory = true}); }
};
BOOST_TEST_GLOBAL_FIXTURE(AsGpu);

/// Memory of CUDA as cuMemExportToShareableHandle exports it, of the disguised device or of another one.
int exported(std::size_t bytes, const std::string& uuid = disguise::uuid) {
    const int descriptor = ::memfd_create(("cuda-" + uuid).c_str(), MFD_CLOEXEC);
    BOOST_REQUIRE(descriptor >= 0);
    BOOST_REQUIRE(::ftruncate(descriptor, static_cast<off_t>(bytes)) == 0);
    return descriptor;
}

bool is_open(int descriptor) {
    return ::fcntl(descriptor, F_GETFD) >= 0;
}

using HandOver = cl_int(CL_API_CALL*)(cl_command_queue, cl_uint, const cl_mem*, cl_uint, const cl_event*, cl_event*);
void hand_over(const char* name, const Device& device, cl_mem memory) {
    cl_platform_id platform = nullptr;
    clGetDeviceInfo(device.id(), CL_DEVICE_PLATFORM, sizeof(cl_platform_id), &platform, nullptr);
    const auto function = reinterpret_cast<HandOver>(clGetExtensionFunctionAddressForPlatform(platform, name));
    BOOST_REQUIRE(function != nullptr);
    BOOST_TEST(function(device.queue(), 1, &memory, 0, nullptr, nullptr) == CL_SUCCESS);
    BOOST_TEST(clFinish(device.queue()) == CL_SUCCESS);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_field_is_computed_into_memory_of_cuda) {
    const Device& device = test_device();
    const Mesh mesh = make_shape("knot");
    const Grid grid = grid_around(mesh, 20, 3);
    const Band band = Band::symmetric(3 * grid.voxel());
    const DistanceTransform transform(device, mesh);
    Field field = transform.compute(grid, band);
    const std::span<const float> expected = field.distance();

    const std::size_t bytes = expected.size() * sizeof(float);
    const int descriptor = exported(bytes);
    const int own = ::fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
    const cl_mem memory = device.import_memory(descriptor, bytes);
    // A command may not use it before it is OpenCL's.
    BOOST_CHECK_THROW(transform.compute(grid, band, OutputArray(memory)), Error);
    hand_over("clEnqueueAcquireExternalMemObjectsKHR", device, memory);
    transform.compute(grid, band, OutputArray(memory));
    hand_over("clEnqueueReleaseExternalMemObjectsKHR", device, memory);
    const void* const seen = ::mmap(nullptr, bytes, PROT_READ, MAP_SHARED, own, 0);
    BOOST_REQUIRE(seen != MAP_FAILED);
    BOOST_TEST(std::memcmp(seen, expected.data(), bytes) == 0);
    // The driver owns the descriptor, as long as the buffer lives. PoCL ends commands some time after they are
    // complete.
    BOOST_TEST(is_open(descriptor));
    BOOST_TEST(clReleaseMemObject(memory) == CL_SUCCESS);
    for (int tries = 0; is_open(descriptor) && tries < 500; ++tries)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    BOOST_TEST(!is_open(descriptor));
    ::munmap(const_cast<void*>(seen), bytes);
    ::close(own);
}

BOOST_AUTO_TEST_CASE(what_is_refused_leaves_the_descriptor_to_the_caller) {
    const Device& device = test_device();
    const int descriptor = exported(4096);
    check_throws(ErrorCode::invalid_argument, {"0 bytes"}, [&] { device.import_memory(descriptor, 0); });
    check_throws(ErrorCode::invalid_argument,
                 {"does not take the descriptor " + std::to_string(descriptor) + " as memory of 4097 bytes",
                  "CL_INVALID_BUFFER_SIZE", "at least this size"},
                 [&] { device.import_memory(descriptor, 4097); });
    const int of_another = exported(4096, "another-device-0");
    check_throws(ErrorCode::invalid_argument, {"CL_INVALID_DEVICE", "memory of this device"},
                 [&] { device.import_memory(of_another, 4096); });
    disguise::restart({.call = "clCreateBufferWithProperties", .number = 1, .code = CL_OUT_OF_RESOURCES});
    check_throws(ErrorCode::device_failure, {"clCreateBufferWithProperties", "CL_OUT_OF_RESOURCES"},
                 [&] { device.import_memory(descriptor, 4096); });
    disguise::restart();
    for (const int own : {descriptor, of_another}) {
        BOOST_TEST(is_open(own));
        ::close(own);
    }
    for (const int closed : {descriptor, -1})
        check_throws(ErrorCode::invalid_argument,
                     {"the descriptor " + std::to_string(closed) + " is not open", "before the descriptor is closed"},
                     [&] { device.import_memory(closed, 4096); });
}

BOOST_AUTO_TEST_CASE(a_device_without_the_extension_says_so) {
    disguise::set({.gpu = true});
    const int descriptor = exported(4096);
    check_throws(ErrorCode::unsupported, {"has no cl_khr_external_memory_opaque_fd", "drivers from 510 on"},
                 [&] { test_device().import_memory(descriptor, 4096); });
    BOOST_TEST(is_open(descriptor));
    ::close(descriptor);
}
