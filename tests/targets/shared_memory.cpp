#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/test_meshes.hpp"

#include "device/context.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

// Shared virtual memory (SVM) of the caller's: a buffer that is made of it with CL_MEM_USE_HOST_PTR is memory like any
// other.

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// Memory that the host and the device address by one pointer, and a buffer of it.
class SharedMemory {
public:
    /// Nothing if the device or the loader of OpenCL has no shared memory.
    static std::optional<SharedMemory> make(std::size_t bytes) {
        const device::Context& context = device::context_of(test_device());
        constexpr cl_device_info svm_capabilities = 0x1053;  // CL_DEVICE_SVM_CAPABILITIES of OpenCL 2.0
        cl_bitfield capabilities = 0;
        const auto allocate = reinterpret_cast<Allocate>(dlsym(RTLD_DEFAULT, "clSVMAlloc"));
        const auto free = reinterpret_cast<Free>(dlsym(RTLD_DEFAULT, "clSVMFree"));
        if (clGetDeviceInfo(context.device()(), svm_capabilities, sizeof capabilities, &capabilities, nullptr) !=
                CL_SUCCESS ||
            capabilities == 0 || allocate == nullptr || free == nullptr)
            return std::nullopt;
        void* const memory = allocate(context.context()(), CL_MEM_READ_WRITE, bytes, 0);
        if (memory == nullptr) return std::nullopt;
        return SharedMemory(memory, free, bytes);
    }
    SharedMemory(SharedMemory&& other) noexcept
        : memory_(std::exchange(other.memory_, nullptr)), free_(other.free_), buffer_(std::move(other.buffer_)) {}
    SharedMemory(const SharedMemory&) = delete;
    SharedMemory& operator=(const SharedMemory&) = delete;
    SharedMemory& operator=(SharedMemory&&) = delete;
    ~SharedMemory() {
        if (memory_ == nullptr) return;
        buffer_ = cl::Buffer();  // before its memory
        free_(context(), memory_);
    }

    cl_mem buffer() const { return buffer_(); }

    template <typename Value>
    void write(const std::vector<Value>& values) const {
        queue().enqueueWriteBuffer(buffer_, CL_TRUE, 0, values.size() * sizeof(Value), values.data());
    }

    /// Whether the shared memory itself begins with these values.
    template <typename Array>
    bool holds(const Array& values) const {
        const std::size_t bytes = values.size() * sizeof(typename Array::value_type);
        void* const mapped = queue().enqueueMapBuffer(buffer_, CL_TRUE, CL_MAP_READ, 0, bytes);
        const bool is_equal = mapped == memory_ && std::memcmp(memory_, values.data(), bytes) == 0;
        queue().enqueueUnmapMemObject(buffer_, mapped);
        queue().finish();
        return is_equal;
    }

private:
    using Allocate = void* (*)(cl_context, cl_bitfield, std::size_t, cl_uint);
    using Free = void (*)(cl_context, void*);

    SharedMemory(void* memory, Free free, std::size_t bytes)
        : memory_(memory),
          free_(free),
          buffer_(cl::Context(context(), true), CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, bytes, memory) {}

    static cl_context context() { return device::context_of(test_device()).context()(); }
    static const cl::CommandQueue& queue() { return device::context_of(test_device()).queue(); }

    void* memory_;
    Free free_;
    cl::Buffer buffer_;
};

}  // namespace

BOOST_AUTO_TEST_CASE(buffers_of_shared_memory_are_positions_points_and_targets) {
    const Mesh mesh = make_shape("knot"), moved = tilted(mesh);
    const Grid grid = grid_around(mesh, 40, 5);
    const Band band = Band::symmetric(3 * grid.voxel());
    const std::vector<Vec3>& points = mesh.vertices();  // of the mesh before it moves
    const auto positions = SharedMemory::make(moved.vertices().size() * sizeof(Vec3));
    const auto places = SharedMemory::make(points.size() * sizeof(Vec3));
    const auto distance = SharedMemory::make(std::max(grid.sample_count(), points.size()) * sizeof(float));
    if (!positions || !places || !distance) {
        BOOST_TEST_MESSAGE("skipped: the device has no shared virtual memory");
        return;
    }
    DistanceTransform transform(test_device(), mesh), expected(test_device(), mesh);
    positions->write(moved.vertices());
    places->write(points);
    transform.set_positions(InputArray(positions->buffer(), ElementType::float64, moved.vertices().size()));
    expected.set_positions(moved.vertices());
    const Field field = expected.compute(grid, band);
    BOOST_TEST(same_bytes(transform.compute(grid, band), field));

    transform.compute(grid, band, {{Output::distance, OutputArray(distance->buffer())}});
    BOOST_TEST(distance->holds(field.distance()));

    std::vector<float> of_points(points.size());
    expected.query(points, 0.3, of_points);
    transform.query(InputArray(places->buffer(), ElementType::float64, points.size()), 0.3,
                    {{Output::distance, OutputArray(distance->buffer())}});
    BOOST_TEST(distance->holds(of_points));

    Plan plan = transform.plan(grid, band);
    enqueue(plan, nullptr, {{Output::distance, distance->buffer()}}).wait();
    BOOST_TEST(distance->holds(field.distance()));
}
