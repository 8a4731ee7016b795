#include "cuda/lanes.hpp"

#include <clsdf/error.hpp>

#include <unistd.h>
#include <array>
#include <chrono>
#include <memory>
#include <thread>
#include <utility>

namespace clsdf::cuda {

namespace {

// Constants of OpenCL's extensions.
constexpr cl_ulong semaphore_type = 0x203D;   // CL_SEMAPHORE_TYPE_KHR
constexpr cl_ulong binary = 1;                // CL_SEMAPHORE_TYPE_BINARY_KHR
constexpr cl_ulong export_types = 0x203F;     // CL_SEMAPHORE_EXPORT_HANDLE_TYPES_KHR
constexpr cl_uint opaque_semaphore = 0x2055;  // CL_SEMAPHORE_HANDLE_OPAQUE_FD_KHR
// Constants of CUDA.
constexpr unsigned without_timing = 2;       // CU_EVENT_DISABLE_TIMING
constexpr unsigned non_blocking_stream = 1;  // CU_STREAM_NON_BLOCKING

}  // namespace

SharedSemaphore::SharedSemaphore(const Link& own) : link(own) {
    const Extensions& extensions = link.extensions();
    const std::array<cl_ulong, 6> properties{semaphore_type, binary, export_types, opaque_semaphore, 0, 0};
    cl_int code = CL_SUCCESS;
    of_opencl = extensions.create(link.device().context(), properties.data(), &code);
    check_cl(code, "clCreateSemaphoreWithPropertiesKHR");
    SemaphoreDescription description;
    code = extensions.handle(of_opencl, link.device().id(), opaque_semaphore, sizeof(int), &description.descriptor,
                             nullptr);
    const Current current(link.context());
    const int imported = code == CL_SUCCESS ? driver().import_semaphore(&of_cuda, &description) : 0;
    if (code == CL_SUCCESS && imported == 0) return;
    if (code == CL_SUCCESS) ::close(description.descriptor);
    extensions.destroy(of_opencl);
    check_cl(code, "clGetSemaphoreHandleForTypeKHR");
    check(imported, "cuImportExternalSemaphore");
}

SharedSemaphore::~SharedSemaphore() {
    driver().destroy_semaphore(of_cuda);
    link.extensions().destroy(of_opencl);
}

Lane::Lane(Link& own) : link(own) {
    check(driver().create_event(&latest, without_timing), "cuEventCreate");
    if (const int code = driver().create_event(&crossing, without_timing)) {
        driver().destroy_event(latest);
        check(code, "cuEventCreate");
    }
}

Lane::~Lane() {
    semaphores.reset();
    driver().destroy_event(crossing);
    driver().destroy_event(latest);
}

bool Link::has_semaphores() {
    std::call_once(is_tried_, [this] {
        const bool is_complete = extensions_.create != nullptr && extensions_.destroy != nullptr &&
                                 extensions_.handle != nullptr && extensions_.wait != nullptr &&
                                 extensions_.signal != nullptr;
        try {
            has_semaphores_ = is_complete && try_semaphores();
        } catch (const Error&) {  // a driver that cannot make them: calls wait instead
        }
    });
    return has_semaphores_;
}

// CUDA signals, OpenCL waits and signals, CUDA waits. A driver that has not done this in a second never does. The
// test's objects are left to it then, and each side signals itself, so that no later wait for the whole device waits
// for them.
bool Link::try_semaphores() {
    constexpr std::chrono::seconds limit{1};
    const Current current(context_);
    const Driver& cuda = driver();
    auto lane = std::make_unique<Lane>(*this);
    lane->semaphores = std::make_unique<Semaphores>(*this);
    Stream stream = nullptr;
    check(cuda.create_stream(&stream, non_blocking_stream), "cuStreamCreate");
    cl_int code = CL_SUCCESS;
    const cl_command_queue queue = clCreateCommandQueue(device_.context(), device_.id(), 0, &code);
    if (code != CL_SUCCESS) cuda.destroy_stream(stream);
    check_cl(code, "clCreateCommandQueue");
    const Semaphores& both = *lane->semaphores;
    const SemaphoreParameters parameters;
    const int failed = cuda.signal(&both.to_opencl.of_cuda, &parameters, 1, stream) != 0 ||
                       extensions_.wait(queue, 1, &both.to_opencl.of_opencl, nullptr, 0, nullptr, nullptr) != 0 ||
                       extensions_.signal(queue, 1, &both.to_cuda.of_opencl, nullptr, 0, nullptr, nullptr) != 0 ||
                       clFlush(queue) != 0 || cuda.wait(&both.to_cuda.of_cuda, &parameters, 1, stream) != 0 ||
                       cuda.record_event(lane->latest, stream) != 0;
    const auto begin = std::chrono::steady_clock::now();
    bool is_done = false;
    while (failed == 0 && !is_done && std::chrono::steady_clock::now() - begin < limit) {
        is_done = cuda.query_event(lane->latest) == 0;
        if (!is_done) std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
    if (!is_done) {
        static_cast<void>(lane.release());
        Stream second_stream = nullptr;
        if (cuda.create_stream(&second_stream, non_blocking_stream) == 0)
            cuda.signal(&both.to_cuda.of_cuda, &parameters, 1, second_stream);
        const cl_command_queue second_queue = clCreateCommandQueue(device_.context(), device_.id(), 0, &code);
        if (code == CL_SUCCESS) {
            extensions_.signal(second_queue, 1, &both.to_opencl.of_opencl, nullptr, 0, nullptr, nullptr);
            clFlush(second_queue);
        }
        return false;
    }
    clReleaseCommandQueue(queue);
    cuda.destroy_stream(stream);
    give_back(std::move(lane));
    return true;
}

}  // namespace clsdf::cuda
