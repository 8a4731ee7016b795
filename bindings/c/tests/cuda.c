/* Memory of CUDA: inputs, outputs and runs of plans, on the stand-in for CUDA's driver. */
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <cuda.h>

#include "test.h"

enum { N = 16, SAMPLES = N * N * N, POINTS = 300 };

#define DONE(call) CHECK((call) == CUDA_SUCCESS)

/* Memory of cudaMalloc(), with these bytes if they are given. */
static CUdeviceptr cuda_memory(const void* content, size_t bytes) {
    CUdeviceptr address = 0;
    DONE(cuMemAlloc(&address, bytes));
    if (content != NULL) DONE(cuMemcpyHtoDAsync(address, content, bytes, NULL));
    return address;
}

static clsdf_cuda_array used(uint64_t address, size_t bytes, int32_t access, void* stream) {
    clsdf_cuda_array array;
    memset(&array, 0, sizeof array);
    array.address = address;
    array.bytes = (int64_t)bytes;
    array.access = access;
    array.stream = stream;
    return array;
}

static void check_copy(CUdeviceptr address, const float* expected, size_t count, CUstream stream) {
    float* values = allocate(count * sizeof *values);
    DONE(cuMemcpyDtoHAsync(values, address, count * sizeof *values, stream));
    CHECK(memcmp(values, expected, count * sizeof *values) == 0);
    free(values);
}

static int32_t end_call(void* user) {
    (void)user;
    return CLSDF_CANCELLED;
}

/* Vertices, triangles and a field in memory of CUDA. */
static void check_calls(const clsdf_device* device, const clsdf_cuda_device* gpu, const clsdf_mesh* mesh,
                        const clsdf_grid* grid, const float* expected) {
    const clsdf_band band = clsdf_band_full();
    const double* vertices;
    const uint32_t* triangles;
    int64_t vertex_count, triangle_count, bytes, kept;
    clsdf_cuda_array all[3];
    clsdf_mesh_arrays mesh_arrays = CLSDF_MESH_ARRAYS_INIT;
    clsdf_call_options call = CLSDF_CALL_OPTIONS_INIT;
    clsdf_target target = {CLSDF_DISTANCE, 0, CLSDF_ARRAY_INIT};
    clsdf_transform* transform;
    clsdf_cuda_arrays* arrays;
    clsdf_cuda_memory* memory;
    CUdeviceptr positions, faces, phi;
    uint64_t address;
    void* buffer;
    OK(clsdf_mesh_vertices(mesh, &vertices, &vertex_count));
    OK(clsdf_mesh_triangles(mesh, &triangles, &triangle_count));
    positions = cuda_memory(vertices, (size_t)vertex_count * 24);
    faces = cuda_memory(triangles, (size_t)triangle_count * 12);
    phi = cuda_memory(NULL, SAMPLES * sizeof(float));
    all[0] = used(positions, (size_t)vertex_count * 24, CLSDF_CUDA_READ, NULL);
    all[1] = used(faces, (size_t)triangle_count * 12, CLSDF_CUDA_READ, NULL);
    all[2] = used(phi, SAMPLES * sizeof(float), CLSDF_CUDA_WRITE, NULL);
    OK(clsdf_cuda_arrays_create(gpu, all, 3, &arrays));
    clsdf_cuda_arrays_retain(arrays);
    clsdf_cuda_arrays_release(arrays);
    OK(clsdf_cuda_arrays_get(arrays, 0, CLSDF_FLOAT64, vertex_count, &mesh_arrays.vertices));
    OK(clsdf_cuda_arrays_get(arrays, 1, CLSDF_UINT32, triangle_count, &mesh_arrays.triangles));
    OK(clsdf_cuda_arrays_get(arrays, 2, CLSDF_FLOAT32, SAMPLES, &target.array));
    OK(clsdf_cuda_arrays_begin(arrays));
    OK(clsdf_transform_from_arrays(device, &mesh_arrays, NULL, NULL, &transform));
    OK(clsdf_compute(transform, grid, &band, &target, 1, NULL, NULL));
    OK(clsdf_cuda_arrays_end(arrays));
    check_copy(phi, expected, SAMPLES, NULL);

    /* A call that fails between begin and end. */
    OK(clsdf_cuda_arrays_begin(arrays));
    FAILS(CLSDF_INVALID_ARGUMENT, "before the end()", clsdf_cuda_arrays_begin(arrays));
    call.should_stop = end_call;
    CHECK(clsdf_compute(transform, grid, &band, &target, 1, &call, NULL) == CLSDF_CANCELLED);
    OK(clsdf_cuda_arrays_abandon(arrays));
    FAILS(CLSDF_INVALID_ARGUMENT, "without its begin()", clsdf_cuda_arrays_end(arrays));
    OK(clsdf_cuda_arrays_begin(arrays));
    OK(clsdf_compute(transform, grid, &band, &target, 1, NULL, NULL));
    OK(clsdf_cuda_arrays_end(arrays));
    check_copy(phi, expected, SAMPLES, NULL);
    clsdf_cuda_arrays_release(arrays);
    OK(clsdf_cuda_device_release_memory(gpu, &kept));
    CHECK(kept >= (int64_t)(SAMPLES * sizeof(float)));
    OK(clsdf_cuda_device_release_memory(gpu, NULL));

    /* Memory that both have. */
    OK(clsdf_cuda_memory_create(gpu, 2 * SAMPLES * sizeof(float), &memory));
    OK(clsdf_cuda_memory_place(memory, &address, &bytes, &buffer));
    OK(clsdf_cuda_memory_place(memory, NULL, NULL, NULL));
    CHECK(bytes >= (int64_t)(2 * SAMPLES * sizeof(float)));
    all[0] = used(address + SAMPLES * sizeof(float), SAMPLES * sizeof(float), CLSDF_CUDA_WRITE, NULL);
    OK(clsdf_cuda_arrays_create(gpu, all, 1, &arrays));
    clsdf_cuda_memory_retain(memory);
    clsdf_cuda_memory_release(memory);
    clsdf_cuda_memory_release(memory); /* the arrays keep it */
    OK(clsdf_cuda_arrays_get(arrays, 0, CLSDF_FLOAT32, SAMPLES, &target.array));
    CHECK(target.array.device == buffer && target.array.offset == (int64_t)(SAMPLES * sizeof(float)));
    OK(clsdf_cuda_arrays_begin(arrays));
    OK(clsdf_compute(transform, grid, &band, &target, 1, NULL, NULL));
    OK(clsdf_cuda_arrays_end(arrays));
    check_copy(all[0].address, expected, SAMPLES, NULL);
    clsdf_cuda_arrays_release(arrays);
    clsdf_transform_release(transform);
    DONE(cuMemFree(positions));
    DONE(cuMemFree(faces));
    DONE(cuMemFree(phi));
}

/* Runs of a plan of points, between the work of two streams. */
static void check_runs(const clsdf_cuda_device* gpu, const clsdf_transform* transform) {
    double points[POINTS][3];
    float expected[POINTS];
    clsdf_cuda_array all[2];
    clsdf_array at;
    clsdf_target target = {CLSDF_DISTANCE, 0, CLSDF_ARRAY_INIT}, on_host = float_target(expected, POINTS);
    clsdf_cuda_arrays* arrays;
    clsdf_point_plan* plan;
    CUdeviceptr asked, phi;
    CUstream streams[2];
    void *followed[1], *event, *done;
    int n;
    for (n = 0; n < POINTS; ++n) points[n][0] = 0.002 * n - 0.3, points[n][1] = 0.001 * n, points[n][2] = 0.1;
    at = clsdf_host_array(CLSDF_FLOAT64, points, POINTS);
    OK(clsdf_query(transform, &at, HUGE_VAL, &on_host, 1, NULL, NULL));
    for (n = 0; n < 2; ++n) DONE(cuStreamCreate(&streams[n], CU_STREAM_NON_BLOCKING));
    asked = cuda_memory(NULL, sizeof points);
    phi = cuda_memory(NULL, sizeof expected);
    all[0] = used(asked, sizeof points, CLSDF_CUDA_READ, streams[0]);
    all[1] = used(phi, sizeof expected, CLSDF_CUDA_WRITE, streams[1]);
    OK(clsdf_cuda_arrays_create(gpu, all, 2, &arrays));
    OK(clsdf_cuda_arrays_get(arrays, 0, CLSDF_FLOAT64, POINTS, &at));
    OK(clsdf_cuda_arrays_get(arrays, 1, CLSDF_FLOAT32, POINTS, &target.array));
    OK(clsdf_point_plan_create(transform, POINTS, HUGE_VAL, 0, NULL, &plan));
    for (n = 0; n < 3; ++n) {
        float zeros[POINTS];
        memset(zeros, 0, sizeof zeros);
        DONE(cuMemcpyHtoDAsync(phi, zeros, sizeof zeros, streams[1]));
        DONE(cuMemcpyHtoDAsync(asked, points, sizeof points, streams[0]));
        if (n == 2) { /* one stream for both */
            DONE(cuStreamSynchronize(streams[0]));
            followed[0] = streams[1];
            OK(clsdf_cuda_arrays_follow(arrays, followed, 1));
        }
        OK(clsdf_cuda_arrays_begin_run(arrays, NULL, NULL, 0, &event));
        OK(clsdf_point_plan_enqueue(plan, NULL, &at, &target, 1, NULL, &event, 1, &done));
        OK(clsdf_cuda_arrays_end_run(arrays, done));
        clReleaseEvent((cl_event)done);
        check_copy(phi, expected, POINTS, streams[1]);
    }
    FAILS(CLSDF_INVALID_ARGUMENT, "no stream", clsdf_cuda_arrays_follow(arrays, NULL, 0));
    FAILS(CLSDF_INVALID_ARGUMENT, "streams is null", clsdf_cuda_arrays_follow(arrays, NULL, 1));
    OK(clsdf_cuda_arrays_begin_run(arrays, NULL, NULL, 0, &event));
    FAILS(CLSDF_INVALID_ARGUMENT, "no event", clsdf_cuda_arrays_end_run(arrays, NULL));
    event = arrays;
    FAILS(CLSDF_INVALID_ARGUMENT, "before the end()", clsdf_cuda_arrays_begin_run(arrays, NULL, NULL, 0, &event));
    CHECK(event == NULL);
    FAILS(CLSDF_INVALID_ARGUMENT, "wait_list is null", clsdf_cuda_arrays_begin_run(arrays, NULL, NULL, 1, &event));
    clsdf_cuda_arrays_release(arrays); /* abandons the run */
    clsdf_point_plan_release(plan);
    for (n = 0; n < 2; ++n) DONE(cuStreamDestroy(streams[n]));
    DONE(cuMemFree(asked));
    DONE(cuMemFree(phi));
}

static void check_misuse(const clsdf_cuda_device* gpu, clsdf_transform* transform) {
    const CUdeviceptr memory = cuda_memory(NULL, 64);
    clsdf_cuda_array array = used(memory, 64, CLSDF_CUDA_READ, NULL);
    clsdf_cuda_arrays* arrays;
    clsdf_cuda_device* no_gpu;
    clsdf_cuda_memory* no_memory;
    clsdf_array place;
    FAILS(CLSDF_INVALID_ARGUMENT, "no array", clsdf_cuda_arrays_create(gpu, NULL, 0, &arrays));
    FAILS(CLSDF_INVALID_ARGUMENT, "used is null", clsdf_cuda_arrays_create(gpu, NULL, 1, &arrays));
    array.name = "phi";
    array.bytes = 0;
    FAILS(CLSDF_INVALID_ARGUMENT, "phi has 0 bytes", clsdf_cuda_arrays_create(gpu, &array, 1, &arrays));
    array.bytes = -1;
    FAILS(CLSDF_INVALID_ARGUMENT, "clsdf_cuda_array.bytes", clsdf_cuda_arrays_create(gpu, &array, 1, &arrays));
    array.bytes = 64;
    array.access = 3;
    FAILS(CLSDF_INVALID_ARGUMENT, "clsdf_cuda_array.access", clsdf_cuda_arrays_create(gpu, &array, 1, &arrays));
    array.access = CLSDF_CUDA_READ;
    array.reserved = 1;
    FAILS(CLSDF_INVALID_ARGUMENT, "reserved", clsdf_cuda_arrays_create(gpu, &array, 1, &arrays));
    array.reserved = 0;
    array.address = 4096;
    FAILS(CLSDF_INVALID_ARGUMENT, "phi names an address that CUDA's driver does not know",
          clsdf_cuda_arrays_create(gpu, &array, 1, &arrays));
    CHECK(arrays == NULL);
    array.address = memory;
    OK(clsdf_cuda_arrays_create(gpu, &array, 1, &arrays));
    FAILS(CLSDF_INVALID_ARGUMENT, "no array 1", clsdf_cuda_arrays_get(arrays, 1, CLSDF_FLOAT32, 16, &place));
    FAILS(CLSDF_INVALID_ARGUMENT, "index is -1", clsdf_cuda_arrays_get(arrays, -1, CLSDF_FLOAT32, 16, &place));
    FAILS(CLSDF_INVALID_ARGUMENT, "type", clsdf_cuda_arrays_get(arrays, 0, 99, 16, &place));
    FAILS(CLSDF_INVALID_ARGUMENT, "array is null", clsdf_cuda_arrays_get(arrays, 0, CLSDF_FLOAT32, 16, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "list of arrays of CUDA is null", clsdf_cuda_arrays_begin(NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "given as a list of arrays of CUDA is one of a transform",
          clsdf_cuda_arrays_begin((clsdf_cuda_arrays*)transform));
    FAILS(CLSDF_INVALID_ARGUMENT, "device is null", clsdf_cuda_device_create(NULL, &no_gpu));
    FAILS(CLSDF_INVALID_ARGUMENT, "bytes is -1", clsdf_cuda_memory_create(gpu, -1, &no_memory));
    CHECK(no_gpu == NULL && no_memory == NULL);
    clsdf_cuda_arrays_release(arrays);
    DONE(cuMemFree(memory));
}

int main(void) {
    static float expected[SAMPLES];
    const clsdf_band band = clsdf_band_full();
    clsdf_grid_options options = CLSDF_GRID_OPTIONS_INIT;
    clsdf_target target = float_target(expected, SAMPLES);
    clsdf_device* device;
    clsdf_cuda_device* gpu;
    clsdf_mesh* mesh;
    clsdf_transform* transform;
    clsdf_grid grid;
    clsdf_box box;
    CUcontext context, current;
    int32_t ordinal, has_semaphores;

    DONE(cuInit(0));
    OK(clsdf_device_automatic(&device));
    OK(clsdf_cuda_device_create(device, &gpu));
    OK(clsdf_cuda_device_ordinal(gpu, &ordinal));
    OK(clsdf_cuda_device_has_semaphores(gpu, &has_semaphores));
    CHECK(ordinal == 1);
    CHECK(has_semaphores == (strcmp(getenv("CLSDF_DISGUISE_EXTERNAL"), "memory") != 0));
    OK(clsdf_mesh_shape("knot", &mesh));
    OK(clsdf_transform_create(device, mesh, NULL, NULL, &transform));
    options.resolution = N;
    options.cubic = 1;
    OK(clsdf_mesh_box(mesh, &box));
    OK(clsdf_grid_around_box(&box, &options, &grid));
    OK(clsdf_compute(transform, &grid, &band, &target, 1, NULL, NULL));

    DONE(cuDevicePrimaryCtxRetain(&context, ordinal));
    DONE(cuCtxPushCurrent(context));
    check_calls(device, gpu, mesh, &grid, expected);
    check_runs(gpu, transform);
    check_misuse(gpu, transform);
    DONE(cuCtxGetCurrent(&current));
    CHECK(current == context);
    DONE(cuCtxPopCurrent(NULL));
    DONE(cuDevicePrimaryCtxRelease(ordinal));

    clsdf_device_release(device);
    clsdf_transform_release(transform);
    clsdf_mesh_release(mesh);
    clsdf_cuda_device_retain(gpu);
    clsdf_cuda_device_release(gpu);
    CHECK(cuda_stand_in_owners(ordinal) == 1);
    clsdf_cuda_device_release(gpu);
    CHECK(cuda_stand_in_owners(ordinal) == 0);
    return 0;
}
