/* A solid that moves through a fixed grid: 100 steps of a rigid motion, each with a new field in the simulation's
 * memory. A motion is always that of the first positions, so no error adds up: a body that comes back to its first
 * place has its first field, byte for byte.
 *
 * moving_body [STEPS [RESOLUTION]] */

#include "example.h"

#include <math.h>
#include <string.h>

#define PI 3.14159265358979323846

/* The volume inside: a cell that the surface crosses counts by its part, which the distance tells to first order. */
static double volume(const clsdf_grid* grid, const float* distance, int64_t samples) {
    double cells = 0, voxel;
    int64_t n;
    check(clsdf_grid_voxel(grid, &voxel));
    for (n = 0; n < samples; ++n) {
        const double share = 0.5 - distance[n] / voxel;
        cells += share < 0 ? 0 : share > 1 ? 1 : share;
    }
    return cells * grid->spacing[0] * grid->spacing[1] * grid->spacing[2];
}

int main(int argument_count, char** arguments) {
    const int steps = argument_count > 1 ? atoi(arguments[1]) : 100;
    const double at_rest[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, nowhere[3] = {0, 0, 0};
    clsdf_grid_options options = CLSDF_GRID_OPTIONS_INIT;
    clsdf_kept_memory memory = CLSDF_KEPT_MEMORY_INIT;
    clsdf_device* device;
    clsdf_mesh* mesh;
    clsdf_transform* transform;
    clsdf_grid grid;
    clsdf_band band;
    clsdf_box box;
    clsdf_target target;
    double side, voxel, first_volume, largest_change = 0;
    int64_t samples;
    float *distance, *first;
    int step, axis, is_as_before;

    /* The simulation's grid, which has room for all places of the body. */
    check(clsdf_mesh_shape("knot", &mesh));
    check(clsdf_mesh_box(mesh, &box));
    check(clsdf_box_longest_side(&box, &side));
    for (axis = 0; axis < 3; ++axis) {
        box.upper[axis] = 0.8 * side;
        box.lower[axis] = -box.upper[axis];
    }
    options.resolution = argument_count > 2 ? atol(arguments[2]) : 64;
    check(clsdf_grid_around_box(&box, &options, &grid));
    check(clsdf_grid_voxel(&grid, &voxel));
    check(clsdf_grid_sample_count(&grid, &samples));
    band = clsdf_band_symmetric(3 * voxel);
    distance = allocate((size_t)samples * sizeof *distance);
    first = allocate((size_t)samples * sizeof *first);
    target = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT32, distance, samples);

    check(clsdf_device_automatic(&device));
    check(clsdf_transform_create(device, mesh, NULL, NULL, &transform));
    check(clsdf_compute(transform, &grid, &band, &target, 1, NULL, NULL));
    memcpy(first, distance, (size_t)samples * sizeof *first);
    first_volume = volume(&grid, distance, samples);
    for (step = 1; step <= steps; ++step) {
        /* Once around z, and along x and back. */
        const double angle = 2 * PI * ((double)step / steps), c = cos(angle), s = sin(angle);
        const double rotation[9] = {c, -s, 0, s, c, 0, 0, 0, 1}, translation[3] = {0.2 * s, 0, 0};
        double change;
        check(clsdf_transform_set_motion(transform, rotation, translation));
        check(clsdf_compute(transform, &grid, &band, &target, 1, NULL, NULL));
        if (step % 25 == 0) record(distance, (size_t)samples * sizeof *distance);
        change = fabs(volume(&grid, distance, samples) / first_volume - 1);
        if (change > largest_change) largest_change = change;
    }
    check(clsdf_transform_memory(transform, &memory));

    check(clsdf_transform_set_motion(transform, at_rest, nowhere));
    check(clsdf_compute(transform, &grid, &band, &target, 1, NULL, NULL));
    is_as_before = memcmp(distance, first, (size_t)samples * sizeof *first) == 0;
    printf("%d steps: the volume changes by at most %.2f%%; %.1f MB kept on the host, %.1f MB on the device\n", steps,
           100 * largest_change, 1e-6 * (double)memory.host_bytes, 1e-6 * (double)memory.device_bytes);
    printf("back at its first place, the body has %s field\n", is_as_before ? "its first" : "ANOTHER");
    free(first);
    free(distance);
    clsdf_transform_release(transform);
    clsdf_device_release(device);
    clsdf_mesh_release(mesh);
    return is_as_before && largest_change < 0.02 ? 0 : 1;
}
