/* A grid is divided among the ranks of a parallel simulation. Each rank has a layer of ghost samples, and keeps only
 * what its block needs of the mesh.
 *
 * A part of a grid keeps the origin and spacing of the grid, and has the same bytes as the whole. So ghost samples are
 * equal on both sides and need no exchange. A transform that is restricted to the block gives these bytes, too. */

#include "example.h"

#include <string.h>

/* The samples of one rank of `ranks` along x, with a ghost layer on each side that has a neighbour. */
static clsdf_grid block_of(const clsdf_grid* domain, int64_t rank, int64_t ranks) {
    const int64_t ghosts = 2, samples = domain->size[0];
    int64_t begin = samples * rank / ranks - ghosts, end = samples * (rank + 1) / ranks + ghosts;
    int64_t offset[3] = {0, 0, 0}, size[3];
    clsdf_grid block;
    if (begin < 0) begin = 0;
    if (end > samples) end = samples;
    offset[0] = begin;
    size[0] = end - begin;
    size[1] = domain->size[1];
    size[2] = domain->size[2];
    check(clsdf_grid_part(domain, offset, size, &block));
    return block;
}

/* The transform of a rank: the part that its block needs. */
static clsdf_transform* transform_for(const clsdf_grid* block, double half_width, const clsdf_device* device,
                                      const clsdf_mesh* mesh) {
    clsdf_transform *whole, *part;
    clsdf_region region;
    check(clsdf_transform_create(device, mesh, NULL, NULL, &whole));
    check(clsdf_grid_box(block, &region.box));
    region.half_width = half_width;
    check(clsdf_grid_voxel(block, &region.spacing)); /* the largest, too: all three are equal */
    check(clsdf_transform_restrict(whole, &region, 1, &part));
    clsdf_transform_release(whole);
    return part;
}

/* The number of samples that differ between the block and the whole. */
static int64_t differences(const clsdf_grid* grid, const float* distance, const clsdf_grid* whole,
                           const float* all_distances) {
    const int64_t shift = grid->first[0] - whole->first[0];
    int64_t i, j, k, count = 0;
    for (k = 0; k < grid->size[2]; ++k)
        for (j = 0; j < grid->size[1]; ++j)
            for (i = 0; i < grid->size[0]; ++i) {
                const float* here = &distance[clsdf_grid_offset(grid, i, j, k)];
                const float* there = &all_distances[clsdf_grid_offset(whole, i + shift, j, k)];
                count += memcmp(here, there, sizeof *here) != 0 ? 1 : 0;
            }
    return count;
}

int main(void) {
    const int64_t ranks = 3;
    clsdf_device* device;
    clsdf_mesh* mesh;
    clsdf_transform* all;
    clsdf_field* whole;
    clsdf_array all_distances;
    clsdf_box box;
    clsdf_grid domain;
    clsdf_band band;
    double side;
    int64_t rank, wrong = 0;

    check(clsdf_mesh_shape("knot", &mesh));
    check(clsdf_mesh_box(mesh, &box));
    check(clsdf_box_longest_side(&box, &side));
    band = clsdf_band_symmetric(0.03 * side);
    check(clsdf_grid_around_mesh(mesh, 100, &band, &domain));

    /* This example is one process; in a simulation every rank makes its own transform. */
    check(clsdf_device_automatic(&device));
    check(clsdf_transform_create(device, mesh, NULL, NULL, &all));
    check(clsdf_compute_field(all, &domain, &band, CLSDF_SET(CLSDF_DISTANCE), NULL, NULL, &whole));
    check(clsdf_field_array(whole, CLSDF_DISTANCE, &all_distances));
    for (rank = 0; rank < ranks; ++rank) {
        const clsdf_grid block = block_of(&domain, rank, ranks);
        clsdf_transform* transform = transform_for(&block, band.outside, device, mesh);
        clsdf_target target;
        float* distance; /* memory of the simulation */
        int64_t samples, different;
        check(clsdf_grid_sample_count(&block, &samples));
        distance = allocate((size_t)samples * sizeof *distance);
        target = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT32, distance, samples);
        check(clsdf_compute(transform, &block, &band, &target, 1, NULL, NULL));
        record(distance, (size_t)samples * sizeof *distance);

        different = differences(&block, distance, &domain, all_distances.host);
        printf("rank %ld: samples %ld to %ld of x, %ld of them different from the whole's\n", (long)rank,
               (long)block.first[0], (long)(block.first[0] + block.size[0] - 1), (long)different);
        wrong += different;
        free(distance);
        clsdf_transform_release(transform);
    }
    puts(wrong == 0 ? "as it should be" : "WRONG");
    clsdf_field_release(whole);
    clsdf_transform_release(all);
    clsdf_device_release(device);
    clsdf_mesh_release(mesh);
    return wrong == 0 ? 0 : 1;
}
