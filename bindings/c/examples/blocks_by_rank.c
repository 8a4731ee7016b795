/* A parallel simulation with MPI: the blocks that the surface crosses are divided among the ranks. Each rank takes its
 * share of the machine, keeps only what its blocks need of the mesh, and computes them in one call. The bytes do not
 * depend on the number of ranks.
 *
 * blocks_by_rank [RESOLUTION] */

#include <mpi.h>

#include "example.h"

#include <string.h>

enum { SIDE = 16, GHOSTS = 2, OUTER = SIDE + 2 * GHOSTS, SAMPLES = OUTER * OUTER * OUTER };

/* This rank's share of the machine: a GPU, or a part of the cores. */
static clsdf_device* device_of_rank(void) {
    clsdf_device* device;
    MPI_Comm node;
    int rank, ranks;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
    MPI_Comm_rank(node, &rank);
    MPI_Comm_size(node, &ranks);
    MPI_Comm_free(&node);
    check(clsdf_device_of_rank(rank, ranks, &device));
    return device;
}

/* All blocks of the domain that hold samples near the surface, in the same order on every rank. */
static int64_t blocks_near(const clsdf_transform* transform, const clsdf_grid* domain, double half_width,
                           clsdf_grid** near_surface) {
    const int64_t size[3] = {SIDE, SIDE, SIDE};
    int64_t first[3], most = 1, count = 0, kept = 0, n;
    clsdf_grid* blocks;
    clsdf_box* boxes;
    uint8_t* places;
    int axis;
    for (axis = 0; axis < 3; ++axis) most *= (domain->size[axis] + SIDE - 1) / SIDE;
    blocks = allocate((size_t)most * sizeof *blocks);
    boxes = allocate((size_t)most * sizeof *boxes);
    places = allocate((size_t)most);
    for (first[2] = 0; first[2] < domain->size[2]; first[2] += SIDE)
        for (first[1] = 0; first[1] < domain->size[1]; first[1] += SIDE)
            for (first[0] = 0; first[0] < domain->size[0]; first[0] += SIDE, ++count) {
                check(clsdf_grid_block(domain, first, size, &blocks[count]));
                check(clsdf_grid_grown(&blocks[count], GHOSTS, &blocks[count]));
                check(clsdf_grid_box(&blocks[count], &boxes[count]));
            }
    check(clsdf_classify(transform, boxes, count, half_width, places));
    for (n = 0; n < count; ++n)
        if (places[n] == CLSDF_WITHIN) blocks[kept++] = blocks[n];
    free(places);
    free(boxes);
    *near_surface = blocks;
    return kept;
}

/* FNV-1a. */
static uint64_t hashed(uint64_t hash, const void* bytes, size_t size) {
    const unsigned char* byte = bytes;
    size_t n;
    for (n = 0; n < size; ++n) hash = (hash ^ byte[n]) * UINT64_C(0x100000001b3);
    return hash;
}

int main(int argument_count, char** arguments) {
    int rank, ranks;
    uint64_t sum = 0, total = 0;
    int64_t all, begin, end, n;
    double voxel;
    clsdf_band band = clsdf_band_full();
    clsdf_device* device;
    clsdf_mesh* mesh;
    clsdf_transform *whole, *part;
    clsdf_grid domain, *blocks;

    MPI_Init(&argument_count, &arguments);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    device = device_of_rank();
    check(clsdf_mesh_shape("knot", &mesh));
    check(clsdf_grid_around_mesh(mesh, argument_count > 1 ? atol(arguments[1]) : 96, &band, &domain));
    check(clsdf_grid_voxel(&domain, &voxel));
    band = clsdf_band_symmetric(3 * voxel);
    check(clsdf_transform_create(device, mesh, NULL, NULL, &whole));

    /* Consecutive blocks are near each other: each rank takes a sub-range of them. */
    all = blocks_near(whole, &domain, band.outside, &blocks);
    begin = all * rank / ranks;
    end = all * (rank + 1) / ranks;
    if (end > begin) {
        clsdf_region* regions = allocate((size_t)(end - begin) * sizeof *regions);
        clsdf_request* requests = allocate((size_t)(end - begin) * sizeof *requests);
        clsdf_target* targets = allocate((size_t)(end - begin) * sizeof *targets);
        float* distances = allocate((size_t)(end - begin) * SAMPLES * sizeof *distances);
        for (n = 0; n < end - begin; ++n) {
            check(clsdf_grid_box(&blocks[begin + n], &regions[n].box));
            regions[n].half_width = band.outside;
            regions[n].spacing = voxel;
            targets[n] = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT32, distances + n * SAMPLES, SAMPLES);
            requests[n].grid = blocks[begin + n];
            requests[n].band = band;
            requests[n].targets.items = &targets[n];
            requests[n].targets.count = 1;
        }
        /* The part of the mesh that the rank's blocks need. The rest ends with the whole transform. */
        check(clsdf_transform_restrict(whole, regions, end - begin, &part));
        clsdf_transform_release(whole);
        whole = NULL;
        check(clsdf_compute_requests(part, requests, end - begin, NULL, NULL));
        clsdf_transform_release(part);
        for (n = 0; n < end - begin; ++n) {
            const uint64_t place = hashed(UINT64_C(0xcbf29ce484222325), requests[n].grid.first, 3 * sizeof(int64_t));
            sum += hashed(place, distances + n * SAMPLES, SAMPLES * sizeof *distances);
        }
        free(distances);
        free(targets);
        free(requests);
        free(regions);
    }

    MPI_Reduce(&sum, &total, 1, MPI_UINT64_T, MPI_SUM, 0, MPI_COMM_WORLD);
    if (rank == 0) printf("%ld blocks of all ranks: hash %016llx\n", (long)all, (unsigned long long)total);
    free(blocks);
    clsdf_transform_release(whole);
    clsdf_mesh_release(mesh);
    clsdf_device_release(device);
    MPI_Finalize();
    return all > 0 ? 0 : 1;
}
