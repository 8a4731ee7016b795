/* Eight threads use one transform, and each has its own message. */
#include "test.h"

#include <pthread.h>

enum { THREADS = 8, POINTS = 300, ROUNDS = 20 };

typedef struct {
    const clsdf_transform* transform;
    clsdf_mesh* mesh;
    int number;
    float distance[POINTS];
} work;

static void* ask(void* argument) {
    work* own = argument;
    double(*points)[3] = allocate(POINTS * sizeof *points);
    const clsdf_array array = clsdf_host_array(CLSDF_FLOAT64, points, POINTS);
    const clsdf_target target = float_target(own->distance, POINTS);
    const clsdf_band band = clsdf_band_symmetric(0.1);
    char name[32], expected[64];
    int round, i;
    /* Ten points are answered by the calling thread, 300 by the device. */
    for (i = 0; i < POINTS; ++i) points[i][0] = points[i][1] = points[i][2] = 0.01 * i;
    snprintf(name, sizeof name, "nothing %d", own->number);
    snprintf(expected, sizeof expected, "'%s'", name);
    for (round = 0; round < ROUNDS; ++round) {
        clsdf_mesh* none;
        clsdf_grid grid;
        clsdf_array some = array;
        clsdf_target of_some = target;
        CHECK(clsdf_mesh_shape(name, &none) == CLSDF_INVALID_ARGUMENT && none == NULL);
        CHECK(strstr(clsdf_last_error(), name) != NULL);
        some.count = of_some.array.count = 10;
        CHECK(clsdf_query(own->transform, &some, HUGE_VAL, &of_some, 1, NULL, NULL) == CLSDF_OK);
        CHECK(clsdf_query(own->transform, &array, HUGE_VAL, &target, 1, NULL, NULL) == CLSDF_OK);
        clsdf_mesh_retain(own->mesh);
        CHECK(clsdf_grid_around_mesh(own->mesh, 20, &band, &grid) == CLSDF_OK);
        clsdf_mesh_release(own->mesh);
    }
    free(points);
    return NULL;
}

int main(void) {
    static work works[THREADS];
    pthread_t threads[THREADS];
    clsdf_device* device;
    clsdf_mesh* mesh;
    clsdf_transform* transform;
    int n;
    OK(clsdf_mesh_shape("torus", &mesh));
    OK(clsdf_device_automatic(&device));
    OK(clsdf_transform_create(device, mesh, NULL, NULL, &transform));
    for (n = 0; n < THREADS; ++n) {
        works[n].transform = transform;
        works[n].mesh = mesh;
        works[n].number = n;
        CHECK(pthread_create(&threads[n], NULL, ask, &works[n]) == 0);
    }
    for (n = 0; n < THREADS; ++n) CHECK(pthread_join(threads[n], NULL) == 0);
    for (n = 1; n < THREADS; ++n) CHECK(memcmp(works[0].distance, works[n].distance, sizeof works[0].distance) == 0);
    CHECK(works[0].distance[0] != 0 && clsdf_last_error()[0] == 0);
    clsdf_transform_release(transform);
    clsdf_device_release(device);
    clsdf_mesh_release(mesh);
    return 0;
}
