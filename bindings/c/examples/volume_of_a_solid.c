/* From arrays in memory to a signed distance field, and a use of it.
 *
 * A simulation has a solid as arrays of vertices and triangles. It needs to know which of its cells are solid, the
 * solid share of a cell on the surface, and the triangle of the wall that is nearest to a fluid particle. */

#include "example.h"

#include <math.h>

#define PI 3.14159265358979323846

enum { AROUND = 120, ACROSS = 48, VERTICES = AROUND * ACROSS, TRIANGLES = 2 * VERTICES };

static double vertices[VERTICES][3];
static uint32_t triangles[TRIANGLES][3];

static uint32_t vertex(int a, int b) {
    return (uint32_t)(a % AROUND * ACROSS + b % ACROSS);
}

static void make_torus(double ring_radius, double tube_radius) {
    int i, j, v = 0, t = 0;
    for (i = 0; i < AROUND; ++i)
        for (j = 0; j < ACROSS; ++j, ++v, t += 2) {
            const double u = 2 * PI * i / AROUND, w = 2 * PI * j / ACROSS;
            const double radius = ring_radius + tube_radius * cos(w);
            vertices[v][0] = radius * cos(u);
            vertices[v][1] = radius * sin(u);
            vertices[v][2] = tube_radius * sin(w);
            triangles[t][0] = triangles[t + 1][0] = vertex(i, j);
            triangles[t][1] = vertex(i + 1, j);
            triangles[t][2] = triangles[t + 1][1] = vertex(i + 1, j + 1);
            triangles[t + 1][2] = vertex(i, j + 1);
        }
}

/* The exact volume, by the divergence theorem. */
static double exact_volume(void) {
    double six_volumes = 0;
    int t;
    for (t = 0; t < TRIANGLES; ++t) {
        const double *a = vertices[triangles[t][0]], *b = vertices[triangles[t][1]], *c = vertices[triangles[t][2]];
        six_volumes += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                       a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return six_volumes / 6;
}

static int32_t say(void* user, const char* message) {
    (void)user;
    printf("clsdf says: %s\n", message);
    return 0;
}

int main(void) {
    clsdf_mesh_arrays arrays = CLSDF_MESH_ARRAYS_INIT;
    clsdf_call_options call = CLSDF_CALL_OPTIONS_INIT;
    /* Distances up to a tenth of a unit on both sides of the surface. */
    const clsdf_band band = clsdf_band_symmetric(0.1);
    clsdf_target targets[2];
    clsdf_device* device;
    clsdf_mesh* mesh;
    clsdf_transform* transform;
    clsdf_grid grid;
    int64_t samples, n, particle, i[3];
    float* distance;
    uint32_t* triangle;
    double h, exact, by_counting = 0, by_distance = 0;
    const double place[3] = {1.45, 0, 0};
    int axis, right;

    make_torus(1.0, 0.4);
    arrays.vertices = clsdf_host_array(CLSDF_FLOAT64, vertices, VERTICES);
    arrays.triangles = clsdf_host_array(CLSDF_UINT32, triangles, TRIANGLES);
    arrays.name = "torus";
    call.log = say;

    /* A mesh is a checked copy of the arrays. One transform serves many grids. */
    check(clsdf_mesh_create(&arrays, &mesh));
    check(clsdf_device_automatic(&device));
    check(clsdf_transform_create(device, mesh, NULL, &call, &transform));

    /* 96 samples on the longest side. */
    check(clsdf_grid_around_mesh(mesh, 96, &band, &grid));
    check(clsdf_grid_sample_count(&grid, &samples));
    distance = allocate((size_t)samples * sizeof *distance);
    triangle = allocate((size_t)samples * sizeof *triangle);
    targets[0] = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT32, distance, samples);
    targets[1] = clsdf_host_target(CLSDF_TRIANGLE, CLSDF_UINT32, triangle, samples);
    check(clsdf_compute(transform, &grid, &band, targets, 2, NULL, NULL));
    record(distance, (size_t)samples * sizeof *distance);
    record(triangle, (size_t)samples * sizeof *triangle);

    /* A cell is solid if its centre is inside, in the band or beyond it. The distance gives the solid share of a cell
     * on the surface. */
    check(clsdf_grid_voxel(&grid, &h));
    for (n = 0; n < samples; ++n) {
        const double share = 0.5 - distance[n] / h;
        by_counting += distance[n] < 0 ? h * h * h : 0;
        by_distance += h * h * h * (share < 0 ? 0 : share > 1 ? 1 : share);
    }
    exact = exact_volume();
    printf("volume: %.5f by the triangles, %.5f by counting cells, %.5f by the distance\n", exact, by_counting,
           by_distance);

    /* A particle beside the tube's outer rim: its distance to the wall, and the nearest triangle. */
    for (axis = 0; axis < 3; ++axis) i[axis] = lround((place[axis] - grid.origin[axis]) / h);
    particle = clsdf_grid_offset(&grid, i[0], i[1], i[2]);
    printf("a particle %.5f from the wall, nearest to triangle %u\n", (double)distance[particle],
           (unsigned)triangle[particle]);

    right = fabs(by_counting - exact) < 0.01 * exact && fabs(by_distance - exact) < 0.001 * exact &&
            triangle[particle] < TRIANGLES;
    puts(right ? "as it should be" : "WRONG");
    free(triangle);
    free(distance);
    clsdf_transform_release(transform);
    clsdf_device_release(device);
    clsdf_mesh_release(mesh);
    return right ? 0 : 1;
}
