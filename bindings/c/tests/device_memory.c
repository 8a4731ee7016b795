/* Memory of the device: meshes, positions, points, outputs, and plans. */
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include "test.h"

enum { N = 16, SAMPLES = N * N * N };

static cl_context context;
static cl_command_queue queue;

static cl_mem buffer_of(size_t bytes, const void* content) {
    cl_int status;
    union {
        const void* input;
        void* memory;
    } from;
    cl_mem memory;
    from.input = content;
    memory = clCreateBuffer(context, CL_MEM_READ_WRITE | (content != NULL ? CL_MEM_COPY_HOST_PTR : 0), bytes,
                            from.memory, &status);
    CHECK(status == CL_SUCCESS);
    return memory;
}

static void check_read(cl_mem memory, size_t offset, const float* expected, size_t count) {
    float* values = allocate(count * sizeof *values);
    CHECK(clEnqueueReadBuffer(queue, memory, CL_TRUE, offset, count * sizeof *values, values, 0, NULL, NULL) ==
          CL_SUCCESS);
    CHECK(memcmp(values, expected, count * sizeof *values) == 0);
    free(values);
}

int main(void) {
    static float expected[SAMPLES], moved[SAMPLES];
    const double quarter[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1}, nowhere[3] = {0, 0, 0};
    const double points[2][3] = {{0, 0, 0}, {0.1, 0.1, 0.1}};
    const int64_t first[2][3] = {{0, 0, 0}, {0, 0, 8}}, half[3] = {N, N, 8};
    clsdf_device *device, *no_device;
    clsdf_mesh *mesh, *none;
    clsdf_transform *transform, *from_buffers;
    clsdf_plan* plan;
    clsdf_mesh_arrays arrays = CLSDF_MESH_ARRAYS_INIT;
    clsdf_block_set blocks = CLSDF_BLOCK_SET_INIT;
    clsdf_statistics statistics = CLSDF_STATISTICS_INIT;
    clsdf_call_options call = CLSDF_CALL_OPTIONS_INIT;
    clsdf_request request;
    clsdf_target target, back, two[2];
    clsdf_targets targets;
    clsdf_grid grid, read_grid;
    clsdf_band band = clsdf_band_full(), read_band;
    clsdf_array array;
    const double* vertices;
    const uint32_t* triangles;
    cl_mem phi, other, positions, faces, at;
    cl_event event;
    void *handles[2], *done;
    int64_t vertex_count, triangle_count, bytes, count;
    int32_t rule;
    int n;

    OK(clsdf_device_automatic(&device));
    OK(clsdf_device_handles(device, &handles[0], NULL, &handles[1]));
    context = handles[0];
    queue = handles[1];
    OK(clsdf_mesh_shape("knot", &mesh));
    OK(clsdf_transform_create(device, mesh, NULL, NULL, &transform));
    {
        clsdf_grid_options options = CLSDF_GRID_OPTIONS_INIT;
        clsdf_box box;
        options.resolution = N;
        options.cubic = 1;
        OK(clsdf_mesh_box(mesh, &box));
        OK(clsdf_grid_around_box(&box, &options, &grid));
    }
    target = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT32, expected, SAMPLES);
    OK(clsdf_compute(transform, &grid, &band, &target, 1, NULL, NULL));

    /* A mesh, points and a field in buffers. */
    OK(clsdf_mesh_vertices(mesh, &vertices, &vertex_count));
    OK(clsdf_mesh_triangles(mesh, &triangles, &triangle_count));
    positions = buffer_of((size_t)vertex_count * 24, vertices);
    faces = buffer_of((size_t)triangle_count * 12, triangles);
    phi = buffer_of(2 * sizeof expected, NULL);
    other = buffer_of(sizeof expected, NULL);
    arrays.vertices = clsdf_buffer_array(CLSDF_FLOAT64, positions, vertex_count);
    arrays.triangles = clsdf_buffer_array(CLSDF_UINT32, faces, triangle_count);
    OK(clsdf_transform_from_arrays(device, &arrays, NULL, NULL, &from_buffers));
    target = clsdf_buffer_target(CLSDF_DISTANCE, CLSDF_FLOAT32, phi);
    target.array.offset = sizeof expected;
    OK(clsdf_compute(from_buffers, &grid, &band, &target, 1, NULL, NULL));
    check_read(phi, sizeof expected, expected, SAMPLES);
    OK(clsdf_transform_set_positions(from_buffers, &arrays.vertices, NULL));
    clsdf_transform_release(from_buffers);
    FAILS(CLSDF_UNSUPPORTED, "memory of the device", clsdf_mesh_create(&arrays, &none));
    FAILS(CLSDF_UNSUPPORTED, "memory of the device", clsdf_mesh_set_positions(mesh, &arrays.vertices));
    at = buffer_of(sizeof points, points);
    array = clsdf_buffer_array(CLSDF_FLOAT64, at, 2);
    target.array.offset = 0;
    OK(clsdf_query(transform, &array, HUGE_VAL, &target, 1, NULL, NULL));

    /* Index base 1 on the device. */
    arrays.index_base = 1;
    FAILS(CLSDF_UNSUPPORTED, "index base", clsdf_transform_from_arrays(device, &arrays, NULL, NULL, &from_buffers));
    OK(clsdf_mesh_set_index_base(mesh, 1));
    OK(clsdf_transform_create(device, mesh, NULL, NULL, &from_buffers));
    two[0] = target;
    two[1] = clsdf_buffer_target(CLSDF_TRIANGLE, CLSDF_UINT32, other);
    FAILS(CLSDF_UNSUPPORTED, "index base", clsdf_compute(from_buffers, &grid, &band, two, 2, NULL, NULL));
    OK(clsdf_compute(from_buffers, &grid, &band, two, 1, NULL, NULL));
    FAILS(CLSDF_UNSUPPORTED, "index base",
          clsdf_plan_create(from_buffers, &grid, &band, CLSDF_SET(CLSDF_TRIANGLE), NULL, &plan));

    /* A plan of a grid, into two buffers, each run after the other's event. */
    OK(clsdf_plan_create(transform, &grid, &band, 0, NULL, &plan));
    done = handles;
    FAILS(CLSDF_INVALID_ARGUMENT, "target", clsdf_plan_enqueue(plan, NULL, NULL, 0, &done));
    CHECK(done == NULL);
    targets.items = &target;
    targets.count = 1;
    done = handles;
    FAILS(CLSDF_INVALID_ARGUMENT, "1 requests", clsdf_plan_enqueue_to(plan, queue, &targets, 2, NULL, 0, &done));
    CHECK(done == NULL);
    target.array.count = 5;
    FAILS(CLSDF_INVALID_ARGUMENT, "exactly 4096 items",
          clsdf_plan_enqueue_to(plan, queue, &targets, 1, NULL, 0, &done));
    target.array.count = SAMPLES;
    OK(clsdf_plan_enqueue_to(plan, queue, &targets, 1, NULL, 0, &done));
    target.array.device = other;
    event = done;
    OK(clsdf_plan_enqueue_to(plan, NULL, &targets, 1, &done, 1, &done)); /* waits for the event that it replaces */
    CHECK(done != NULL && done != (void*)event);
    clReleaseEvent(event);
    event = done;
    CHECK(clWaitForEvents(1, &event) == CL_SUCCESS);
    check_read(phi, 0, expected, SAMPLES);
    check_read(other, 0, expected, SAMPLES);
    /* A call that waits for an event. */
    call.wait_list = &done;
    call.wait_count = 1;
    OK(clsdf_compute(transform, &grid, &band, &target, 1, &call, NULL));
    clReleaseEvent(event);
    OK(clsdf_plan_request_count(plan, &count));
    OK(clsdf_plan_sign(plan, &rule));
    OK(clsdf_plan_statistics(plan, &statistics));
    CHECK(count == 1 && rule == CLSDF_SIGN_NONZERO && statistics.device_bytes > 0);
    clsdf_plan_release(plan);

    /* A plan of requests: new positions, new grids, other requests. */
    target.array.device = phi;
    request.grid = grid;
    request.band = band;
    request.targets = targets;
    OK(clsdf_plan_bytes_requests(transform, &request, 1, NULL, &bytes));
    OK(clsdf_plan_create_requests(transform, &request, 1, NULL, &plan));
    OK(clsdf_plan_statistics(plan, &statistics));
    CHECK(bytes > 0 && bytes == statistics.device_bytes);
    OK(clsdf_plan_request(plan, 0, &read_grid, &read_band, &back, 1, &count));
    /* The triangles of a plan count from the index base of the transform that made it. */
    FAILS(CLSDF_INVALID_ARGUMENT, "index base 0, and the transform has 1", clsdf_plan_update(plan, from_buffers, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "index base", clsdf_plan_update_grids(plan, from_buffers, &grid, 1, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "index base", clsdf_plan_update_requests(plan, from_buffers, &request, 1, NULL));
    clsdf_transform_release(from_buffers);
    CHECK(count == 1 && back.array.device == phi && read_grid.size[0] == N && read_band.inside == band.inside);
    FAILS(CLSDF_INVALID_ARGUMENT, "no request 1", clsdf_plan_request(plan, 1, NULL, NULL, NULL, 0, NULL));
    OK(clsdf_transform_set_motion(transform, quarter, nowhere));
    target = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT32, moved, SAMPLES);
    OK(clsdf_compute(transform, &grid, &band, &target, 1, NULL, NULL));
    for (n = 0; n < 3; ++n) {
        target = clsdf_buffer_target(CLSDF_DISTANCE, CLSDF_FLOAT32, phi);
        if (n == 0) OK(clsdf_plan_update(plan, transform, NULL));
        if (n == 1) OK(clsdf_plan_update_grids(plan, transform, &grid, 1, NULL));
        if (n == 2) OK(clsdf_plan_update_requests(plan, transform, &request, 1, NULL));
        OK(clsdf_plan_enqueue(plan, queue, NULL, 0, NULL));
        check_read(phi, 0, moved, SAMPLES);
    }
    /* Two halves, as blocks. */
    blocks.lattice = grid;
    blocks.band = band;
    memcpy(blocks.size, half, sizeof half);
    blocks.first = first[0];
    blocks.block_count = 2;
    blocks.targets = targets;
    OK(clsdf_plan_update_blocks(plan, transform, &blocks, NULL));
    OK(clsdf_plan_request_count(plan, &count));
    CHECK(count == 2);
    OK(clsdf_plan_enqueue(plan, queue, NULL, 0, NULL));
    check_read(phi, 0, moved, SAMPLES);
    clsdf_plan_release(plan);
    OK(clsdf_plan_bytes_blocks(transform, &blocks, NULL, &bytes));
    OK(clsdf_plan_create_blocks(transform, &blocks, NULL, &plan));
    clsdf_transform_release(transform); /* the plan may outlive it */
    OK(clsdf_plan_enqueue(plan, queue, NULL, 0, NULL));
    check_read(phi, 0, moved, SAMPLES);
    clsdf_plan_release(plan);
    FAILS(CLSDF_INVALID_ARGUMENT, "null", clsdf_device_from_handles(context, NULL, queue, &no_device));

    clsdf_device_release(device);
    clsdf_mesh_release(mesh);
    clReleaseMemObject(at);
    clReleaseMemObject(other);
    clReleaseMemObject(phi);
    clReleaseMemObject(faces);
    clReleaseMemObject(positions);
    return 0;
}
