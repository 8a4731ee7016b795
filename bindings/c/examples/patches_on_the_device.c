/* Patches of a moving body, in the caller's own layout on the device, between the caller's own kernels on a queue that
 * is out of order.
 *
 * All patches lie in one buffer, each with ghost samples, x slowest, as in a code with arrays phi[patch][x][y][z]. A
 * plan allocates everything once; clsdf_plan_update() prepares it for the next positions of the body. The kernel waits
 * for the event of the patches, and the next patches wait for the event of the kernel, which reads them. */

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include "example.h"

#include <math.h>

enum { INNER = 16, GHOSTS = 2, SIDE = INNER + 2 * GHOSTS, SAMPLES = SIDE * SIDE * SIDE };

static void require(cl_int status, const char* call) {
    if (status == CL_SUCCESS) return;
    fprintf(stderr, "%s failed: OpenCL error %d\n", call, status);
    exit(2);
}

/* The solid part of a patch's cells without its ghosts: a smoothed Heaviside function of the distance, summed. */
static const char* integration =
    "__kernel void solid_cells(__global const float* phi, float width, __global float* sums) {\n"
    "    __global const float* patch = phi + get_global_id(0) * 20 * 20 * 20;\n"
    "    float sum = 0;\n"
    "    for (int x = 2; x < 18; ++x)\n"
    "        for (int y = 2; y < 18; ++y)\n"
    "            for (int z = 2; z < 18; ++z) {\n"
    "                const float d = clamp(patch[(x * 20 + y) * 20 + z] / width, -1.0f, 1.0f);\n"
    "                sum += 0.5f * (1.0f - d - sinpi(d) / M_PI_F);\n"
    "            }\n"
    "    sums[get_global_id(0)] = sum;\n"
    "}\n";

/* The patches that cover the grid are equal blocks of one lattice: returns their number. */
static int64_t find_blocks(const clsdf_grid* grid, int64_t (*first)[3]) {
    int64_t x, y, z, count = 0;
    for (z = 0; z < grid->size[2]; z += INNER)
        for (y = 0; y < grid->size[1]; y += INNER)
            for (x = 0; x < grid->size[0]; x += INNER, ++count) {
                if (first == NULL) continue;
                first[count][0] = x - GHOSTS;
                first[count][1] = y - GHOSTS;
                first[count][2] = z - GHOSTS;
            }
    return count;
}

int main(void) {
    const clsdf_band around = clsdf_band_symmetric(0.2);
    clsdf_block_set blocks = CLSDF_BLOCK_SET_INIT;
    clsdf_device* device;
    clsdf_mesh* mesh;
    clsdf_transform* transform;
    clsdf_plan* plan;
    clsdf_grid grid;
    clsdf_box box;
    clsdf_target target;
    int64_t(*first)[3];
    int64_t bytes, n;
    double voxel, side, radius, ball;
    void* handles[3];

    cl_int status = CL_SUCCESS;
    cl_context context;
    cl_device_id id;
    cl_command_queue queue;
    cl_program program;
    cl_kernel kernel;
    cl_mem phi, sums;
    cl_event read = NULL; /* the kernel's last run */
    float width, *of_patches;
    size_t patches;
    int step, right = 1;

    check(clsdf_device_automatic(&device));
    check(clsdf_device_handles(device, &handles[0], &handles[1], &handles[2]));
    context = handles[0];
    id = handles[1];
    queue = clCreateCommandQueue(context, id, CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE, &status);
    require(status, "clCreateCommandQueue");
    program = clCreateProgramWithSource(context, 1, &integration, NULL, &status);
    require(status, "clCreateProgramWithSource");
    require(clBuildProgram(program, 1, &id, "-cl-std=CL1.2", NULL, NULL), "clBuildProgram");
    kernel = clCreateKernel(program, "solid_cells", &status);
    require(status, "clCreateKernel");

    check(clsdf_mesh_shape("sphere5", &mesh));
    check(clsdf_transform_create(device, mesh, NULL, NULL, &transform));
    check(clsdf_grid_around_mesh(mesh, 96, &around, &grid));
    check(clsdf_grid_voxel(&grid, &voxel));
    patches = (size_t)find_blocks(&grid, NULL);
    first = allocate(patches * sizeof *first);
    find_blocks(&grid, first);
    phi = clCreateBuffer(context, CL_MEM_READ_WRITE, patches * SAMPLES * sizeof(float), NULL, &status);
    require(status, "clCreateBuffer");
    sums = clCreateBuffer(context, CL_MEM_READ_WRITE, patches * sizeof(float), NULL, &status);
    require(status, "clCreateBuffer");

    target = clsdf_buffer_target(CLSDF_DISTANCE, CLSDF_FLOAT32, phi);
    target.array.strides[0] = 4 * SIDE * SIDE;
    target.array.strides[1] = 4 * SIDE;
    target.array.strides[2] = 4;
    target.array.block_stride = 4 * SAMPLES;
    blocks.lattice = grid;
    blocks.band = clsdf_band_symmetric(2 * voxel);
    for (n = 0; n < 3; ++n) blocks.size[n] = SIDE;
    blocks.first = first[0];
    blocks.block_count = (int64_t)patches;
    blocks.targets.items = &target;
    blocks.targets.count = 1;
    check(clsdf_plan_bytes_blocks(transform, &blocks, NULL, &bytes));
    printf("%ld patches of %d^3; the plan takes %.1f MB\n", (long)patches, SIDE, 1e-6 * (double)bytes);
    check(clsdf_plan_create_blocks(transform, &blocks, NULL, &plan)); /* may block and allocate */

    width = (float)blocks.band.outside;
    require(clSetKernelArg(kernel, 0, sizeof phi, &phi), "clSetKernelArg");
    require(clSetKernelArg(kernel, 1, sizeof width, &width), "clSetKernelArg");
    require(clSetKernelArg(kernel, 2, sizeof sums, &sums), "clSetKernelArg");
    of_patches = allocate(patches * sizeof *of_patches);
    check(clsdf_mesh_box(mesh, &box));
    check(clsdf_box_longest_side(&box, &side));
    radius = 0.5 * side;
    ball = 4.0 / 3.0 * 3.14159265358979 * radius * radius * radius;
    for (step = 0; step < 5; ++step) {
        const double angle = 0.3 * step, c = cos(angle), s = sin(angle);
        const double rotation[9] = {c, -s, 0, s, c, 0, 0, 0, 1};
        double translation[3] = {0, 0, 0}, volume = 0;
        void *after = read, *done;
        cl_event computed;
        translation[0] = 0.02 * step;
        translation[1] = 0.01 * step;
        check(clsdf_transform_set_motion(transform, rotation, translation));
        check(clsdf_plan_update(plan, transform, NULL)); /* may block and allocate */
        /* Neither blocks nor allocates. */
        check(clsdf_plan_enqueue(plan, queue, &after, read == NULL ? 0 : 1, &done));
        computed = done;
        if (read != NULL) clReleaseEvent(read);
        require(clEnqueueNDRangeKernel(queue, kernel, 1, NULL, &patches, NULL, 1, &computed, &read),
                "clEnqueueNDRangeKernel");
        clReleaseEvent(computed);

        require(clEnqueueReadBuffer(queue, sums, CL_TRUE, 0, patches * sizeof *of_patches, of_patches, 1, &read, NULL),
                "clEnqueueReadBuffer");
        record(of_patches, patches * sizeof *of_patches);
        for (n = 0; n < (int64_t)patches; ++n) volume += of_patches[n];
        volume *= grid.spacing[0] * grid.spacing[1] * grid.spacing[2];
        printf("step %d: volume %.6f; the ball's that the mesh approximates: %.6f\n", step, volume, ball);
        /* The mesh lies inside the ball: its volume is smaller by less than a hundredth. */
        right = right && volume < ball && volume > 0.99 * ball;
    }
    puts(right ? "as it should be" : "WRONG");

    clsdf_plan_release(plan);
    clsdf_transform_release(transform);
    clsdf_mesh_release(mesh);
    free(of_patches);
    free(first);
    clReleaseEvent(read);
    clReleaseMemObject(sums);
    clReleaseMemObject(phi);
    clReleaseKernel(kernel);
    clReleaseProgram(program);
    clReleaseCommandQueue(queue);
    clsdf_device_release(device);
    return right ? 0 : 1;
}
