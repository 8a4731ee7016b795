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

/* A plan of points, from and to particles: positions of three doubles, a distance, and a status. */
static void check_point_plan(const clsdf_transform* transform) {
    enum { COUNT = 300 };
    struct {
        double position[3];
        float distance;
        uint8_t status, padding[3];
    } particles[COUNT];
    double points[COUNT][3];
    float expected[COUNT];
    clsdf_array from, status;
    clsdf_target target;
    clsdf_statistics statistics = CLSDF_STATISTICS_INIT;
    clsdf_point_plan* plan;
    cl_mem memory;
    cl_event event;
    void* done;
    int64_t count;
    int32_t rule;
    int i, axis;
    memset(particles, 0, sizeof particles);
    for (i = 0; i < COUNT; ++i)
        for (axis = 0; axis < 3; ++axis)
            points[i][axis] = particles[i].position[axis] = (i * (7 + axis) % COUNT) / 100.0 - 1.5;
    points[5][1] = particles[5].position[1] = NAN;
    OK(clsdf_query_distance(transform, points[0], COUNT, HUGE_VAL, expected));
    memory = buffer_of(sizeof particles, particles);
    from = clsdf_buffer_array(CLSDF_FLOAT64, memory, COUNT);
    from.strides[0] = sizeof particles[0];
    target = clsdf_buffer_target(CLSDF_DISTANCE, CLSDF_FLOAT32, memory);
    target.array.offset = 24;
    target.array.strides[0] = sizeof particles[0];
    status = clsdf_buffer_array(CLSDF_UINT8, memory, COUNT);
    status.offset = 28;
    status.strides[0] = sizeof particles[0];
    FAILS(CLSDF_INVALID_ARGUMENT, "0 points", clsdf_point_plan_create(transform, 0, 1, 0, NULL, &plan));
    OK(clsdf_point_plan_create(transform, COUNT, HUGE_VAL, 0, NULL, &plan));
    OK(clsdf_point_plan_count(plan, &count));
    OK(clsdf_point_plan_sign(plan, &rule));
    OK(clsdf_point_plan_statistics(plan, &statistics));
    CHECK(count == COUNT && rule == CLSDF_SIGN_NONZERO && statistics.device_bytes > 0);
    OK(clsdf_point_plan_update(plan, transform, NULL));
    OK(clsdf_point_plan_enqueue(plan, NULL, &from, &target, 1, &status, NULL, 0, &done));
    event = done;
    OK(clsdf_point_plan_enqueue(plan, queue, &from, &target, 1, NULL, &done, 1, &done));
    clReleaseEvent(event);
    event = done;
    CHECK(clWaitForEvents(1, &event) == CL_SUCCESS);
    clReleaseEvent(event);
    CHECK(clEnqueueReadBuffer(queue, memory, CL_TRUE, 0, sizeof particles, particles, 0, NULL, NULL) == CL_SUCCESS);
    for (i = 0; i < COUNT; ++i) {
        CHECK(particles[i].status == (i == 5 ? CLSDF_NOT_FINITE : CLSDF_FOUND));
        CHECK(memcmp(&particles[i].distance, &expected[i], sizeof expected[i]) == 0);
    }
    done = plan;
    FAILS(CLSDF_INVALID_ARGUMENT, "the points lie on the same bytes",
          clsdf_point_plan_enqueue(plan, queue, &from, (target.array.offset = 0, &target), 1, NULL, NULL, 0, &done));
    CHECK(done == NULL);
    clsdf_point_plan_release(plan);
    clReleaseMemObject(memory);
}

/* Links that stay on the device have the bytes of those on the host. */
static void check_link_plan(clsdf_transform* transform, const clsdf_grid* grid) {
    clsdf_link_arrays links;
    clsdf_link_buffers buffers = CLSDF_LINK_BUFFERS_INIT;
    clsdf_statistics statistics = CLSDF_STATISTICS_INIT;
    clsdf_device_link_count total;
    clsdf_link_plan* plan;
    clsdf_grid of_plan, part;
    const int64_t first[3] = {0, 0, 2}, size[3] = {N, N, N / 2};
    int32_t directions[27][3], *samples, rule;
    int64_t direction_count, count, room;
    double* q;
    cl_mem memory;
    cl_event event;
    void* done;
    OK(clsdf_stencil("D3Q19", "XLB", &directions[0][0], &direction_count));
    OK(clsdf_count_links(transform, grid, &directions[0][0], direction_count, NULL, NULL, &count));
    memset(&links, 0, sizeof links);
    links.room = count;
    links.samples = allocate((size_t)count * 12);
    links.q = allocate((size_t)count * 8);
    OK(clsdf_links(transform, grid, &directions[0][0], direction_count, NULL, &links, NULL, NULL, &count));
    samples = allocate((size_t)count * 12);
    q = allocate((size_t)count * 8);
    OK(clsdf_link_plan_create(transform, grid, &directions[0][0], direction_count, count, NULL, NULL, &plan));
    OK(clsdf_link_plan_grid(plan, &of_plan, &room));
    OK(clsdf_link_plan_sign(plan, &rule));
    OK(clsdf_link_plan_statistics(plan, &statistics));
    CHECK(memcmp(&of_plan, grid, sizeof of_plan) == 0 && room == count && rule == CLSDF_SIGN_NONZERO);
    CHECK(statistics.device_bytes > 30 * count);
    OK(clsdf_link_plan_update(plan, transform, NULL));
    memory = buffer_of(16 + (size_t)count * 20, NULL);
    buffers.room = count;
    buffers.count = memory;
    buffers.q = clsdf_buffer_array(CLSDF_FLOAT64, memory, count);
    buffers.q.offset = 16;
    buffers.samples = clsdf_buffer_array(CLSDF_INT32, memory, count);
    buffers.samples.offset = 16 + 8 * count;
    OK(clsdf_link_plan_enqueue(plan, queue, &buffers, NULL, 0, &done));
    event = done;
    CHECK(clWaitForEvents(1, &event) == CL_SUCCESS);
    clReleaseEvent(event);
    CHECK(clEnqueueReadBuffer(queue, memory, CL_TRUE, 0, 16, &total, 0, NULL, NULL) == CL_SUCCESS);
    CHECK(total.links == count && total.is_complete == 1);
    CHECK(clEnqueueReadBuffer(queue, memory, CL_TRUE, 16, (size_t)count * 8, q, 0, NULL, NULL) == CL_SUCCESS);
    CHECK(memcmp(q, links.q, (size_t)count * 8) == 0);
    CHECK(clEnqueueReadBuffer(queue, memory, CL_TRUE, 16 + (size_t)count * 8, (size_t)count * 12, samples, 0, NULL,
                              NULL) == CL_SUCCESS);
    CHECK(memcmp(samples, links.samples, (size_t)count * 12) == 0);
    OK(clsdf_grid_part(grid, first, size, &part));
    OK(clsdf_link_plan_update_grid(plan, transform, &part, 5, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "room for 5", clsdf_link_plan_enqueue(plan, queue, &buffers, NULL, 0, NULL));
    buffers.room = 6;
    FAILS(CLSDF_INVALID_ARGUMENT, "there are 6 rows", clsdf_link_plan_enqueue(plan, queue, &buffers, NULL, 0, NULL));
    clsdf_link_plan_release(plan);
    clReleaseMemObject(memory);
    free(links.samples), free(links.q), free(samples), free(q);
}

static void check_read(cl_mem memory, size_t offset, const float* expected, size_t count) {
    float* values = allocate(count * sizeof *values);
    CHECK(clEnqueueReadBuffer(queue, memory, CL_TRUE, offset, count * sizeof *values, values, 0, NULL, NULL) ==
          CL_SUCCESS);
    CHECK(memcmp(values, expected, count * sizeof *values) == 0);
    free(values);
}

/* A sparse field that stays on the device has the bytes of one on the host. */
static void check_sparse_plan(clsdf_transform* transform, const clsdf_grid* grid) {
    const double quarter[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1}, nowhere[3] = {0, 0, 0};
    clsdf_sparse_request request, back;
    clsdf_sparse_counts room = {2, 1}, found_room;
    clsdf_device_sparse_counts counts;
    clsdf_sparse_buffers buffers = CLSDF_SPARSE_BUFFERS_INIT;
    clsdf_statistics statistics = CLSDF_STATISTICS_INIT;
    clsdf_sparse_plan* plan;
    clsdf_sparse_field* field;
    clsdf_sparse_slab slab = CLSDF_SPARSE_SLAB_INIT;
    clsdf_target value;
    cl_mem memory[4];
    int64_t* bricks;
    int32_t rule;
    void* done;
    cl_event event;
    int n;
    memset(&request, 0, sizeof request);
    request.grid = *grid;
    request.band = clsdf_band_symmetric(2 * grid->spacing[0]);
    OK(clsdf_sparse_plan_create(transform, &request, &room, NULL, &plan));
    clsdf_sparse_plan_retain(plan);
    clsdf_sparse_plan_release(plan);
    memory[0] = buffer_of(sizeof counts, NULL);
    for (n = 0; n < 3; ++n) {
        size_t samples;
        if (n == 2) { /* moved; the room of the step before */
            OK(clsdf_transform_set_motion(transform, quarter, nowhere));
            OK(clsdf_sparse_plan_update(plan, transform, NULL));
        }
        memory[1] = buffer_of((size_t)room.bricks * 24, NULL);
        memory[2] = buffer_of((size_t)room.runs * sizeof(clsdf_brick_run), NULL);
        memory[3] = buffer_of((size_t)room.bricks * CLSDF_BRICK_SAMPLES * sizeof(float), NULL);
        buffers.counts = memory[0];
        buffers.bricks = memory[1];
        buffers.inside = memory[2];
        value = clsdf_buffer_target(CLSDF_DISTANCE, CLSDF_FLOAT32, memory[3]);
        buffers.values.items = &value;
        buffers.values.count = 1;
        OK(clsdf_sparse_plan_enqueue(plan, queue, &buffers, NULL, 0, &done));
        event = done;
        CHECK(clWaitForEvents(1, &event) == CL_SUCCESS);
        clReleaseEvent(event);
        CHECK(clEnqueueReadBuffer(queue, memory[0], CL_TRUE, 0, sizeof counts, &counts, 0, NULL, NULL) == CL_SUCCESS);
        CHECK(counts.is_complete == (n > 0));
        if (n == 0) { /* too little room */
            room.bricks = counts.bricks + 200;
            room.runs = counts.runs + 200;
            OK(clsdf_sparse_plan_update_request(plan, transform, &request, &room, NULL));
        } else {
            OK(clsdf_compute_sparse_field(transform, &request.grid, &request.band, 0, NULL, NULL, &field));
            OK(clsdf_sparse_field_slab(field, &slab));
            CHECK(counts.bricks == slab.brick_count && counts.runs == slab.run_count);
            samples = (size_t)slab.brick_count * CLSDF_BRICK_SAMPLES;
            check_read(memory[3], 0, slab.values.items[0].array.host, samples);
            bricks = allocate((size_t)counts.bricks * 24);
            CHECK(clEnqueueReadBuffer(queue, memory[1], CL_TRUE, 0, (size_t)counts.bricks * 24, bricks, 0, NULL,
                                      NULL) == CL_SUCCESS);
            CHECK(memcmp(bricks, slab.bricks, (size_t)counts.bricks * 24) == 0);
            free(bricks);
            clsdf_sparse_field_release(field);
        }
        for (rule = 1; rule < 4; ++rule) clReleaseMemObject(memory[rule]);
    }
    OK(clsdf_sparse_plan_request(plan, &back, &found_room));
    CHECK(back.grid.size[0] == grid->size[0] && found_room.bricks == room.bricks);
    OK(clsdf_sparse_plan_sign(plan, &rule));
    OK(clsdf_sparse_plan_statistics(plan, &statistics));
    CHECK(rule == CLSDF_SIGN_NONZERO && statistics.device_bytes > 0);
    done = &event;
    buffers.bricks = NULL;
    FAILS(CLSDF_INVALID_ARGUMENT, "array of bricks has no memory",
          clsdf_sparse_plan_enqueue(plan, queue, &buffers, NULL, 0, &done));
    CHECK(done == NULL);
    FAILS(CLSDF_INVALID_ARGUMENT, "clsdf_sparse_buffers is null",
          clsdf_sparse_plan_enqueue(plan, queue, NULL, NULL, 0, NULL));
    room.bricks = -1;
    FAILS(CLSDF_INVALID_ARGUMENT, "clsdf_sparse_counts.bricks",
          clsdf_sparse_plan_update_request(plan, transform, &request, &room, NULL));
    clsdf_sparse_plan_release(plan);
    clReleaseMemObject(memory[0]);
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
    check_point_plan(transform);
    check_link_plan(transform, &grid);

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
    check_sparse_plan(transform, &grid);
    OK(clsdf_transform_set_motion(transform, quarter, nowhere));
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
