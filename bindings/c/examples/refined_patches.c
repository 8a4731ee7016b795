/* Patches of three levels of refinement: the start of a level set, or the walls of an adaptive mesh (AMR). The
 * transform says which patches the surface may cross: these are refined. Then one call computes the patches of all
 * levels, ghost samples included. */

#include "example.h"

#include <math.h>
#include <string.h>

enum { LEVELS = 3, SIDE = 16, GHOSTS = 2, RATIO = 2, OUTER = SIDE + 2 * GHOSTS, SAMPLES = OUTER * OUTER * OUTER };

/* A patch of samples at the centres of cells, with its memory in the simulation. */
typedef struct {
    float distance[SAMPLES], gradient[SAMPLES][3];
    clsdf_target targets[2];
} patch;

typedef struct {
    int64_t x, y, z; /* in patches of the level */
} place;

typedef struct {
    clsdf_grid lattice;
    place* places; /* sorted */
    int64_t count;
} level;

static int compare(const void* first, const void* second) {
    const place *a = first, *b = second;
    if (a->x != b->x) return a->x < b->x ? -1 : 1;
    if (a->y != b->y) return a->y < b->y ? -1 : 1;
    return a->z < b->z ? -1 : a->z > b->z;
}

static clsdf_grid block_at(const clsdf_grid* lattice, place at) {
    const int64_t size[3] = {SIDE, SIDE, SIDE};
    int64_t first[3];
    clsdf_grid block;
    first[0] = at.x * SIDE;
    first[1] = at.y * SIDE;
    first[2] = at.z * SIDE;
    check(clsdf_grid_block(lattice, first, size, &block));
    return block;
}

/* The coarsest level covers the mesh. */
static level first_level(const clsdf_mesh* mesh) {
    const clsdf_band all = clsdf_band_full();
    level result = {{{0, 0, 0}, {1, 1, 1}, {0, 0, 0}, {0, 0, 0}}, NULL, 0};
    int64_t counts[3];
    int axis;
    place at;
    check(clsdf_grid_around_mesh(mesh, 48, &all, &result.lattice));
    check(clsdf_grid_cell_centred(&result.lattice, &result.lattice));
    for (axis = 0; axis < 3; ++axis) counts[axis] = (result.lattice.size[axis] + SIDE - 1) / SIDE;
    result.places = allocate((size_t)(counts[0] * counts[1] * counts[2]) * sizeof *result.places);
    for (at.x = 0; at.x < counts[0]; ++at.x)
        for (at.y = 0; at.y < counts[1]; ++at.y)
            for (at.z = 0; at.z < counts[2]; ++at.z) result.places[result.count++] = at;
    return result;
}

/* The patches of the next level that lie within the given ones and that the surface may cross. */
static level next_level(const clsdf_transform* transform, const level* coarse) {
    const int64_t candidates = coarse->count * RATIO * RATIO * RATIO;
    clsdf_box* boxes = allocate((size_t)candidates * sizeof *boxes);
    uint8_t* answers = allocate((size_t)candidates);
    level result = {{{0, 0, 0}, {1, 1, 1}, {0, 0, 0}, {0, 0, 0}}, NULL, 0};
    double voxel;
    int64_t n, i = 0;
    check(clsdf_grid_refined_cells(&coarse->lattice, RATIO, &result.lattice));
    check(clsdf_grid_voxel(&result.lattice, &voxel));
    result.places = allocate((size_t)candidates * sizeof *result.places);
    for (i = 0; i < candidates; ++i) {
        const place* parent = &coarse->places[i / (RATIO * RATIO * RATIO)];
        clsdf_grid block;
        n = i % (RATIO * RATIO * RATIO);
        result.places[i].x = RATIO * parent->x + n % RATIO;
        result.places[i].y = RATIO * parent->y + n / RATIO % RATIO;
        result.places[i].z = RATIO * parent->z + n / (RATIO * RATIO);
        block = block_at(&result.lattice, result.places[i]);
        check(clsdf_grid_box(&block, &boxes[i]));
    }
    check(clsdf_classify(transform, boxes, candidates, sqrt(0.75) * voxel, answers)); /* half the diagonal of a cell */
    for (i = 0; i < candidates; ++i)
        if (answers[i] == CLSDF_WITHIN) result.places[result.count++] = result.places[i];
    qsort(result.places, (size_t)result.count, sizeof *result.places, compare);
    free(answers);
    free(boxes);
    return result;
}

/* The number of samples of the lattice that two patches share and that have different values in them. */
static int64_t differences(const clsdf_request* a, const clsdf_request* b) {
    const float *in_a = a->targets.items[0].array.host, *in_b = b->targets.items[0].array.host;
    int64_t begin[3], end[3], i, j, k, count = 0;
    int axis;
    for (axis = 0; axis < 3; ++axis) {
        const int64_t first_a = a->grid.first[axis], first_b = b->grid.first[axis];
        begin[axis] = first_a > first_b ? first_a : first_b;
        end[axis] = (first_a < first_b ? first_a : first_b) + OUTER;
    }
    for (k = begin[2]; k < end[2]; ++k)
        for (j = begin[1]; j < end[1]; ++j)
            for (i = begin[0]; i < end[0]; ++i) {
                const int64_t *f = a->grid.first, *g = b->grid.first;
                const float here = in_a[clsdf_grid_offset(&a->grid, i - f[0], j - f[1], k - f[2])];
                const float there = in_b[clsdf_grid_offset(&b->grid, i - g[0], j - g[1], k - g[2])];
                count += here != there ? 1 : 0;
            }
    return count;
}

int main(void) {
    clsdf_device* device;
    clsdf_mesh* mesh;
    clsdf_transform* transform;
    clsdf_request* requests;
    patch* patches;
    level levels[LEVELS];
    int64_t total = 0, n = 0, i, j, different = 0;
    int number;

    check(clsdf_mesh_shape("knot", &mesh));
    check(clsdf_device_automatic(&device));
    check(clsdf_transform_create(device, mesh, NULL, NULL, &transform));
    levels[0] = first_level(mesh);
    for (number = 1; number < LEVELS; ++number) levels[number] = next_level(transform, &levels[number - 1]);
    for (number = 0; number < LEVELS; ++number) total += levels[number].count;

    /* The patches of all levels in one call. Each level has its own lattice and band. */
    patches = allocate((size_t)total * sizeof *patches);
    requests = allocate((size_t)total * sizeof *requests);
    for (number = 0; number < LEVELS; ++number) {
        double voxel;
        check(clsdf_grid_voxel(&levels[number].lattice, &voxel));
        for (i = 0; i < levels[number].count; ++i, ++n) {
            clsdf_target* targets = patches[n].targets;
            const clsdf_grid inner = block_at(&levels[number].lattice, levels[number].places[i]);
            targets[0] = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT32, patches[n].distance, SAMPLES);
            targets[1] = clsdf_host_target(CLSDF_GRADIENT, CLSDF_FLOAT32, patches[n].gradient, SAMPLES);
            check(clsdf_grid_grown(&inner, GHOSTS, &requests[n].grid));
            requests[n].band = clsdf_band_symmetric(4 * voxel);
            requests[n].targets.items = targets;
            requests[n].targets.count = 2;
        }
    }
    check(clsdf_compute_requests(transform, requests, total, NULL, NULL));

    for (number = 0, n = 0; number < LEVELS; n += levels[number].count, ++number) {
        int64_t of_level = 0;
        for (i = 0; i < levels[number].count; ++i) {
            record(patches[n + i].distance, sizeof patches[n + i].distance);
            record(patches[n + i].gradient, sizeof patches[n + i].gradient);
            for (j = 0; j < levels[number].count; ++j) of_level += differences(&requests[n + i], &requests[n + j]);
        }
        printf("level %d: %ld patches of %d^3 samples, ghost samples included; %ld of their shared samples differ\n",
               number, (long)levels[number].count, OUTER, (long)of_level);
        different += of_level;
        free(levels[number].places);
        levels[number].places = NULL;
    }
    free(requests);
    free(patches);
    clsdf_transform_release(transform);
    clsdf_device_release(device);
    clsdf_mesh_release(mesh);
    return different == 0 ? 0 : 1;
}
