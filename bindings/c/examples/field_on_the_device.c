/* Computes a field in the caller's own OpenCL context, queue and memory, for the caller's own kernels.
 *
 * A plan allocates everything once. Then clsdf_plan_enqueue_to() puts the computation of the field into the caller's
 * queue, between the caller's own commands. It neither blocks nor copies. Here a kernel integrates the volume of a
 * solid over the field. Only eight bytes return to the host. */

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include "example.h"

static void require(cl_int status, const char* call) {
    if (status == CL_SUCCESS) return;
    fprintf(stderr, "%s failed: OpenCL error %d\n", call, status);
    exit(2);
}

/* The solid share of a cell is a smoothed Heaviside function of the distance, `width` on both sides of the surface. The
 * kernels sum it over each row of samples, then over all rows. */
static const char* integration =
    "#pragma OPENCL EXTENSION cl_khr_fp64 : enable\n"
    "float solid_share(float distance, float width) {\n"
    "    const float x = clamp(distance / width, -1.0f, 1.0f);\n"
    "    return 0.5f * (1.0f - x - sinpi(x) / M_PI_F);\n"
    "}\n"
    "__kernel void sum_rows(__global const float* distance, int row_length, float width, __global float* sums) {\n"
    "    const size_t row = get_global_id(0);\n"
    "    float sum = 0;\n"
    "    for (int x = 0; x < row_length; ++x) sum += solid_share(distance[row * row_length + x], width);\n"
    "    sums[row] = sum;\n"
    "}\n"
    "__kernel void sum_all(__global const float* sums, int rows, double cell, __global double* volume) {\n"
    "    double sum = 0;\n"
    "    for (int row = 0; row < rows; ++row) sum += sums[row];\n"
    "    *volume = sum * cell;\n"
    "}\n";

static cl_mem buffer_of(cl_context context, size_t bytes) {
    cl_int status = CL_SUCCESS;
    cl_mem memory = clCreateBuffer(context, CL_MEM_READ_WRITE, bytes, NULL, &status);
    require(status, "clCreateBuffer");
    return memory;
}

static cl_kernel kernel_of(cl_program program, const char* name) {
    cl_int status = CL_SUCCESS;
    cl_kernel kernel = clCreateKernel(program, name, &status);
    require(status, "clCreateKernel");
    return kernel;
}

int main(void) {
    cl_int status = CL_SUCCESS;
    cl_platform_id platform;
    cl_device_id id;
    cl_context context;
    cl_command_queue queue;
    cl_program program;
    cl_kernel sum_rows, sum_all;
    cl_mem distance, sums, volume;
    cl_int row_length, rows;
    size_t row_count, one = 1;

    clsdf_grid_options options = CLSDF_GRID_OPTIONS_INIT;
    clsdf_device* device;
    clsdf_mesh* mesh;
    clsdf_transform* transform;
    clsdf_plan* plan;
    clsdf_grid grid;
    clsdf_band band;
    clsdf_box box;
    clsdf_target target;
    clsdf_targets targets;
    int64_t samples;
    double voxel, cell, side, radius, ball, result = 0;
    float width;
    int right;

    /* The objects of the simulation. */
    require(clGetPlatformIDs(1, &platform, NULL), "clGetPlatformIDs");
    require(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, &id, NULL), "clGetDeviceIDs");
    context = clCreateContext(NULL, 1, &id, NULL, NULL, &status);
    require(status, "clCreateContext");
    queue = clCreateCommandQueue(context, id, 0, &status);
    require(status, "clCreateCommandQueue");
    program = clCreateProgramWithSource(context, 1, &integration, NULL, &status);
    require(status, "clCreateProgramWithSource");
    require(clBuildProgram(program, 1, &id, "-cl-std=CL1.2", NULL, NULL), "clBuildProgram");
    sum_rows = kernel_of(program, "sum_rows");
    sum_all = kernel_of(program, "sum_all");

    check(clsdf_device_from_handles(context, id, queue, &device));
    check(clsdf_mesh_shape("sphere5", &mesh));
    check(clsdf_transform_create(device, mesh, NULL, NULL, &transform));
    /* The integral needs only two samples on each side of the surface. */
    check(clsdf_mesh_box(mesh, &box));
    options.resolution = 128;
    options.margin.value = 2;
    options.margin.unit = CLSDF_VOXELS;
    check(clsdf_grid_around_box(&box, &options, &grid));
    check(clsdf_grid_voxel(&grid, &voxel));
    check(clsdf_grid_sample_count(&grid, &samples));
    band = clsdf_band_symmetric(2 * voxel);
    row_length = (cl_int)grid.size[0];
    rows = (cl_int)(grid.size[1] * grid.size[2]);
    distance = buffer_of(context, (size_t)samples * sizeof(float));
    sums = buffer_of(context, (size_t)rows * sizeof(float));
    volume = buffer_of(context, sizeof(double));

    /* This call may block and allocate: polyhedra, lists, the sign. The next ones do neither. */
    check(clsdf_plan_create(transform, &grid, &band, CLSDF_SET(CLSDF_DISTANCE), NULL, &plan));

    /* This queue is in order, so the kernels run after the field. Another queue would have to wait for the event that
     * the call can give. */
    target = clsdf_buffer_target(CLSDF_DISTANCE, CLSDF_FLOAT32, distance);
    targets.items = &target;
    targets.count = 1;
    check(clsdf_plan_enqueue_to(plan, queue, &targets, 1, NULL, 0, NULL));
    width = (float)band.outside;
    cell = grid.spacing[0] * grid.spacing[1] * grid.spacing[2];
    row_count = (size_t)rows;
    require(clSetKernelArg(sum_rows, 0, sizeof distance, &distance), "clSetKernelArg");
    require(clSetKernelArg(sum_rows, 1, sizeof row_length, &row_length), "clSetKernelArg");
    require(clSetKernelArg(sum_rows, 2, sizeof width, &width), "clSetKernelArg");
    require(clSetKernelArg(sum_rows, 3, sizeof sums, &sums), "clSetKernelArg");
    require(clEnqueueNDRangeKernel(queue, sum_rows, 1, NULL, &row_count, NULL, 0, NULL, NULL),
            "clEnqueueNDRangeKernel");
    require(clSetKernelArg(sum_all, 0, sizeof sums, &sums), "clSetKernelArg");
    require(clSetKernelArg(sum_all, 1, sizeof rows, &rows), "clSetKernelArg");
    require(clSetKernelArg(sum_all, 2, sizeof cell, &cell), "clSetKernelArg");
    require(clSetKernelArg(sum_all, 3, sizeof volume, &volume), "clSetKernelArg");
    require(clEnqueueNDRangeKernel(queue, sum_all, 1, NULL, &one, NULL, 0, NULL, NULL), "clEnqueueNDRangeKernel");
    require(clEnqueueReadBuffer(queue, volume, CL_TRUE, 0, sizeof result, &result, 0, NULL, NULL),
            "clEnqueueReadBuffer");
    record(&result, sizeof result);

    check(clsdf_box_longest_side(&box, &side));
    radius = 0.5 * side;
    ball = 4.0 / 3.0 * 3.14159265358979 * radius * radius * radius;
    printf("volume: %.6f; the ball's that the mesh approximates: %.6f\n", result, ball);
    /* The mesh lies inside the ball. Its volume is smaller by less than a hundredth. */
    right = result < ball && result > 0.99 * ball;
    puts(right ? "as it should be" : "WRONG");

    clsdf_plan_release(plan);
    clsdf_transform_release(transform);
    clsdf_mesh_release(mesh);
    clsdf_device_release(device);
    clReleaseMemObject(volume);
    clReleaseMemObject(sums);
    clReleaseMemObject(distance);
    clReleaseKernel(sum_all);
    clReleaseKernel(sum_rows);
    clReleaseProgram(program);
    clReleaseCommandQueue(queue);
    clReleaseContext(context);
    return right ? 0 : 1;
}
