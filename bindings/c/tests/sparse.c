/* A sparse field has the values of the dense one, in the caller's arrays, in layers and in the library's memory. */
#include "test.h"

enum { N = 48 };
static const uint32_t both = CLSDF_SET(CLSDF_DISTANCE) | CLSDF_SET(CLSDF_TRIANGLE);

static clsdf_transform* transform; /* of a sphere whose triangles count from 1 */
static clsdf_band band;
static clsdf_grid grid, whole; /* whole: in whole bricks */
static float* distance;        /* of `whole` */
static uint32_t* triangle;
static clsdf_sparse_counts counts;

/* The caller's arrays for so many bricks and runs, each with room for one more that must stay as it is. */
typedef struct arrays {
    clsdf_sparse_arrays c;
    clsdf_target targets[2];
    int64_t* bricks;
    clsdf_brick_run* inside;
    float* distance;
    int32_t* triangle;
} arrays;

static const unsigned char untouched = 0xA5;

static void make(arrays* made, int64_t bricks, int64_t runs) {
    const clsdf_sparse_arrays initial = CLSDF_SPARSE_ARRAYS_INIT;
    const size_t count = (size_t)bricks, samples = count * CLSDF_BRICK_SAMPLES;
    made->bricks = allocate((count + 1) * 3 * sizeof(int64_t));
    made->inside = allocate(((size_t)runs + 1) * sizeof(clsdf_brick_run));
    made->distance = allocate((samples + 1) * sizeof(float));
    made->triangle = allocate((samples + 1) * sizeof(int32_t));
    memset(made->bricks, untouched, (count + 1) * 3 * sizeof(int64_t));
    memset(made->inside, untouched, ((size_t)runs + 1) * sizeof(clsdf_brick_run));
    memset(made->distance, untouched, (samples + 1) * sizeof(float));
    memset(made->triangle, untouched, (samples + 1) * sizeof(int32_t));
    made->targets[0] = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT32, made->distance, (int64_t)samples);
    made->targets[1] = clsdf_host_target(CLSDF_TRIANGLE, CLSDF_INT32, made->triangle, (int64_t)samples);
    made->c = initial;
    made->c.bricks = made->bricks;
    made->c.brick_room = bricks;
    made->c.inside = made->inside;
    made->c.run_room = runs;
    made->c.values.items = made->targets;
    made->c.values.count = 2;
}

static int is_untouched(const void* memory, size_t bytes) {
    const unsigned char* at = memory;
    while (bytes-- > 0)
        if (*at++ != untouched) return 0;
    return 1;
}

/* Elements behind so many bricks and runs are as make() has left them. */
static void check_rest(const arrays* made, int64_t bricks, int64_t runs) {
    const size_t room = (size_t)made->c.brick_room, used = (size_t)bricks;
    CHECK(is_untouched(made->bricks + 3 * used, (room + 1 - used) * 3 * sizeof(int64_t)));
    CHECK(is_untouched(made->inside + runs, (size_t)(made->c.run_room + 1 - runs) * sizeof(clsdf_brick_run)));
    CHECK(is_untouched(made->distance + used * 512, ((room - used) * 512 + 1) * sizeof(float)));
    CHECK(is_untouched(made->triangle + used * 512, ((room - used) * 512 + 1) * sizeof(int32_t)));
}

static void release(arrays* made) {
    free(made->bricks), free(made->inside), free(made->distance), free(made->triangle);
}

/* Every value of the layers is the dense field's; returns the number of samples in the bricks. */
static void check_layers(const clsdf_sparse_slab* slab) {
    const float* values = NULL;
    const uint32_t* triangles = NULL;
    int64_t n, i;
    for (n = 0; n < slab->values.count; ++n) {
        const clsdf_target* value = &slab->values.items[n];
        if (value->output == CLSDF_DISTANCE) values = value->array.host;
        if (value->output == CLSDF_TRIANGLE) triangles = value->array.host;
    }
    CHECK(slab->brick_count == 0 || (values != NULL && triangles != NULL));
    for (n = 0; n < slab->brick_count; ++n)
        for (i = 0; i < CLSDF_BRICK_SAMPLES; ++i) {
            const int64_t* brick = slab->bricks + 3 * n;
            const int64_t at =
                clsdf_grid_offset(&whole, brick[0] + i % 8 - whole.first[0], brick[1] + i / 8 % 8 - whole.first[1],
                                  brick[2] + i / 64 - whole.first[2]);
            CHECK(memcmp(&values[512 * n + i], &distance[at], sizeof(float)) == 0);
            CHECK(triangles[512 * n + i] == triangle[at]);
        }
}

/* Every sample of all layers, bricks or not. */
static void check_look_up(const clsdf_sparse_slab* slab) {
    int64_t sample[3], count = 0, number = 0;
    int64_t* samples = allocate((size_t)(whole.size[0] * whole.size[1] * whole.size[2]) * 3 * sizeof(int64_t));
    float* values;
    for (sample[2] = 0; sample[2] < whole.size[2]; ++sample[2])
        for (sample[1] = 0; sample[1] < whole.size[1]; ++sample[1])
            for (sample[0] = 0; sample[0] < whole.size[0]; ++sample[0], ++count) {
                int axis;
                for (axis = 0; axis < 3; ++axis) samples[3 * count + axis] = whole.first[axis] + sample[axis];
            }
    values = allocate((size_t)count * sizeof(float));
    OK(clsdf_sparse_distances(slab, &band, samples, count, values));
    CHECK(memcmp(values, distance, (size_t)count * sizeof(float)) == 0);
    OK(clsdf_sparse_find(slab, slab->bricks + 3 * 5, &number));
    CHECK(number == 5);
    OK(clsdf_sparse_find(slab, whole.first, &number));
    CHECK(number == -1);
    free(samples), free(values);
}

static void check_arrays(void) {
    clsdf_statistics statistics = CLSDF_STATISTICS_INIT;
    clsdf_sparse_slab slab = CLSDF_SPARSE_SLAB_INIT;
    clsdf_sparse_counts found;
    arrays exact, large, small;

    OK(clsdf_count_sparse(transform, &grid, &band, NULL, &statistics, &counts));
    CHECK(counts.bricks > 20 && counts.runs > 2 && statistics.slabs == 1);

    make(&exact, counts.bricks, counts.runs);
    OK(clsdf_compute_sparse(transform, &grid, &band, &exact.c, NULL, &statistics, &found));
    CHECK(memcmp(&found, &counts, sizeof counts) == 0);
    check_rest(&exact, counts.bricks, counts.runs);
    slab.part = whole;
    slab.bricks = exact.bricks, slab.brick_count = counts.bricks;
    slab.inside = exact.inside, slab.run_count = counts.runs;
    slab.values = exact.c.values;
    check_layers(&slab);
    check_look_up(&slab);

    make(&large, counts.bricks + 3, counts.runs + 2);
    OK(clsdf_compute_sparse(transform, &grid, &band, &large.c, NULL, NULL, &found));
    CHECK(memcmp(&found, &counts, sizeof counts) == 0);
    check_rest(&large, counts.bricks, counts.runs);
    CHECK(memcmp(large.bricks, exact.bricks, (size_t)counts.bricks * 3 * sizeof(int64_t)) == 0);
    CHECK(memcmp(large.inside, exact.inside, (size_t)counts.runs * sizeof(clsdf_brick_run)) == 0);
    slab.values = large.c.values; /* more items than the bricks have */
    check_look_up(&slab);
    release(&large);

    /* Too little room for bricks, for runs, for anything. */
    {
        const int64_t rooms[3][2] = {{counts.bricks - 1, counts.runs}, {counts.bricks, counts.runs - 1}, {0, 0}};
        char message[160];
        int i;
        for (i = 0; i < 3; ++i) {
            make(&small, rooms[i][0], rooms[i][1]);
            snprintf(
                message, sizeof message,
                "has %ld bricks with values and %ld runs of bricks inside, and the arrays have room for %ld and %ld;",
                (long)counts.bricks, (long)counts.runs, (long)rooms[i][0], (long)rooms[i][1]);
            FAILS(CLSDF_INVALID_ARGUMENT, message,
                  clsdf_compute_sparse(transform, &grid, &band, &small.c, NULL, NULL, &found));
            CHECK(memcmp(&found, &counts, sizeof counts) == 0);
            check_rest(&small, small.c.brick_room, small.c.run_room);
            release(&small);
        }
    }
    release(&exact);
}

static int64_t next_z, layers;

static int32_t take(void* user, const clsdf_sparse_slab* slab) {
    clsdf_sparse_counts* sum = user;
    CHECK(slab->part.first[2] == next_z);
    next_z += slab->part.size[2];
    check_layers(slab);
    sum->bricks += slab->brick_count;
    sum->runs += slab->run_count;
    ++layers;
    return CLSDF_OK;
}

static int32_t end_with_1007(void* user, const clsdf_sparse_slab* slab) {
    (void)user;
    (void)slab;
    clsdf_set_last_error("enough bricks");
    return 1007;
}

static void check_sink(void) {
    clsdf_sparse_counts sum = {0, 0};
    clsdf_statistics statistics = CLSDF_STATISTICS_INIT;
    next_z = whole.first[2];
    OK(clsdf_compute_sparse_slabs(transform, &grid, &band, both, take, &sum, NULL, &statistics));
    CHECK(next_z == whole.first[2] + whole.size[2] && layers == statistics.slabs);
    CHECK(memcmp(&sum, &counts, sizeof counts) == 0);
    FAILS(1007, "enough bricks",
          clsdf_compute_sparse_slabs(transform, &grid, &band, both, end_with_1007, NULL, NULL, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "sink is null",
          clsdf_compute_sparse_slabs(transform, &grid, &band, both, NULL, NULL, NULL, NULL));
}

static void check_fields(void) {
    clsdf_sparse_field *field, *fields[2];
    clsdf_sparse_slab slab = CLSDF_SPARSE_SLAB_INIT;
    clsdf_field_description description = CLSDF_FIELD_DESCRIPTION_INIT;
    clsdf_sparse_request requests[2];
    int i;
    OK(clsdf_compute_sparse_field(transform, &grid, &band, both, NULL, NULL, &field));
    OK(clsdf_sparse_field_slab(field, &slab));
    CHECK(slab.brick_count == counts.bricks && slab.run_count == counts.runs && slab.values.count == 2);
    check_layers(&slab);
    check_look_up(&slab);
    OK(clsdf_sparse_field_describe(field, &description));
    CHECK(memcmp(&description.grid, &grid, sizeof grid) == 0 && strcmp(description.mesh_name, "sphere3") == 0);
    clsdf_sparse_field_retain(field);
    clsdf_sparse_field_release(field);
    clsdf_sparse_field_release(field);

    /* The two halves in one call. */
    memset(requests, 0, sizeof requests);
    requests[0].grid = requests[1].grid = whole;
    requests[0].band = requests[1].band = band;
    requests[0].outputs = requests[1].outputs = both;
    requests[0].grid.size[2] = 16;
    requests[1].grid.first[2] += 16;
    requests[1].grid.size[2] -= 16;
    OK(clsdf_compute_sparse_requests(transform, requests, 2, NULL, NULL, fields));
    {
        clsdf_sparse_counts sum = {0, 0};
        for (i = 0; i < 2; ++i) {
            OK(clsdf_sparse_field_slab(fields[i], &slab));
            check_layers(&slab);
            sum.bricks += slab.brick_count;
            sum.runs += slab.run_count;
            clsdf_sparse_field_release(fields[i]);
        }
        CHECK(memcmp(&sum, &counts, sizeof counts) == 0);
    }
    requests[1].grid.size[1] = 0;
    FAILS(CLSDF_INVALID_ARGUMENT, "request 1 of 2",
          clsdf_compute_sparse_requests(transform, requests, 2, NULL, NULL, fields));
    CHECK(fields[0] == NULL && fields[1] == NULL);
    requests[0].reserved = 1;
    FAILS(CLSDF_INVALID_ARGUMENT, "request 0 of 2: clsdf_sparse_request.reserved",
          clsdf_compute_sparse_requests(transform, requests, 2, NULL, NULL, fields));
}

static void check_errors(void) {
    const clsdf_band full = clsdf_band_full();
    clsdf_sparse_counts found = {7, 7};
    clsdf_sparse_slab slab = CLSDF_SPARSE_SLAB_INIT;
    clsdf_sparse_field* field;
    const int64_t sample[3] = {0, 0, 0};
    int64_t number;
    float value;
    arrays made;
    make(&made, 10, 10);
#define WRONG(part) \
    FAILS(CLSDF_INVALID_ARGUMENT, part, clsdf_compute_sparse(transform, &grid, &band, &made.c, NULL, NULL, &found))
    FAILS(CLSDF_INVALID_ARGUMENT, "band with an end",
          clsdf_compute_sparse(transform, &grid, &full, &made.c, NULL, NULL, &found));
    CHECK(found.bricks == 0 && found.runs == 0);
    FAILS(CLSDF_INVALID_ARGUMENT, "counts is null",
          clsdf_compute_sparse(transform, &grid, &band, &made.c, NULL, NULL, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "clsdf_sparse_arrays is null",
          clsdf_compute_sparse(transform, &grid, &band, NULL, NULL, NULL, &found));
    FAILS(CLSDF_INVALID_ARGUMENT, "counts is null", clsdf_count_sparse(transform, &grid, &band, NULL, NULL, NULL));
    made.targets[0].array.count = 9 * 512;
    WRONG("exactly 5120 items");
    made.targets[0].array.count = 0;
    made.targets[0].array.bytes = 9 * 512 * 4;
    WRONG("room for bricks of 5120 samples");
    made.targets[0].array.bytes = 0;
    made.targets[0].array.type = CLSDF_FLOAT64;
    FAILS(CLSDF_UNSUPPORTED, "doubles", clsdf_compute_sparse(transform, &grid, &band, &made.c, NULL, NULL, &found));
    made.targets[0].array.type = CLSDF_FLOAT32;
    made.targets[0].array.strides[0] = 8;
    FAILS(CLSDF_UNSUPPORTED, "strides", clsdf_compute_sparse(transform, &grid, &band, &made.c, NULL, NULL, &found));
    made.targets[0].array.strides[0] = 0;
    made.targets[1].array.host = made.distance;
    WRONG("lie on the same bytes");
    made.targets[1].array.host = made.triangle;
    made.c.inside = (clsdf_brick_run*)(void*)made.distance;
    WRONG("lie on the same bytes");
    made.c.inside = (clsdf_brick_run*)(void*)(made.bricks + 3 * 9);
    made.c.run_room = 1;
    WRONG("lie on the same bytes");
    made.c.inside = made.inside;
    made.c.run_room = 10;
    made.c.values.count = 0;
    WRONG("the distance has no target");
    made.c.values.count = 2;
    made.c.brick_room = -1;
    WRONG("brick_room");
    release(&made);

    FAILS(CLSDF_INVALID_ARGUMENT, "field is null",
          clsdf_compute_sparse_field(transform, &grid, &band, both, NULL, NULL, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "the sparse field is null", clsdf_sparse_field_slab(NULL, &slab));
    FAILS(CLSDF_INVALID_ARGUMENT, "is one of a transform",
          clsdf_sparse_field_slab((const clsdf_sparse_field*)transform, &slab));
    FAILS(CLSDF_INVALID_ARGUMENT, "null", clsdf_sparse_field_describe(NULL, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "sample is null", clsdf_sparse_find(&slab, NULL, &number));
    FAILS(CLSDF_INVALID_ARGUMENT, "number is null", clsdf_sparse_find(&slab, sample, NULL));
    OK(clsdf_compute_sparse_field(transform, &grid, &band, both, NULL, NULL, &field));
    OK(clsdf_sparse_field_slab(field, &slab));
    slab.values.count = 0;
    FAILS(CLSDF_INVALID_ARGUMENT, "has no distances", clsdf_sparse_distances(&slab, &band, sample, 1, &value));
    clsdf_sparse_field_release(field);
}

int main(void) {
    clsdf_device* device;
    clsdf_mesh* mesh;
    clsdf_target targets[2];
    int64_t samples;
    OK(clsdf_device_automatic(&device));
    OK(clsdf_mesh_shape("sphere3", &mesh));
    OK(clsdf_mesh_set_index_base(mesh, 1));
    OK(clsdf_transform_create(device, mesh, NULL, NULL, &transform));
    band = clsdf_band_symmetric(0.05);
    OK(clsdf_grid_around_mesh(mesh, N, &band, &grid));
    grid.first[0] = -5; /* no multiple of a brick */
    grid.origin[0] += 5 * grid.spacing[0];
    grid.size[0] += 8;
    OK(clsdf_grid_in_whole_bricks(&grid, &whole));
    CHECK(whole.first[0] == -8 && whole.first[1] == 0 && whole.size[0] % 8 == 0);
    OK(clsdf_grid_sample_count(&whole, &samples));
    distance = allocate((size_t)samples * sizeof *distance);
    triangle = allocate((size_t)samples * sizeof *triangle);
    targets[0] = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT32, distance, samples);
    targets[1] = clsdf_host_target(CLSDF_TRIANGLE, CLSDF_UINT32, triangle, samples);
    OK(clsdf_compute(transform, &whole, &band, targets, 2, NULL, NULL));
    check_arrays();
    check_sink();
    check_fields();
    check_errors();
    free(distance), free(triangle);
    clsdf_sparse_field_retain(NULL);
    clsdf_sparse_field_release(NULL);
    clsdf_transform_release(transform);
    clsdf_mesh_release(mesh);
    clsdf_device_release(device);
    return 0;
}
