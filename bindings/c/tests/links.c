/* Links and crossings of a box, whose walls lie between samples. */
#include "test.h"

enum { N = 8, EDGES = (N - 1) * N * N };

typedef struct Taken {
    const clsdf_link_arrays* whole;
    int64_t links, slabs, end;
} Taken;

static int32_t take(void* user, const clsdf_grid* part, const clsdf_link_arrays* links, int64_t count) {
    Taken* taken = user;
    const clsdf_link_arrays* whole = taken->whole;
    int64_t n;
    CHECK(part->first[2] == taken->end && links->room == count && links->dense == NULL);
    for (n = 0; n < count; ++n) {
        const int64_t m = taken->links + n;
        CHECK(memcmp(links->samples + 3 * n, whole->samples + 3 * m, 3 * sizeof(int32_t)) == 0);
        CHECK(links->directions[n] == whole->directions[m] && links->q[n] == whole->q[m]);
        CHECK(links->triangles[n] == whole->triangles[m] && links->counts[n] == 1 && links->flags[n] == 0);
    }
    CHECK(links->inside[2 + N * (2 + N * 2)] == 1 && links->inside[1] == 0);
    taken->links += count;
    taken->end += part->size[2];
    ++taken->slabs;
    return CLSDF_OK;
}

static int32_t stop(void* user, const clsdf_grid* part, const clsdf_link_arrays* links, int64_t count) {
    (void)user, (void)part, (void)links, (void)count;
    clsdf_set_last_error("enough");
    return CLSDF_CANCELLED;
}

int main(void) {
    static const double vertices[8][3] = {{1.25, 1.25, 1.25}, {5.25, 1.25, 1.25}, {5.25, 5.25, 1.25},
                                          {1.25, 5.25, 1.25}, {1.25, 1.25, 5.25}, {5.25, 1.25, 5.25},
                                          {5.25, 5.25, 5.25}, {1.25, 5.25, 5.25}};
    static const uint32_t triangles[12][3] = {{1, 3, 2}, {1, 4, 3}, {5, 6, 7}, {5, 7, 8}, {1, 2, 6}, {1, 6, 5},
                                              {2, 3, 7}, {2, 7, 6}, {3, 4, 8}, {3, 8, 7}, {4, 1, 5}, {4, 5, 8}};
    clsdf_mesh_arrays arrays = CLSDF_MESH_ARRAYS_INIT;
    clsdf_device* device = NULL;
    clsdf_mesh* mesh = NULL;
    clsdf_transform* transform = NULL;
    const clsdf_grid grid = {{0, 0, 0}, {1, 1, 1}, {N, N, N}, {0, 0, 0}};
    int32_t directions[27][3];
    int64_t direction_count = 0, count = 0, counted = 0, n, along_x = 0;
    clsdf_link_arrays links, dense;
    clsdf_statistics statistics = CLSDF_STATISTICS_INIT;
    Taken taken = {NULL, 0, 0, 0};
    clsdf_crossing_arrays crossings;
    arrays.vertices = clsdf_host_array(CLSDF_FLOAT64, &vertices[0][0], 8);
    arrays.triangles = clsdf_host_array(CLSDF_UINT32, &triangles[0][0], 12);
    arrays.index_base = 1;
    OK(clsdf_device_automatic(&device));
    OK(clsdf_mesh_create(&arrays, &mesh));
    OK(clsdf_transform_create(device, mesh, NULL, NULL, &transform));

    OK(clsdf_stencil("D3Q19", "OpenLB", &directions[0][0], &direction_count));
    CHECK(direction_count == 19 && directions[10][0] == 1 && directions[10][1] == 0);
    FAILS(CLSDF_INVALID_ARGUMENT, "D3Q99", clsdf_stencil("D3Q99", "OpenLB", &directions[0][0], &n));

    OK(clsdf_count_links(transform, &grid, &directions[0][0], direction_count, NULL, NULL, &counted));
    memset(&links, 0, sizeof links);
    links.room = counted;
    links.samples = allocate((size_t)counted * 3 * sizeof(int32_t));
    links.directions = allocate((size_t)counted);
    links.q = allocate((size_t)counted * sizeof(double));
    links.triangles = allocate((size_t)counted * sizeof(uint32_t));
    links.counts = allocate((size_t)counted * sizeof(uint32_t));
    links.flags = allocate((size_t)counted);
    links.inside = allocate(N * N * N);
    OK(clsdf_links(transform, &grid, &directions[0][0], direction_count, NULL, &links, NULL, NULL, &count));
    CHECK(count == counted);
    for (n = 0; n < count; ++n) {
        CHECK(links.triangles[n] >= 1 && links.triangles[n] <= 12 && links.counts[n] == 1 && links.flags[n] == 0);
        if (links.directions[n] != 11) continue; /* (1, 0, 0), from 1 on */
        CHECK(links.samples[3 * n] == 1 && links.q[n] == 0.25);
        CHECK(links.triangles[n] == 11 || links.triangles[n] == 12);
        ++along_x;
    }
    CHECK(along_x == 16);
    CHECK(links.inside[2 + N * (2 + N * 2)] == 1 && links.inside[1] == 0);
    taken.whole = &links;
    OK(clsdf_link_slabs(transform, &grid, &directions[0][0], direction_count, NULL, take, &taken, NULL, &statistics));
    CHECK(taken.links == count && taken.slabs == 1 && statistics.slabs == 1);
    FAILS(CLSDF_CANCELLED, "enough",
          clsdf_link_slabs(transform, &grid, &directions[0][0], direction_count, NULL, stop, NULL, NULL, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "sink",
          clsdf_link_slabs(transform, &grid, &directions[0][0], direction_count, NULL, NULL, NULL, NULL, NULL));

    memset(&dense, 0, sizeof dense);
    dense.dense = allocate(19 * N * N * N * sizeof(double));
    OK(clsdf_links(transform, &grid, &directions[0][0], direction_count, NULL, &dense, NULL, NULL, &n));
    CHECK(n == count);
    CHECK(dense.dense[1 + N * (2 + N * (2 + N * 10))] == 0.25 && dense.dense[2 + N * (2 + N * (2 + N * 10))] == -1);
    dense.dense_floats = (float*)dense.dense;
    FAILS(CLSDF_INVALID_ARGUMENT, "dense_floats",
          clsdf_links(transform, &grid, &directions[0][0], direction_count, NULL, &dense, NULL, NULL, &n));
    dense.dense = NULL;
    OK(clsdf_links(transform, &grid, &directions[0][0], direction_count, NULL, &dense, NULL, NULL, &n));
    CHECK(dense.dense_floats[1 + N * (2 + N * (2 + N * 10))] == 0.25F && dense.dense_floats[0] == -1);

    links.room = counted - 1;
    FAILS(CLSDF_INVALID_ARGUMENT, "room",
          clsdf_links(transform, &grid, &directions[0][0], direction_count, NULL, &links, NULL, NULL, &count));
    CHECK(count == counted);

    memset(&crossings, 0, sizeof crossings);
    crossings.coordinates[0] = allocate(EDGES * (sizeof(double) + sizeof(uint32_t)) + N * N * N);
    crossings.counts[0] = (uint32_t*)(crossings.coordinates[0] + EDGES); /* arrays may lie side by side */
    crossings.inside = (uint8_t*)(crossings.counts[0] + EDGES);
    crossings.triangles[2] = allocate(EDGES * sizeof(uint32_t));
    OK(clsdf_crossings(transform, &grid, &crossings, NULL, NULL));
    CHECK(crossings.coordinates[0][1 + (N - 1) * (2 + N * 2)] == 1.25 &&
          crossings.counts[0][1 + (N - 1) * (2 + N * 2)] == 1);
    CHECK(crossings.coordinates[0][2] != crossings.coordinates[0][2]);
    CHECK(crossings.triangles[2][2 + N * (2 + N * 1)] <= 2 && crossings.triangles[2][0] == 0);
    CHECK(crossings.inside[2 + N * (2 + N * 2)] == 1 && crossings.inside[1] == 0);
    /* Nothing is written if two arrays have a byte in common. */
    crossings.coordinates[1] = crossings.coordinates[0];
    crossings.coordinates[0][2] = 7;
    FAILS(CLSDF_INVALID_ARGUMENT, "coordinates[0] and coordinates[1] lie on the same bytes",
          clsdf_crossings(transform, &grid, &crossings, NULL, NULL));
    crossings.coordinates[1] = NULL;
    crossings.inside = (uint8_t*)(crossings.triangles[2] + EDGES) - 1;
    FAILS(CLSDF_INVALID_ARGUMENT, "triangles[2] and inside lie on the same bytes",
          clsdf_crossings(transform, &grid, &crossings, NULL, NULL));
    CHECK(crossings.coordinates[0][2] == 7);

    free(links.samples), free(links.directions), free(links.q), free(links.triangles), free(links.counts);
    free(links.flags), free(links.inside), free(crossings.coordinates[0]), free(crossings.triangles[2]);
    free(dense.dense_floats);
    clsdf_transform_release(transform), clsdf_mesh_release(mesh), clsdf_device_release(device);
    return 0;
}
