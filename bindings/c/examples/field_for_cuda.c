/* Computes the field of a moving body from device pointers of CUDA into a device pointer of CUDA.
 *
 * The positions and the field are memory of cudaMalloc() (here cuMemAlloc()), used on the program's stream: each step
 * moves the vertices, takes their positions and computes the field, all in the order of the stream. Memory of
 * cudaMalloc() is copied within the GPU; the field lies in memory that CUDA and OpenCL share, so that it is written in
 * place. clsdf opens CUDA's driver at run time. This program includes cuda.h and links libcuda, as a code that uses
 * CUDA does. */

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <cuda.h>

#include "example.h"

#include <string.h>

static void require(CUresult code, const char* call) {
    if (code == CUDA_SUCCESS) return;
    fprintf(stderr, "%s failed: CUDA error %d\n", call, (int)code);
    exit(2);
}

/* The step of the simulation: here new positions from the host; a code with kernels launches them on the stream. */
static void move(const double* rest, double* moved, int64_t vertices, int step) {
    int64_t n;
    for (n = 0; n < 3 * vertices; ++n) moved[n] = rest[n] * (1 + 0.1 * step);
}

/* The volume of a solid whose samples have these distances: a smoothed sum, `width` on both sides of the surface. */
static double volume_of(const float* distance, int64_t samples, double cell, double width) {
    double sum = 0;
    int64_t n;
    for (n = 0; n < samples; ++n) {
        const double x = distance[n] / width;
        sum += x <= -1 ? 1 : x >= 1 ? 0 : 0.5 * (1 - x);
    }
    return sum * cell;
}

int main(void) {
    enum { STEPS = 3 };
    clsdf_grid_options options = CLSDF_GRID_OPTIONS_INIT;
    clsdf_target target = {CLSDF_DISTANCE, 0, CLSDF_ARRAY_INIT};
    clsdf_targets targets = {&target, 1};
    clsdf_cuda_array mesh_memory, field_memory;
    clsdf_cuda_arrays *mesh_arrays, *field_arrays;
    clsdf_cuda_memory* shared;
    clsdf_cuda_device* gpu;
    clsdf_device* device;
    clsdf_mesh* mesh;
    clsdf_transform* transform;
    clsdf_plan* plan;
    clsdf_array positions;
    clsdf_grid grid;
    clsdf_band band;
    clsdf_box box;
    CUcontext context;
    CUstream stream;
    CUdeviceptr vertices;
    const double* rest;
    double *moved, voxel, cell, found, expected, volumes[STEPS];
    float* distance;
    int64_t vertex_count, samples, axis;
    uint64_t field;
    int32_t ordinal;
    void *event, *done;
    int step, right = 1;

    /* The device of clsdf, and the same one of CUDA. */
    check(clsdf_device_automatic(&device));
    check(clsdf_cuda_device_create(device, &gpu));
    check(clsdf_cuda_device_ordinal(gpu, &ordinal));

    /* The simulation's context, stream and memory. */
    require(cuInit(0), "cuInit");
    require(cuDevicePrimaryCtxRetain(&context, ordinal), "cuDevicePrimaryCtxRetain");
    require(cuCtxPushCurrent(context), "cuCtxPushCurrent");
    require(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING), "cuStreamCreate");
    check(clsdf_mesh_shape("sphere4", &mesh));
    check(clsdf_mesh_vertices(mesh, &rest, &vertex_count));
    require(cuMemAlloc(&vertices, (size_t)vertex_count * 24), "cuMemAlloc");

    /* A grid around the largest body, and its field in shared memory. */
    check(clsdf_mesh_box(mesh, &box));
    for (axis = 0; axis < 3; ++axis) box.lower[axis] *= 1.25, box.upper[axis] *= 1.25;
    options.resolution = 64;
    check(clsdf_grid_around_box(&box, &options, &grid));
    check(clsdf_grid_voxel(&grid, &voxel));
    check(clsdf_grid_sample_count(&grid, &samples));
    band = clsdf_band_symmetric(2 * voxel);
    cell = grid.spacing[0] * grid.spacing[1] * grid.spacing[2];
    check(clsdf_cuda_memory_create(gpu, samples * (int64_t)sizeof(float), &shared));
    check(clsdf_cuda_memory_place(shared, &field, NULL, NULL));

    /* What is read and what is written, made once. */
    memset(&mesh_memory, 0, sizeof mesh_memory);
    mesh_memory.address = vertices;
    mesh_memory.bytes = vertex_count * 24;
    mesh_memory.stream = stream;
    mesh_memory.name = "the positions";
    mesh_memory.access = CLSDF_CUDA_READ;
    field_memory = mesh_memory;
    field_memory.address = field;
    field_memory.bytes = samples * (int64_t)sizeof(float);
    field_memory.name = "the field";
    field_memory.access = CLSDF_CUDA_WRITE;
    check(clsdf_cuda_arrays_create(gpu, &mesh_memory, 1, &mesh_arrays));
    check(clsdf_cuda_arrays_create(gpu, &field_memory, 1, &field_arrays));
    check(clsdf_cuda_arrays_get(mesh_arrays, 0, CLSDF_FLOAT64, vertex_count, &positions));
    check(clsdf_cuda_arrays_get(field_arrays, 0, CLSDF_FLOAT32, samples, &target.array));

    check(clsdf_transform_create(device, mesh, NULL, NULL, &transform));
    check(clsdf_plan_create(transform, &grid, &band, CLSDF_SET(CLSDF_DISTANCE), NULL, &plan));
    moved = allocate((size_t)vertex_count * 24);
    distance = allocate((size_t)samples * sizeof(float));
    for (step = 0; step < STEPS; ++step) {
        move(rest, moved, vertex_count, step);
        require(cuMemcpyHtoDAsync(vertices, moved, (size_t)vertex_count * 24, stream), "cuMemcpyHtoDAsync");

        /* New positions: these calls block. */
        check(clsdf_cuda_arrays_begin(mesh_arrays));
        check(clsdf_transform_set_positions(transform, &positions, NULL));
        check(clsdf_cuda_arrays_end(mesh_arrays));
        check(clsdf_plan_update(plan, transform, NULL));

        /* The field: a run that follows the stream, and that the stream follows. */
        check(clsdf_cuda_arrays_begin_run(field_arrays, NULL, NULL, 0, &event));
        check(clsdf_plan_enqueue_to(plan, NULL, &targets, 1, &event, 1, &done));
        check(clsdf_cuda_arrays_end_run(field_arrays, done));
        clReleaseEvent((cl_event)done);

        /* The simulation's own use of the field, later on the stream. */
        require(cuMemcpyDtoHAsync(distance, field, (size_t)samples * sizeof(float), stream), "cuMemcpyDtoHAsync");
        require(cuStreamSynchronize(stream), "cuStreamSynchronize");
        record(distance, (size_t)samples * sizeof(float));
        volumes[step] = volume_of(distance, samples, cell, band.outside);
    }
    for (step = 0; step < STEPS; ++step) {
        const double scale = 1 + 0.1 * step;
        found = volumes[step];
        expected = volumes[0] * scale * scale * scale;
        printf("step %d: volume %.6f, expected %.6f\n", step, found, expected);
        right = right && found > 0.99 * expected && found < 1.01 * expected;
    }
    puts(right ? "as it should be" : "WRONG");

    clsdf_plan_release(plan);
    clsdf_transform_release(transform);
    clsdf_cuda_arrays_release(field_arrays);
    clsdf_cuda_arrays_release(mesh_arrays);
    clsdf_cuda_memory_release(shared);
    clsdf_mesh_release(mesh);
    clsdf_cuda_device_release(gpu);
    clsdf_device_release(device);
    free(distance);
    free(moved);
    require(cuMemFree(vertices), "cuMemFree");
    require(cuStreamDestroy(stream), "cuStreamDestroy");
    require(cuCtxPopCurrent(NULL), "cuCtxPopCurrent");
    require(cuDevicePrimaryCtxRelease(ordinal), "cuDevicePrimaryCtxRelease");
    return right ? 0 : 1;
}
