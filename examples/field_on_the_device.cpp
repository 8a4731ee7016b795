// Computes a field in the caller's own OpenCL context, queue and memory, for the caller's own kernels.
//
// A plan allocates everything once. Then Plan::enqueue() puts the computation of the field into the caller's queue,
// between the caller's own commands. It neither blocks nor copies. Here a kernel integrates the volume of a solid over
// the field. Only eight bytes return to the host.

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <clsdf/clsdf.hpp>

#include "recorded.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace {

void require(cl_int status, const char* call) {
    if (status == CL_SUCCESS) return;
    std::fprintf(stderr, "%s failed: OpenCL error %d\n", call, status);
    std::exit(2);
}

/// The solid share of a cell is a smoothed Heaviside function of the distance, `width` on both sides of the surface.
/// The kernels sum it over each row of samples, then over all rows.
constexpr const char* integration = R"(
#pragma OPENCL EXTENSION cl_khr_fp64 : enable

float solid_share(float distance, float width) {
    const float x = clamp(distance / width, -1.0f, 1.0f);
    return 0.5f * (1.0f - x - sinpi(x) / M_PI_F);
}

__kernel void sum_rows(__global const float* distance, int row_length, float width, __global float* sums) {
    const size_t row = get_global_id(0);
    float sum = 0;
    for (int x = 0; x < row_length; ++x) sum += solid_share(distance[row * row_length + x], width);
    sums[row] = sum;
}

__kernel void sum_all(__global const float* sums, int rows, double cell, __global double* volume) {
    double sum = 0;
    for (int row = 0; row < rows; ++row) sum += sums[row];
    *volume = sum * cell;
}
)";

/// The objects of the simulation.
struct Simulation {
    cl_device_id device = nullptr;
    cl_context context = nullptr;
    cl_command_queue queue = nullptr;
    cl_program program = nullptr;

    Simulation() {
        cl_int status = CL_SUCCESS;
        cl_platform_id platform = nullptr;
        require(clGetPlatformIDs(1, &platform, nullptr), "clGetPlatformIDs");
        require(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, &device, nullptr), "clGetDeviceIDs");
        context = clCreateContext(nullptr, 1, &device, nullptr, nullptr, &status);
        require(status, "clCreateContext");
        queue = clCreateCommandQueue(context, device, 0, &status);
        require(status, "clCreateCommandQueue");
        const char* text = integration;
        program = clCreateProgramWithSource(context, 1, &text, nullptr, &status);
        require(status, "clCreateProgramWithSource");
        require(clBuildProgram(program, 1, &device, "-cl-std=CL1.2", nullptr, nullptr), "clBuildProgram");
    }
    Simulation(const Simulation&) = delete;
    Simulation& operator=(const Simulation&) = delete;
    ~Simulation() {
        clReleaseProgram(program);
        clReleaseCommandQueue(queue);
        clReleaseContext(context);
    }

    cl_mem buffer(std::size_t bytes) const {
        cl_int status = CL_SUCCESS;
        cl_mem memory = clCreateBuffer(context, CL_MEM_READ_WRITE, bytes, nullptr, &status);
        require(status, "clCreateBuffer");
        return memory;
    }

    template <class... Arguments>
    void enqueue(const char* kernel_name, std::size_t items, const Arguments&... arguments) const {
        cl_int status = CL_SUCCESS;
        cl_kernel kernel = clCreateKernel(program, kernel_name, &status);
        require(status, "clCreateKernel");
        cl_uint index = 0;
        (require(clSetKernelArg(kernel, index++, sizeof arguments, &arguments), "clSetKernelArg"), ...);
        require(clEnqueueNDRangeKernel(queue, kernel, 1, nullptr, &items, nullptr, 0, nullptr, nullptr),
                "clEnqueueNDRangeKernel");
        clReleaseKernel(kernel);
    }
};

double volume_on_the_device(const Simulation& simulation, const clsdf::DistanceTransform& transform,
                            const clsdf::Grid& grid, const clsdf::Band& band) {
    const auto row_length = static_cast<cl_int>(grid.size[0]);
    const auto rows = static_cast<cl_int>(grid.size[1] * grid.size[2]);
    cl_mem distance = simulation.buffer(grid.sample_count() * sizeof(float));
    cl_mem sums = simulation.buffer(static_cast<std::size_t>(rows) * sizeof(float));
    cl_mem volume = simulation.buffer(sizeof(double));

    // plan() may block and allocate: polyhedra, lists, the sign. The next calls do neither.
    clsdf::Plan plan = transform.plan(grid, band);

    // This queue is in order, so the kernels run after the field. Another queue would have to wait for the event that
    // enqueue() can give.
    plan.enqueue(simulation.queue, distance);
    const auto width = static_cast<float>(band.outside);
    const double cell = grid.spacing[0] * grid.spacing[1] * grid.spacing[2];
    simulation.enqueue("sum_rows", static_cast<std::size_t>(rows), distance, row_length, width, sums);
    simulation.enqueue("sum_all", 1, sums, rows, cell, volume);

    double result = 0;
    require(clEnqueueReadBuffer(simulation.queue, volume, CL_TRUE, 0, sizeof result, &result, 0, nullptr, nullptr),
            "clEnqueueReadBuffer");
    for (cl_mem memory : {volume, sums, distance}) clReleaseMemObject(memory);
    return result;
}

}  // namespace

int main() {
    try {
        const Simulation simulation;
        const auto device = clsdf::Device::from_handles(simulation.context, simulation.device, simulation.queue);

        const clsdf::Mesh mesh = clsdf::make_shape("sphere5");
        const clsdf::DistanceTransform transform(device, mesh);
        // The integral needs only two samples on each side of the surface.
        const clsdf::Grid grid =
            clsdf::Grid::around(mesh.box(), {.resolution = 128, .margin = clsdf::Length::in_voxels(2)});
        const clsdf::Band band = clsdf::Band::symmetric(2 * grid.voxel());

        const double volume = volume_on_the_device(simulation, transform, grid, band);
        record(std::array{volume});
        const double radius = 0.5 * mesh.box().longest_side();
        const double of_the_ball = 4.0 / 3.0 * 3.14159265358979 * radius * radius * radius;
        std::printf("volume on %s: %.6f; the ball's that the mesh approximates: %.6f\n", device.name().c_str(), volume,
                    of_the_ball);

        // The mesh lies inside the ball. Its volume is smaller by less than a hundredth.
        const bool right = volume < of_the_ball && volume > 0.99 * of_the_ball;
        std::puts(right ? "as it should be" : "WRONG");
        return right ? 0 : 1;
    } catch (const clsdf::Error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 2;
    }
}
