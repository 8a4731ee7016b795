/* The start of a level set method: the signed distance, its gradient and the closest point in a narrow band, from one
 * call. The distance is exact, so no reinitialisation is needed, and velocities of the surface are extended along the
 * normals by looking them up at the closest point.
 *
 * level_set_start [RESOLUTION] */

#include "example.h"

#include <math.h>

int main(int argument_count, char** arguments) {
    clsdf_grid_options options = CLSDF_GRID_OPTIONS_INIT;
    clsdf_device* device;
    clsdf_mesh* mesh;
    clsdf_transform* transform;
    clsdf_grid grid;
    clsdf_band band;
    clsdf_box box;
    clsdf_target targets[3];
    float *phi, (*normal)[3];
    double(*closest)[3];
    double voxel, fastest = 0, largest_gap = 0;
    int64_t samples, i, j, k, in_band = 0;
    int axis;

    check(clsdf_mesh_shape("knot", &mesh));
    check(clsdf_mesh_box(mesh, &box));
    options.resolution = argument_count > 1 ? atol(arguments[1]) : 96;
    options.margin.value = 4;
    options.margin.unit = CLSDF_VOXELS;
    check(clsdf_grid_around_box(&box, &options, &grid));
    check(clsdf_grid_voxel(&grid, &voxel));
    check(clsdf_grid_sample_count(&grid, &samples));
    band = clsdf_band_symmetric(4 * voxel);

    phi = allocate((size_t)samples * sizeof *phi);
    normal = allocate((size_t)samples * sizeof *normal);
    closest = allocate((size_t)samples * sizeof *closest);
    targets[0] = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT32, phi, samples);
    targets[1] = clsdf_host_target(CLSDF_CLOSEST, CLSDF_FLOAT64, closest, samples);
    targets[2] = clsdf_host_target(CLSDF_GRADIENT, CLSDF_FLOAT32, normal, samples);
    check(clsdf_device_automatic(&device));
    check(clsdf_transform_create(device, mesh, NULL, NULL, &transform));
    check(clsdf_compute(transform, &grid, &band, targets, 3, NULL, NULL));
    record(phi, (size_t)samples * sizeof *phi);
    record(closest, (size_t)samples * sizeof *closest);
    record(normal, (size_t)samples * sizeof *normal);

    for (k = 0; k < grid.size[2]; ++k)
        for (j = 0; j < grid.size[1]; ++j)
            for (i = 0; i < grid.size[0]; ++i) {
                const int64_t n = clsdf_grid_offset(&grid, i, j, k);
                double position[3], velocity[3], speed = 0, squared = 0;
                if (isnan(closest[n][0])) continue; /* beyond the band */
                ++in_band;
                /* The velocity on the surface, of a body that turns around z, carried along the normal. */
                velocity[0] = -closest[n][1];
                velocity[1] = closest[n][0];
                velocity[2] = 0;
                check(clsdf_grid_position(&grid, i, j, k, position));
                for (axis = 0; axis < 3; ++axis) {
                    const double gap = position[axis] - phi[n] * (double)normal[n][axis] - closest[n][axis];
                    speed += velocity[axis] * normal[n][axis];
                    squared += gap * gap;
                }
                if (speed > fastest) fastest = speed;
                if (sqrt(squared) / voxel > largest_gap) largest_gap = sqrt(squared) / voxel;
            }
    printf("%ld of %ld samples in the band; the largest speed along the normal is %.3f\n", (long)in_band, (long)samples,
           fastest);
    printf("position - phi * normal is the closest point within %.1e voxel\n", largest_gap);
    free(closest);
    free(normal);
    free(phi);
    clsdf_transform_release(transform);
    clsdf_device_release(device);
    clsdf_mesh_release(mesh);
    return in_band > 0 && fastest > 0 && largest_gap < 1e-4 ? 0 : 1;
}
