/* Particles fall on a solid and bounce. In each step one call gives the distance, the normal and the triangle of every
 * particle near the surface. The solid turns, so its vertices move between the steps.
 *
 * contact_points [PARTICLES [STEPS]] */

#include "example.h"

#include <math.h>

static double fraction(double step, int64_t i) {
    return fmod(step * (double)(i + 1), 1.0);
}

int main(int argument_count, char** arguments) {
    const int64_t count = argument_count > 1 ? atol(arguments[1]) : 20000;
    const int steps = argument_count > 2 ? atoi(arguments[2]) : 20;
    const double nowhere[3] = {0, 0, 0};
    clsdf_device* device;
    clsdf_mesh* mesh;
    clsdf_transform* transform;
    clsdf_box box;
    clsdf_array points;
    clsdf_target targets[3];
    double(*position)[3], (*velocity)[3];
    double side, radius, time;
    float *distance, (*normal)[3];
    uint32_t* triangle;
    int64_t i, contacts = 0, inside = 0;
    int step, axis;

    check(clsdf_mesh_shape("knot", &mesh));
    check(clsdf_device_automatic(&device));
    check(clsdf_transform_create(device, mesh, NULL, NULL, &transform));
    check(clsdf_mesh_box(mesh, &box));
    check(clsdf_box_longest_side(&box, &side));
    radius = 0.004 * side;
    time = 0.02 * sqrt(side);

    position = allocate((size_t)count * sizeof *position);
    velocity = allocate((size_t)count * sizeof *velocity);
    distance = allocate((size_t)count * sizeof *distance);
    normal = allocate((size_t)count * sizeof *normal);
    triangle = allocate((size_t)count * sizeof *triangle);
    /* Particles at rest above the solid, which fill a box evenly. */
    for (i = 0; i < count; ++i) {
        position[i][0] = box.lower[0] + fraction(0.8191725133961645, i) * (box.upper[0] - box.lower[0]);
        position[i][1] = box.lower[1] + fraction(0.6710436067037893, i) * (box.upper[1] - box.lower[1]);
        position[i][2] = box.upper[2] + fraction(0.5497004779019703, i) * 0.2 * (box.upper[2] - box.lower[2]);
        for (axis = 0; axis < 3; ++axis) velocity[i][axis] = 0;
    }
    points = clsdf_host_array(CLSDF_FLOAT64, position, count);
    targets[0] = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT32, distance, count);
    targets[1] = clsdf_host_target(CLSDF_TRIANGLE, CLSDF_UINT32, triangle, count);
    targets[2] = clsdf_host_target(CLSDF_GRADIENT, CLSDF_FLOAT32, normal, count);

    for (step = 0; step < steps; ++step) {
        const double c = cos(0.05 * step), s = sin(0.05 * step), rotation[9] = {c, -s, 0, s, c, 0, 0, 0, 1};
        for (i = 0; i < count; ++i) {
            velocity[i][2] -= 10 * time;
            for (axis = 0; axis < 3; ++axis) position[i][axis] += time * velocity[i][axis];
        }
        check(clsdf_transform_set_motion(transform, rotation, nowhere));
        /* In one step no particle enters the solid deeper than a few hundredths of its longest side. */
        check(clsdf_query(transform, &points, 0.1 * side, targets, 3, NULL, NULL));
        for (i = 0; i < count; ++i) {
            double speed = 0;
            if (distance[i] >= radius || triangle[i] == UINT32_MAX) continue;
            ++contacts;
            for (axis = 0; axis < 3; ++axis) speed += velocity[i][axis] * normal[i][axis];
            for (axis = 0; axis < 3; ++axis) {
                position[i][axis] += (radius - distance[i]) * normal[i][axis];
                if (speed < 0) velocity[i][axis] -= 1.5 * speed * normal[i][axis];
            }
        }
    }
    record(position, (size_t)count * sizeof *position);
    record(triangle, (size_t)count * sizeof *triangle);
    record(normal, (size_t)count * sizeof *normal);
    check(clsdf_query(transform, &points, 0.1 * side, targets, 1, NULL, NULL));
    record(distance, (size_t)count * sizeof *distance);
    for (i = 0; i < count; ++i) inside += distance[i] < 0.99 * radius ? 1 : 0;
    printf("%ld particles, %d steps: %ld contacts; %ld particles overlap the solid at the end\n", (long)count, steps,
           (long)contacts, (long)inside);
    free(triangle);
    free(normal);
    free(distance);
    free(velocity);
    free(position);
    clsdf_transform_release(transform);
    clsdf_device_release(device);
    clsdf_mesh_release(mesh);
    return contacts > 0 && inside * 100 < count ? 0 : 1;
}
