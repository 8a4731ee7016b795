// Computes the field of a moving body from device pointers of CUDA into a device pointer of CUDA.
//
// The positions and the field are used on the program's stream: each step moves the vertices, takes their positions and
// computes the field, all in the order of the stream. Memory of cudaMalloc() (here cuMemAlloc()) is copied within the
// GPU. The field lies in memory that CUDA and OpenCL share, so that it is written in place. clsdf opens CUDA's driver
// at run time. This program includes cuda.h and links libcuda, as a code that uses CUDA does.

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <cuda.h>
#include <clsdf/clsdf.hpp>
#include <clsdf/cuda.hpp>

#include "recorded.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <span>
#include <vector>

namespace {

void require(CUresult code, const char* call) {
    if (code == CUDA_SUCCESS) return;
    std::fprintf(stderr, "%s failed: CUDA error %d\n", call, static_cast<int>(code));
    std::exit(2);
}

/// The context, the stream and the memory of the simulation.
struct Simulation {
    int device;
    CUstream stream = nullptr;
    CUdeviceptr positions = 0;

    Simulation(int device_in, std::size_t vertices) : device(device_in) {
        CUcontext context = nullptr;
        require(cuInit(0), "cuInit");
        require(cuDevicePrimaryCtxRetain(&context, device), "cuDevicePrimaryCtxRetain");
        require(cuCtxPushCurrent(context), "cuCtxPushCurrent");
        require(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING), "cuStreamCreate");
        require(cuMemAlloc(&positions, vertices * sizeof(clsdf::Vec3)), "cuMemAlloc");
    }
    Simulation(const Simulation&) = delete;
    Simulation& operator=(const Simulation&) = delete;
    ~Simulation() {
        cuMemFree(positions);
        cuStreamDestroy(stream);
        cuCtxPopCurrent(nullptr);
        cuDevicePrimaryCtxRelease(device);
    }

    /// New positions, here from the host; a code with kernels launches them on the stream.
    void move(std::span<const clsdf::Vec3> rest, int step) const {
        std::vector<clsdf::Vec3> moved(rest.begin(), rest.end());
        for (clsdf::Vec3& vertex : moved)
            for (double& x : vertex) x *= 1 + 0.1 * step;
        require(cuMemcpyHtoDAsync(positions, moved.data(), moved.size() * sizeof(clsdf::Vec3), stream),
                "cuMemcpyHtoDAsync");
    }
    /// The simulation's own use of a field, later on the stream.
    std::vector<float> read(CUdeviceptr field, std::size_t samples) const {
        std::vector<float> distance(samples);
        require(cuMemcpyDtoHAsync(distance.data(), field, samples * sizeof(float), stream), "cuMemcpyDtoHAsync");
        require(cuStreamSynchronize(stream), "cuStreamSynchronize");
        return distance;
    }
};

/// The volume of a solid whose samples have these distances: a smoothed sum, `width` on both sides of the surface.
double volume_of(std::span<const float> distance, double cell, double width) {
    double sum = 0;
    for (const double d : distance) sum += 0.5 * (1 - std::clamp(d / width, -1.0, 1.0));
    return sum * cell;
}

}  // namespace

int main() {
    try {
        using clsdf::ElementType;
        using clsdf::cuda::Access;
        const clsdf::Device device = clsdf::Device::automatic();
        const clsdf::cuda::SharedDevice gpu(device);  // the same device of CUDA
        const clsdf::Mesh mesh = clsdf::make_shape("sphere4");
        const std::size_t vertices = mesh.vertices().size();
        const Simulation simulation(gpu.ordinal(), vertices);

        // A grid around the largest body, and its field in shared memory.
        clsdf::Box box = mesh.box();
        for (double& x : box.lower) x *= 1.25;
        for (double& x : box.upper) x *= 1.25;
        const clsdf::Grid grid = clsdf::Grid::around(box, {.resolution = 64});
        const clsdf::Band band = clsdf::Band::symmetric(2 * grid.voxel());
        const std::size_t samples = grid.sample_count();
        const clsdf::cuda::SharedMemory field(gpu, samples * sizeof(float));

        // What is read and what is written, made once.
        clsdf::cuda::Arrays read(gpu, {{simulation.positions, vertices * sizeof(clsdf::Vec3), Access::read,
                                        simulation.stream, "the positions"}});
        clsdf::cuda::Arrays written(
            gpu, {{field.address(), samples * sizeof(float), Access::write, simulation.stream, "the field"}});

        clsdf::DistanceTransform transform(device, mesh);
        clsdf::Plan plan = transform.plan(grid, band);
        std::vector<double> volumes;
        for (int step = 0; step < 3; ++step) {
            simulation.move(mesh.vertices(), step);

            // New positions: these calls block.
            read.begin();
            transform.set_positions(read.input(0, ElementType::float64, vertices));
            read.end();
            plan.update(transform);

            // The field: a run that follows the stream, and that the stream follows.
            cl_event done = nullptr;
            plan.enqueue(nullptr, written.output(0), written.begin(nullptr), &done);
            written.end(done);
            clReleaseEvent(done);

            const std::vector<float> distance = simulation.read(field.address(), samples);
            record(distance);
            volumes.push_back(volume_of(distance, grid.spacing[0] * grid.spacing[1] * grid.spacing[2], band.outside));
        }
        bool right = true;
        for (std::size_t step = 0; step < volumes.size(); ++step) {
            const double scale = 1 + 0.1 * static_cast<double>(step);
            const double expected = volumes[0] * scale * scale * scale;
            std::printf("step %zu: volume %.6f, expected %.6f\n", step, volumes[step], expected);
            right = right && volumes[step] > 0.99 * expected && volumes[step] < 1.01 * expected;
        }
        std::puts(right ? "as it should be" : "WRONG");
        return right ? 0 : 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 2;
    }
}
