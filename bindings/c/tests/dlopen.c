/* A program that was not linked with clsdf loads it: dlopen LIBRARY. */
#include <clsdf.h>

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

static void* library;

/* A pointer to a function, by way of memory: C99 converts no other pointer to one. */
static void find(const char* name, void* function) {
    void* found = dlsym(library, name);
    if (found == NULL) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
    *(void**)function = found;
}

int main(int count, char** arguments) {
    int64_t (*version)(void);
    const char* (*last_error)(void);
    clsdf_status (*shape)(const char*, clsdf_mesh**);
    clsdf_status (*automatic)(clsdf_device**);
    clsdf_status (*create)(const clsdf_device*, const clsdf_mesh*, const clsdf_transform_options*,
                           const clsdf_call_options*, clsdf_transform**);
    clsdf_status (*query)(const clsdf_transform*, const clsdf_array*, double, const clsdf_target*, int64_t,
                          const clsdf_call_options*, clsdf_statistics*);
    void (*release_mesh)(clsdf_mesh*);
    void (*release_device)(clsdf_device*);
    void (*release_transform)(clsdf_transform*);
    const double point[3] = {0.5, 0.5, 0.5};
    double distance = 0;
    const clsdf_array points = clsdf_host_array(CLSDF_FLOAT64, point, 1);
    const clsdf_target target = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT64, &distance, 1);
    clsdf_mesh* mesh;
    clsdf_device* device;
    clsdf_transform* transform;

    if (count == 2) library = dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    find("clsdf_version", &version);
    find("clsdf_last_error", &last_error);
    find("clsdf_mesh_shape", &shape);
    find("clsdf_device_automatic", &automatic);
    find("clsdf_transform_create", &create);
    find("clsdf_query", &query);
    find("clsdf_mesh_release", &release_mesh);
    find("clsdf_device_release", &release_device);
    find("clsdf_transform_release", &release_transform);
    if (version() != CLSDF_VERSION || shape("cube", &mesh) != CLSDF_OK || automatic(&device) != CLSDF_OK ||
        create(device, mesh, NULL, NULL, &transform) != CLSDF_OK ||
        query(transform, &points, HUGE_VAL, &target, 1, NULL, NULL) != CLSDF_OK) {
        fprintf(stderr, "%s\n", last_error());
        return 1;
    }
    printf("the distance of its centre to a cube is %g\n", distance);
    release_transform(transform);
    release_device(device);
    release_mesh(mesh);
    return distance < 0 ? 0 : 1;
}
