// Patches of a moving body, in the caller's own layout on the device, between the caller's own kernels on a queue that
// is out of order.
//
// All patches lie in one buffer, each with ghost samples, x slowest, as in a code with arrays phi[patch][x][y][z]. A
// Plan allocates everything once; update() prepares it for the next positions of the body. The kernel waits for the
// event of the patches, and the next patches wait for the event of the kernel, which reads them.

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <clsdf/clsdf.hpp>

#include "recorded.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace {

constexpr std::int64_t inner = 16, ghosts = 2, side = inner + 2 * ghosts;
constexpr std::size_t patch_samples = side * side * side;

void require(cl_int status, const char* call) {
    if (status == CL_SUCCESS) return;
    std::fprintf(stderr, "%s failed: OpenCL error %d\n", call, status);
    std::exit(2);
}

/// The solid part of a patch's cells without its ghosts: a smoothed Heaviside function of the distance, summed.
constexpr const char* integration = R"(
__kernel void solid_cells(__global const float* phi, float width, __global float* sums) {
    __global const float* patch = phi + get_global_id(0) * 20 * 20 * 20;
    float sum = 0;
    for (int x = 2; x < 18; ++x)
        for (int y = 2; y < 18; ++y)
            for (int z = 2; z < 18; ++z) {
                const float d = clamp(patch[(x * 20 + y) * 20 + z] / width, -1.0f, 1.0f);
                sum += 0.5f * (1.0f - d - sinpi(d) / M_PI_F);
            }
    sums[get_global_id(0)] = sum;
}
)";

/// The patches of a grid that cover it, with their places in the buffer.
std::vector<clsdf::Request> patches_of(const clsdf::Grid& grid, const clsdf::Band& band, cl_mem phi) {
    std::vector<clsdf::Request> requests;
    for (std::int64_t z = 0; z < grid.size[2]; z += inner)
        for (std::int64_t y = 0; y < grid.size[1]; y += inner)
            for (std::int64_t x = 0; x < grid.size[0]; x += inner) {
                clsdf::OutputArray target = phi;
                target.offset = requests.size() * patch_samples * sizeof(float);
                target.strides = {4 * side * side, 4 * side, 4};
                requests.push_back({grid.block({x, y, z}, {inner, inner, inner}).grown(ghosts), band, target});
            }
    return requests;
}

}  // namespace

int main() {
    try {
        const clsdf::Device device = clsdf::Device::automatic();
        cl_context context = device.context();
        cl_device_id id = nullptr;
        require(clGetContextInfo(context, CL_CONTEXT_DEVICES, sizeof id, &id, nullptr), "clGetContextInfo");
        cl_int status = CL_SUCCESS;
        cl_command_queue queue = clCreateCommandQueue(context, id, CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, &status);
        require(status, "clCreateCommandQueue");
        const char* text = integration;
        cl_program program = clCreateProgramWithSource(context, 1, &text, nullptr, &status);
        require(status, "clCreateProgramWithSource");
        require(clBuildProgram(program, 1, &id, "-cl-std=CL1.2", nullptr, nullptr), "clBuildProgram");
        cl_kernel kernel = clCreateKernel(program, "solid_cells", &status);
        require(status, "clCreateKernel");

        const clsdf::Mesh mesh = clsdf::make_shape("sphere5");
        clsdf::DistanceTransform transform(device, mesh);
        const clsdf::Grid grid = clsdf::Grid::around(mesh, 96, clsdf::Band::symmetric(0.2));
        const clsdf::Band band = clsdf::Band::symmetric(2 * grid.voxel());
        std::size_t patches = 1;
        for (const std::int64_t samples : grid.size) patches *= static_cast<std::size_t>((samples + inner - 1) / inner);
        cl_mem phi = clCreateBuffer(context, CL_MEM_READ_WRITE, patches * patch_samples * 4, nullptr, &status);
        require(status, "clCreateBuffer");
        cl_mem sums = clCreateBuffer(context, CL_MEM_READ_WRITE, patches * 4, nullptr, &status);
        require(status, "clCreateBuffer");
        const auto width = static_cast<float>(band.outside);
        require(clSetKernelArg(kernel, 0, sizeof phi, &phi), "clSetKernelArg");
        require(clSetKernelArg(kernel, 1, sizeof width, &width), "clSetKernelArg");
        require(clSetKernelArg(kernel, 2, sizeof sums, &sums), "clSetKernelArg");

        const std::vector<clsdf::Request> requests = patches_of(grid, band, phi);
        std::printf("%zu patches of %lld^3; the plan takes %.1f MB\n", requests.size(), static_cast<long long>(side),
                    1e-6 * static_cast<double>(transform.plan_bytes(requests)));
        clsdf::Plan plan = transform.plan(requests);  // may block and allocate

        const double radius = 0.5 * mesh.box().longest_side();
        const double of_the_ball = 4.0 / 3.0 * 3.14159265358979 * radius * radius * radius;
        bool right = true;
        cl_event read = nullptr;  // the kernel's last run
        for (int step = 0; step < 5; ++step) {
            const double angle = 0.3 * step, c = std::cos(angle), s = std::sin(angle);
            transform.set_motion({{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}}, {0.02 * step, 0.01 * step, 0});
            plan.update(transform);  // may block and allocate
            // Neither blocks nor allocates.
            cl_event computed = nullptr;
            plan.enqueue(queue, std::span<const cl_event>(&read, read == nullptr ? 0 : 1), &computed);
            if (read != nullptr) clReleaseEvent(read);
            require(clEnqueueNDRangeKernel(queue, kernel, 1, nullptr, &patches, nullptr, 1, &computed, &read),
                    "clEnqueueNDRangeKernel");
            clReleaseEvent(computed);

            std::vector<float> of_patches(patches);
            require(clEnqueueReadBuffer(queue, sums, CL_TRUE, 0, 4 * patches, of_patches.data(), 1, &read, nullptr),
                    "clEnqueueReadBuffer");
            record(of_patches);
            double volume = 0;
            for (const float sum : of_patches) volume += static_cast<double>(sum);
            volume *= grid.spacing[0] * grid.spacing[1] * grid.spacing[2];
            std::printf("step %d: volume %.6f; the ball's that the mesh approximates: %.6f\n", step, volume,
                        of_the_ball);
            // The mesh lies inside the ball: its volume is smaller by less than a hundredth.
            right = right && volume < of_the_ball && volume > 0.99 * of_the_ball;
        }
        std::puts(right ? "as it should be" : "WRONG");

        clReleaseEvent(read);
        clReleaseMemObject(sums);
        clReleaseMemObject(phi);
        clReleaseKernel(kernel);
        clReleaseProgram(program);
        clReleaseCommandQueue(queue);
        return right ? 0 : 1;
    } catch (const clsdf::Error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 2;
    }
}
