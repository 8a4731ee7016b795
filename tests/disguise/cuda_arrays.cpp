// Memory of CUDA as inputs and outputs: clsdf::cuda, on a GPU that shares memory with the stand-in for CUDA's driver,
// and semaphores unless CLSDF_DISGUISE_EXTERNAL is "memory".
#include "disguise/disguise.hpp"
#include "support/exact_field.hpp"
#include "support/throws.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/cuda.hpp>

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <cuda.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

bool has_semaphores() {
    const char* const external = std::getenv("CLSDF_DISGUISE_EXTERNAL");
    return external == nullptr || std::string(external) != "memory";
}

/// A processor as a GPU, from before the first call of OpenCL on.
struct AsGpu {
    AsGpu() { disguise::set({.gpu = true, .external_memory = true, .external_semaphores = has_semaphores()}); }
};
BOOST_TEST_GLOBAL_FIXTURE(AsGpu);

void done(CUresult code) {
    BOOST_REQUIRE(code == CUDA_SUCCESS);
}

/// The primary context of a device of CUDA is the current one. The second device is the disguised GPU.
class InContext {
public:
    explicit InContext(int device = 1) : device_(device) {
        done(cuInit(0));
        CUcontext context = nullptr;
        done(cuDevicePrimaryCtxRetain(&context, device));
        done(cuCtxPushCurrent(context));
    }
    InContext(const InContext&) = delete;
    InContext& operator=(const InContext&) = delete;
    ~InContext() {
        cuCtxPopCurrent(nullptr);
        cuDevicePrimaryCtxRelease(device_);
    }

private:
    int device_;
};

/// Memory of cudaMalloc, which cannot be exported, used on one stream.
template <typename Value>
class CudaArray {
public:
    explicit CudaArray(std::size_t count, CUstream stream = nullptr) : count_(count), stream_(stream) {
        done(cuMemAlloc(&address_, count * sizeof(Value)));
    }
    explicit CudaArray(std::span<const Value> values, CUstream stream = nullptr) : CudaArray(values.size(), stream) {
        set(values);
    }
    CudaArray(const CudaArray&) = delete;
    CudaArray& operator=(const CudaArray&) = delete;
    ~CudaArray() {
        if (address_ != 0) cuMemFree(address_);
    }

    std::uint64_t address() const { return address_; }
    void set(std::span<const Value> values) {
        done(cuMemcpyHtoDAsync(address_, values.data(), values.size_bytes(), stream_));
    }
    std::vector<Value> get() const {
        std::vector<Value> values(count_);
        done(cuMemcpyDtoHAsync(values.data(), address_, count_ * sizeof(Value), stream_));
        return values;
    }
    cuda::Array as(cuda::Access access, const std::string& name = "the array") const {
        return {address_, count_ * sizeof(Value), access, stream_, name};
    }

private:
    CUdeviceptr address_ = 0;
    std::size_t count_;
    CUstream stream_;
};

CUstream new_stream() {
    CUstream stream = nullptr;
    done(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING));
    return stream;
}

/// The stream goes on a while later; `has_gone_on` then says so.
void delay(CUstream stream, std::atomic<bool>& has_gone_on) {
    has_gone_on = false;
    done(cuLaunchHostFunc(
        stream,
        [](void* flag) {
            std::this_thread::sleep_for(std::chrono::milliseconds(200));
            *static_cast<std::atomic<bool>*>(flag) = true;
        },
        &has_gone_on));
}

/// The event of a run's end.
struct End {
    cl_event event = nullptr;
    End() = default;
    End(const End&) = delete;
    End& operator=(const End&) = delete;
    ~End() {
        if (event != nullptr) clReleaseEvent(event);
    }
};

struct Expected {
    Mesh mesh = make_shape("knot");
    Grid grid = grid_around(mesh, 20, 3);
    Band band = Band::symmetric(3 * grid.voxel());
    DistanceTransform transform{test_device(), mesh};
    Field field = transform.compute(grid, band);
    std::vector<float> distance{field.distance().begin(), field.distance().end()};
};
const Expected& expected() {
    static const auto* const only = new Expected;
    return *only;
}

const cuda::SharedDevice& gpu() {
    static const auto* const only = new cuda::SharedDevice(test_device());
    return *only;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_mesh_and_a_field_stay_in_memory_of_cuda) {
    BOOST_TEST(gpu().ordinal() == 1);
    const Expected& all = expected();
    const Mesh& mesh = all.mesh;
    const Grid& grid = all.grid;
    const Band& band = all.band;
    std::vector<float> moved;
    for (const Vec3& vertex : mesh.vertices())
        for (const double x : vertex) moved.push_back(static_cast<float>(x + 0.1));
    DistanceTransform transform(test_device(), mesh);
    std::vector<std::uint32_t> indices;
    for (const Triangle& triangle : mesh.triangles()) indices.insert(indices.end(), triangle.begin(), triangle.end());
    const InContext context;
    const CudaArray<float> positions(moved);
    const CudaArray<std::uint32_t> triangles(indices);
    const CudaArray<float> results(grid.sample_count());

    cuda::Arrays arrays(
        gpu(), {positions.as(cuda::Access::read), triangles.as(cuda::Access::read), results.as(cuda::Access::write)});
    const InputArray vertices = arrays.input(0, ElementType::float32, mesh.vertices().size());
    arrays.begin();
    const DistanceTransform own(test_device(),
                                MeshView(vertices, arrays.input(1, ElementType::uint32, mesh.triangles().size())));
    own.compute(grid, band, arrays.output(2));
    arrays.end();
    transform.set_positions(InputArray(moved));
    Field again = transform.compute(grid, band);
    const std::span<const float> wanted = again.distance();
    BOOST_TEST(results.get() == std::vector(wanted.begin(), wanted.end()), boost::test_tools::per_element());
    BOOST_TEST(results.get() != all.distance);
}

BOOST_AUTO_TEST_CASE(the_current_context_is_as_before) {
    CUcontext current = nullptr;
    {
        const InContext context;
        const CudaArray<float> results(expected().grid.sample_count());
        std::thread([&] {
            CUcontext of_thread = nullptr;
            cuda::Arrays arrays(gpu(), {results.as(cuda::Access::write)});
            arrays.begin();
            expected().transform.compute(expected().grid, expected().band, arrays.output(0));
            arrays.end();
            done(cuCtxGetCurrent(&of_thread));
            BOOST_TEST(of_thread == nullptr);
        }).join();
        BOOST_TEST(results.get() == expected().distance, boost::test_tools::per_element());
    }
    done(cuCtxGetCurrent(&current));
    BOOST_TEST(current == nullptr);
}

BOOST_AUTO_TEST_CASE(shared_memory_is_used_where_it_lies) {
    const Expected& all = expected();
    const std::vector<float>& distance = all.distance;
    const InContext context;
    const std::size_t bytes = distance.size() * sizeof(float);
    const cuda::SharedMemory memory(gpu(), 2 * bytes);
    BOOST_TEST(memory.bytes() >= 2 * bytes);
    const int copies = cuda_stand_in_calls("cuMemcpyDtoDAsync_v2");
    for (const std::size_t first : {std::size_t{0}, bytes}) {
        cuda::Arrays arrays(gpu(), {{memory.address() + first, bytes, cuda::Access::write}});
        BOOST_TEST(arrays[0].memory == memory.buffer());
        BOOST_TEST(arrays[0].offset == first);
        arrays.begin();
        all.transform.compute(all.grid, all.band, arrays.output(0));
        arrays.end();
        std::vector<float> results(distance.size());
        gpu().copy_to_host({memory.address() + first, bytes}, results.data());
        BOOST_TEST(results == distance, boost::test_tools::per_element());
    }
    BOOST_TEST(cuda_stand_in_calls("cuMemcpyDtoDAsync_v2") == copies);
    // An array keeps the memory in which it lies.
    auto own = std::make_unique<cuda::SharedMemory>(gpu(), bytes);
    const std::vector<float> zeros(distance.size());
    gpu().copy_from_host(zeros.data(), {own->address(), bytes});
    cuda::Arrays arrays(gpu(), {{own->address(), bytes, cuda::Access::write}});
    const std::uint64_t address = own->address();
    own.reset();
    arrays.begin();
    all.transform.compute(all.grid, all.band, arrays.output(0));
    arrays.end();
    std::vector<float> results(distance.size());
    gpu().copy_to_host({address, bytes}, results.data());
    BOOST_TEST(results == distance, boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(a_run_follows_the_streams_and_they_follow_it) {
    const DistanceTransform& transform = expected().transform;
    std::vector<Vec3> points;
    for (int n = 0; n < 500; ++n) points.push_back({0.001 * n, 0.002 * n - 0.3, 0.2});
    std::vector<float> distance(points.size());
    const double everywhere = std::numeric_limits<double>::infinity();
    transform.query(points, everywhere, OutputArray(distance));
    const InContext context;
    PointPlan plan = transform.plan_points(points.size(), everywhere);
    const CUstream first = new_stream(), second = new_stream();
    CudaArray<Vec3> asked(points.size(), first);
    CudaArray<float> results(points.size(), second);
    cuda::Arrays arrays(gpu(), {asked.as(cuda::Access::read), results.as(cuda::Access::write)});
    BOOST_TEST(gpu().has_semaphores() == has_semaphores());
    std::atomic<bool> has_gone_on = false;
    for (int n = 0; n < 3; ++n) {
        const std::vector<Vec3> nothing(points.size());
        asked.set(nothing);
        delay(first, has_gone_on);
        asked.set(points);  // in the order of the stream: when it has gone on
        End end;
        plan.enqueue(nullptr, arrays.input(0, ElementType::float64, points.size()), arrays.output(1),
                     arrays.begin(nullptr), &end.event);
        arrays.end(end.event);
        BOOST_TEST(has_gone_on == !has_semaphores());
        BOOST_TEST(results.get() == distance, boost::test_tools::per_element());
        BOOST_TEST(has_gone_on);
    }
    // Other streams: those of the arrays are not waited for.
    const std::array<void*, 1> now{second};
    arrays.follow(now);
    asked.set(points);
    done(cuStreamSynchronize(first));
    delay(first, has_gone_on);
    End end;
    plan.enqueue(nullptr, arrays.input(0, ElementType::float64, points.size()), arrays.output(1), arrays.begin(nullptr),
                 &end.event);
    arrays.end(end.event);
    BOOST_TEST(results.get() == distance, boost::test_tools::per_element());
    BOOST_TEST(!has_gone_on);
    done(cuStreamSynchronize(first));
    // One stream after another.
    delay(first, has_gone_on);
    gpu().order(first, second);
    done(cuStreamSynchronize(second));
    BOOST_TEST(has_gone_on);
    for (const CUstream stream : {first, second}) done(cuStreamDestroy(stream));
}

BOOST_AUTO_TEST_CASE(bytes_between_the_values_stay) {
    const Expected& all = expected();
    const std::size_t samples = all.distance.size();
    std::vector<float> distance(samples), gradient(3 * samples);
    all.transform.compute(all.grid, all.band, {{Output::distance, distance}, {Output::gradient, gradient}});
    const InContext context;
    // Five floats a sample: the distance, the gradient, and one of the caller's. The arrays overlap.
    const std::vector<float> before(5 * samples, 7.0F);
    const CudaArray<float> results(before);
    const std::size_t bytes = before.size() * sizeof(float);
    cuda::Arrays arrays(gpu(), {{results.address(), bytes - 16, cuda::Access::update},
                                {results.address() + 4, bytes - 8, cuda::Access::update}});
    const auto apart = [&](OutputArray array) {
        const auto step = static_cast<std::ptrdiff_t>(5 * sizeof(float));
        array.strides = {step, step * all.grid.size[0], step * all.grid.size[0] * all.grid.size[1]};
        return array;
    };
    arrays.begin();
    all.transform.compute(all.grid, all.band,
                          {{Output::distance, apart(arrays.output(0))}, {Output::gradient, apart(arrays.output(1))}});
    arrays.end();
    std::vector<float> wanted = before;
    for (std::size_t n = 0; n < samples; ++n) {
        wanted[5 * n] = distance[n];
        std::copy_n(&gradient[3 * n], 3, &wanted[5 * n + 1]);
    }
    BOOST_TEST(std::memcmp(results.get().data(), wanted.data(), bytes) == 0);
}

BOOST_AUTO_TEST_CASE(what_cannot_be_is_refused_by_name) {
    const auto refused = [](const std::vector<std::string>& said, const auto& action) {
        check_throws(ErrorCode::invalid_argument, said, action);
    };
    const Expected& all = expected();
    const InContext context;
    const CudaArray<float> results(all.distance.size());
    const cuda::Array array = results.as(cuda::Access::write, "phi");
    refused({"no array", "give one"}, [] { cuda::Arrays(gpu(), std::span<const cuda::Array>()); });
    refused({"phi has 0 bytes"}, [&] { cuda::Arrays(gpu(), {{array.address, 0, array.access, nullptr, "phi"}}); });
    refused({"phi names an address that CUDA's driver does not know", "freed"}, [] {
        cuda::Arrays(gpu(), {{4096, 8, cuda::Access::read, nullptr, "phi"}});
    });
    {
        const InContext another(0);
        const CudaArray<float> there(1);
        refused({"phi lies on device 0 of CUDA, and clsdf computes on device 1", "move it there"},
                [&] { cuda::Arrays(gpu(), {there.as(cuda::Access::read, "phi")}); });
    }
    const cuda::SharedMemory memory(gpu(), 1);
    refused({"phi has", "reaches beyond the shared memory"}, [&] {
        cuda::Arrays(gpu(), {{memory.address() + 8, memory.bytes(), cuda::Access::read, nullptr, "phi"}});
    });

    cuda::Arrays arrays(gpu(), {array});
    refused({"no array 1; there are 1"}, [&] { static_cast<void>(arrays[1]); });
    refused({"end()", "without its begin()"}, [&] { arrays.end(); });
    refused({"end(done)", "without its begin()"}, [&] { arrays.end(nullptr); });
    refused({"no stream"}, [&] { arrays.follow({}); });
    const Device another = Device::select(test_device().name());
    refused({"another context"}, [&] { arrays.begin(another.queue()); });
    arrays.begin();
    refused({"begin()", "before the end()", "abandon()"}, [&] { arrays.begin(); });
    refused({"begin(queue)", "before the end()"}, [&] { arrays.begin(nullptr); });
    refused({"end(done)", "without its begin()"}, [&] { arrays.end(nullptr); });
    arrays.end();
    arrays.begin(nullptr);
    refused({"no event"}, [&] { arrays.end(nullptr); });
    arrays.abandon();
    arrays.abandon();
    arrays.begin();
    all.transform.compute(all.grid, all.band, arrays.output(0));
    arrays.end();
    BOOST_TEST(results.get() == all.distance, boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(a_call_that_fails_gives_the_memory_back) {
    const Expected& all = expected();
    const std::vector<float>& distance = all.distance;
    const InContext context;
    const std::size_t bytes = distance.size() * sizeof(float);
    const cuda::SharedMemory memory(gpu(), bytes);
    const CudaArray<float> results(distance.size());
    for (const cuda::Array& array :
         {results.as(cuda::Access::write), cuda::Array{memory.address(), bytes, cuda::Access::write}}) {
        for (int n = 0; n < 2; ++n)
            check_throws(ErrorCode::cancelled, {}, [&] {
                cuda::Arrays arrays(gpu(), {array});
                arrays.begin();
                all.transform.compute(all.grid, all.band, arrays.output(0), {.should_stop = [] { return true; }});
                arrays.end();
            });
        // Each call of CUDA that a run makes fails once; the run after it is right.
        Plan plan = all.transform.plan(all.grid, all.band);
        cuda::Arrays arrays(gpu(), {array});
        for (const char* const call : {"cuMemcpyDtoDAsync_v2", "cuEventRecord", "cuSignalExternalSemaphoresAsync",
                                       "cuWaitExternalSemaphoresAsync", "cuStreamSynchronize"}) {
            const auto run = [&] {
                End end;
                plan.enqueue(nullptr, arrays.output(0), arrays.begin(nullptr), &end.event);
                arrays.end(end.event);
            };
            int calls = cuda_stand_in_calls(call);
            run();
            if (calls == cuda_stand_in_calls(call)) continue;
            calls = cuda_stand_in_calls(call);
            ::setenv("CLSDF_CUDA_FAULT", (std::string(call) + ":" + std::to_string(calls + 1)).c_str(), 1);
            check_throws(ErrorCode::device_failure, {std::string(call).substr(0, 13), "CUDA_ERROR_UNKNOWN (999)"}, run);
            ::unsetenv("CLSDF_CUDA_FAULT");
            arrays.abandon();
            run();
            std::vector<float> values(distance.size());
            gpu().copy_to_host({array.address, bytes}, values.data());
            BOOST_TEST(values == distance, boost::test_tools::per_element());
        }
    }
}

BOOST_AUTO_TEST_CASE(memory_and_context_are_given_back) {
    const InContext context;
    const int owners = cuda_stand_in_owners(1);
    {
        const cuda::SharedDevice own(test_device());
        BOOST_TEST(cuda_stand_in_owners(1) == owners + 1);
        const CudaArray<float> results(expected().distance.size());
        {
            cuda::Arrays arrays(own, {results.as(cuda::Access::write)});
            BOOST_TEST(own.release_memory() == 0);
        }
        BOOST_TEST(own.release_memory() >= expected().distance.size() * sizeof(float));
        BOOST_TEST(own.release_memory() == 0);
    }
    BOOST_TEST(cuda_stand_in_owners(1) == owners);
}

BOOST_AUTO_TEST_CASE(without_a_shared_device_the_remedy_is_told) {
    ::setenv("CLSDF_CUDA_DEVICES", "1", 1);
    check_throws(ErrorCode::no_device,
                 {"does not list the device", "636c7364-662d-6469-7367-756973652d31", "CUDA_VISIBLE_DEVICES"},
                 [] { const cuda::SharedDevice own(test_device()); });
    ::unsetenv("CLSDF_CUDA_DEVICES");
    disguise::set({.gpu = true});
    check_throws(ErrorCode::unsupported,
                 {"has no cl_khr_device_uuid", "shares no memory with CUDA", "copy of the array"},
                 [] { const cuda::SharedDevice own(test_device()); });
}
