/* Files of fields and points: what is written is read. */
#include "test.h"

#include <clsdf_io.h>

enum { N = 10, SAMPLES = N * N * N };

static int32_t append(void* user, const clsdf_sparse_slab* slab) {
    return clsdf_sparse_writer_append(user, slab);
}

static void check_same_files(const char* a, const char* b) {
    FILE *first = fopen(a, "rb"), *second = fopen(b, "rb");
    int byte;
    long count = 0;
    CHECK(first != NULL && second != NULL);
    do {
        byte = fgetc(first);
        CHECK(byte == fgetc(second));
        ++count;
    } while (byte != EOF);
    CHECK(count > 128); /* more than a header of .npy */
    fclose(first), fclose(second);
}

/* A written sparse field is read as one. In memory, triangles count from 1. */
static void check_read_sparse(const clsdf_transform* transform, const clsdf_grid* grid, const clsdf_band* band) {
    const char* files[] = {"read.nvdb", "read.npy", "read.h5"};
    clsdf_sparse_field *field, *read;
    clsdf_sparse_slab expected = CLSDF_SPARSE_SLAB_INIT, found = CLSDF_SPARSE_SLAB_INIT;
    clsdf_field_description description = CLSDF_FIELD_DESCRIPTION_INIT;
    size_t samples;
    int n, k;
    OK(clsdf_compute_sparse_field(transform, grid, band, CLSDF_SET(CLSDF_TRIANGLE), NULL, NULL, &field));
    OK(clsdf_sparse_field_slab(field, &expected));
    samples = (size_t)expected.brick_count * CLSDF_BRICK_SAMPLES;
    for (n = 0; n < 3; ++n) {
        if (n == 0) { /* a tree has distances alone */
            clsdf_sparse_field* distances;
            OK(clsdf_compute_sparse_field(transform, grid, band, 0, NULL, NULL, &distances));
            OK(clsdf_sparse_field_write(distances, files[n]));
            clsdf_sparse_field_release(distances);
        } else {
            OK(clsdf_sparse_field_write(field, files[n]));
        }
        OK(clsdf_sparse_field_read(files[n], &read));
        OK(clsdf_sparse_field_set_index_base(read, 1));
        OK(clsdf_sparse_field_describe(read, &description));
        CHECK(description.grid.size[0] == grid->size[0] && description.band.outside == band->outside);
        OK(clsdf_sparse_field_slab(read, &found));
        CHECK(found.brick_count == expected.brick_count && found.run_count == expected.run_count);
        CHECK(found.values.count == (n == 0 ? 1 : 2));
        CHECK(memcmp(found.bricks, expected.bricks, (size_t)expected.brick_count * 24) == 0);
        CHECK(memcmp(found.inside, expected.inside, (size_t)expected.run_count * sizeof *found.inside) == 0);
        /* A tree has the background beyond the grid. */
        for (k = 0; k < found.values.count && n > 0; ++k)
            CHECK(memcmp(found.values.items[k].array.host, expected.values.items[k].array.host, samples * 4) == 0);
        clsdf_sparse_field_release(read);
    }
    read = field;
    OK(clsdf_sparse_field_read("field.npy", &read)); /* a dense one */
    CHECK(read == NULL);
    FAILS(CLSDF_UNREADABLE_INPUT, "missing.npy", clsdf_sparse_field_read("missing.npy", &read));
    FAILS(CLSDF_INVALID_ARGUMENT, "null", clsdf_sparse_field_read(NULL, &read));
    FAILS(CLSDF_INVALID_ARGUMENT, "index_base is 2", clsdf_sparse_field_set_index_base(field, 2));
    clsdf_sparse_field_release(field);
}

/* Writes a sparse field in one piece and layer by layer, and reads the dense one. */
static void check_sparse_arrays(const clsdf_transform* transform, const clsdf_grid* grid, const clsdf_band* band,
                                const clsdf_sparse_field* field, const clsdf_field* dense) {
    const char* files[2][2] = {{"sparse.npy", "layers.npy"}, {"sparse.h5", "layers.h5"}};
    const char* indices[2][2] = {{"sparse_bricks.npy", "layers_bricks.npy"},
                                 {"sparse_inside_runs.npy", "layers_inside_runs.npy"}};
    const int64_t samples = grid->size[0] * grid->size[1] * grid->size[2];
    clsdf_field_description description = CLSDF_FIELD_DESCRIPTION_INIT;
    clsdf_sparse_writer* writer;
    clsdf_field* read;
    clsdf_array expected, found;
    int64_t i;
    int n;
    OK(clsdf_sparse_field_describe(field, &description));
    OK(clsdf_field_array(dense, CLSDF_DISTANCE, &expected));
    for (n = 0; n < 2; ++n) {
        OK(clsdf_sparse_field_write(field, files[n][0]));
        OK(clsdf_sparse_writer_create(files[n][1], &description, 0, &writer));
        OK(clsdf_compute_sparse_slabs(transform, grid, band, 0, append, writer, NULL, NULL));
        OK(clsdf_sparse_writer_finish(writer));
        clsdf_sparse_writer_release(writer);
        check_same_files(files[n][0], files[n][1]);
        OK(clsdf_field_read(files[n][0], &read));
        OK(clsdf_field_array(read, CLSDF_DISTANCE, &found));
        for (i = 0; i < samples; ++i) CHECK(((const float*)found.host)[i] == ((const float*)expected.host)[i]);
        clsdf_field_release(read);
    }
    for (n = 0; n < 2; ++n) check_same_files(indices[n][0], indices[n][1]);
}

/* A file states the floor of a field, whoever made it. */
static void check_floor(void) {
    const clsdf_grid grid = {{0, 0, 0}, {1, 1, 1}, {1, 1, 1}, {0, 0, 0}};
    const float distance = -1;
    clsdf_field_description description = CLSDF_FIELD_DESCRIPTION_INIT;
    clsdf_target target;
    clsdf_field_writer* writer;
    clsdf_field* read;
    description.grid = grid;
    description.band = clsdf_band_full();
    description.floor = -0.5;
    target.output = CLSDF_DISTANCE;
    target.array = clsdf_host_array(CLSDF_FLOAT32, &distance, 1);
    FAILS(CLSDF_INVALID_ARGUMENT, "sign rule below", clsdf_field_writer_create("floor.nrrd", &description, 0, &writer));
    description.sign = CLSDF_SIGN_BELOW;
    OK(clsdf_field_writer_create("floor.nrrd", &description, 0, &writer));
    OK(clsdf_field_writer_append(writer, &target, 1, 1));
    OK(clsdf_field_writer_finish(writer));
    clsdf_field_writer_release(writer);
    OK(clsdf_field_read("floor.nrrd", &read));
    description.floor = 0;
    OK(clsdf_field_describe(read, &description));
    CHECK(description.sign == CLSDF_SIGN_BELOW && description.floor == -0.5);
    clsdf_field_release(read);
}

/* A sparse field is written as the dense one, in one piece and layer by layer. */
static void check_sparse(const clsdf_transform* transform) {
    const clsdf_band band = clsdf_band_symmetric(0.2);
    clsdf_grid grid;
    clsdf_field* dense;
    clsdf_sparse_field* field;
    clsdf_field_description description = CLSDF_FIELD_DESCRIPTION_INIT;
    clsdf_sparse_slab slab = CLSDF_SPARSE_SLAB_INIT;
    clsdf_sparse_writer* writer;
    clsdf_box box;
    clsdf_grid_options options = CLSDF_GRID_OPTIONS_INIT;
    OK(clsdf_transform_box(transform, &box));
    options.resolution = 30;
    OK(clsdf_grid_around_box(&box, &options, &grid));
    OK(clsdf_compute_field(transform, &grid, &band, 0, NULL, NULL, &dense));
    OK(clsdf_field_write(dense, "dense.nvdb"));
    OK(clsdf_compute_sparse_field(transform, &grid, &band, CLSDF_SET(CLSDF_DISTANCE), NULL, NULL, &field));
    OK(clsdf_sparse_field_write(field, "sparse.nvdb"));
    check_same_files("dense.nvdb", "sparse.nvdb");
    OK(clsdf_sparse_field_describe(field, &description));
    OK(clsdf_sparse_writer_create("layers.nvdb", &description, 0, &writer));
    OK(clsdf_compute_sparse_slabs(transform, &grid, &band, 0, append, writer, NULL, NULL));
    clsdf_sparse_writer_retain(writer);
    clsdf_sparse_writer_release(writer);
    OK(clsdf_sparse_writer_finish(writer));
    check_same_files("dense.nvdb", "layers.nvdb");
    check_sparse_arrays(transform, &grid, &band, field, dense);
    FAILS(CLSDF_INVALID_ARGUMENT, "finish", clsdf_sparse_writer_finish(writer));
    clsdf_sparse_writer_release(writer);

    OK(clsdf_sparse_writer_create("missing.nvdb", &description, 0, &writer));
    OK(clsdf_sparse_field_slab(field, &slab));
    --slab.brick_count;
    FAILS(CLSDF_INVALID_ARGUMENT, "null", clsdf_sparse_writer_append(writer, NULL));
    slab.part.size[2] -= 8;
    FAILS(CLSDF_INVALID_ARGUMENT, "not in the bricks", clsdf_sparse_writer_append(writer, &slab));
    clsdf_sparse_writer_release(writer);
    CHECK(fopen("missing.nvdb", "rb") == NULL);
    FAILS(CLSDF_UNSUPPORTED, "stores no sparse fields", clsdf_sparse_field_write(field, "sparse.nrrd"));
    FAILS(CLSDF_INVALID_ARGUMENT, "null", clsdf_sparse_field_write(NULL, "sparse.nvdb"));
    FAILS(CLSDF_INVALID_ARGUMENT, "null", clsdf_sparse_writer_create(NULL, &description, 0, &writer));
    clsdf_sparse_field_release(field);
    clsdf_field_release(dense);
}

int main(void) {
    const clsdf_band band = clsdf_band_symmetric(0.2);
    const char* names[] = {"field.nrrd", "field.npy", "field.vti", "field.h5", "slabs.nrrd"};
    const double positions[2][3] = {{1, 2, 3}, {4, 5, 6}};
    float values[2] = {0.5F, -1};
    clsdf_device* device;
    clsdf_mesh* mesh;
    clsdf_transform* transform;
    clsdf_field *field, *other;
    clsdf_field_writer* writer;
    clsdf_field_description description = CLSDF_FIELD_DESCRIPTION_INIT, read = CLSDF_FIELD_DESCRIPTION_INIT;
    clsdf_grid grid;
    clsdf_array array, from_file;
    clsdf_target targets[2];
    clsdf_points* points;
    const double* found;
    const uint32_t both = CLSDF_SET(CLSDF_DISTANCE) | CLSDF_SET(CLSDF_TRIANGLE);
    uint32_t outputs;
    int64_t count, length, n, i;
    char text[256];

    OK(clsdf_device_automatic(&device));
    OK(clsdf_mesh_shape("cube", &mesh));
    OK(clsdf_mesh_set_index_base(mesh, 1));
    OK(clsdf_transform_create(device, mesh, NULL, NULL, &transform));
    OK(clsdf_grid_around_mesh(mesh, N, &band, &grid));
    OK(clsdf_compute_field(transform, &grid, &band, both, NULL, NULL, &field));
    OK(clsdf_field_describe(field, &description));
    OK(clsdf_field_array(field, CLSDF_DISTANCE, &array));
    CHECK(array.count == SAMPLES);

    /* Slab by slab, from the caller's arrays. */
    OK(clsdf_field_writer_create(names[4], &description, both, &writer));
    OK(clsdf_field_array(field, CLSDF_TRIANGLE, &from_file));
    {
        uint32_t *triangles = from_file.host, *from_0 = allocate(SAMPLES * sizeof *from_0);
        for (n = 0; n < SAMPLES; ++n) from_0[n] = triangles[n] - 1U;
        for (n = 0; n < N; n += 5) {
            targets[0] = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT32, (float*)array.host + n * N * N, 5 * N * N);
            targets[1] = clsdf_host_target(CLSDF_TRIANGLE, CLSDF_UINT32, from_0 + n * N * N, 5 * N * N);
            OK(clsdf_field_writer_append(writer, targets, 2, 5));
        }
        free(from_0);
    }
    clsdf_field_writer_retain(writer);
    clsdf_field_writer_release(writer);
    OK(clsdf_field_writer_finish(writer));
    FAILS(CLSDF_INVALID_ARGUMENT, "", clsdf_field_writer_append(writer, targets, 2, 1));
    clsdf_field_writer_release(writer);

    for (i = 0; i < 5; ++i) {
        OK(clsdf_field_check_path(names[i], both));
        if (i < 4) OK(clsdf_field_write(field, names[i]));
        OK(clsdf_field_read(names[i], &other));
        OK(clsdf_field_outputs(other, &outputs));
        CHECK(outputs == both);
        OK(clsdf_field_describe(other, &read));
        CHECK(memcmp(&read.grid, &grid, sizeof grid) == 0 && read.band.inside == 0.2 && read.sign == description.sign);
        OK(clsdf_field_array(other, CLSDF_DISTANCE, &from_file));
        CHECK(memcmp(from_file.host, array.host, SAMPLES * sizeof(float)) == 0);
        /* Files count triangles from 0, and the field from 1. */
        {
            clsdf_array from_1;
            OK(clsdf_field_array(field, CLSDF_TRIANGLE, &from_1));
            OK(clsdf_field_array(other, CLSDF_TRIANGLE, &from_file));
            for (n = 0; n < SAMPLES; ++n) CHECK(((uint32_t*)from_file.host)[n] + 1U == ((uint32_t*)from_1.host)[n]);
        }
        clsdf_field_release(other);
    }
    OK(clsdf_field_missing_files(names[0], text, sizeof text, &length));
    CHECK(length == 0);
    CHECK(remove("field_triangle.nrrd") == 0);
    OK(clsdf_field_missing_files(names[0], text, sizeof text, &length));
    CHECK(strstr(text, "field_triangle.nrrd\n") != NULL);

    /* With groups a .vti has the group of each sample. */
    {
        static const char* const group_names[] = {"inlet", "wall"};
        static const uint32_t numbers[12] = {0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
        char* content = allocate(8192);
        FILE* file;
        OK(clsdf_mesh_set_groups(mesh, group_names, 2, numbers, 12));
        OK(clsdf_field_set_groups(field, mesh));
        OK(clsdf_field_write(field, "groups.vti"));
        file = fopen("groups.vti", "rb");
        CHECK(file != NULL);
        content[fread(content, 1, 8191, file)] = 0;
        CHECK(fclose(file) == 0 && strstr(content, "Name=\"group\"") != NULL);
        CHECK(strstr(content, "105 110 108 101 116 0 119 97 108 108 0") != NULL);
        free(content);
        OK(clsdf_mesh_set_groups(mesh, NULL, 0, NULL, 0));
        OK(clsdf_field_set_groups(field, mesh));
    }

    FAILS(CLSDF_UNSUPPORTED, "field.xyz", clsdf_field_write(field, "field.xyz"));
    FAILS(CLSDF_UNREADABLE_INPUT, "nowhere.nrrd", clsdf_field_read("nowhere.nrrd", &other));
    FAILS(CLSDF_INVALID_ARGUMENT, "null", clsdf_field_write(NULL, "x.nrrd"));
    FAILS(CLSDF_INVALID_ARGUMENT, "the handle given as a field is one of a mesh",
          clsdf_field_write((const clsdf_field*)mesh, "x.nrrd"));
    FAILS(CLSDF_INVALID_ARGUMENT, "null", clsdf_field_read(NULL, &other));
    FAILS(CLSDF_INVALID_ARGUMENT, "null", clsdf_field_writer_finish(NULL));
    OK(clsdf_field_writer_create("never.nrrd", &description, 0, &writer));
    FAILS(CLSDF_INVALID_ARGUMENT, "slices", clsdf_field_writer_append(writer, targets, 1, 0));
    FAILS(CLSDF_INVALID_ARGUMENT, "exactly 400 items", clsdf_field_writer_append(writer, targets, 1, 4));
    targets[0].array.strides[0] = 8;
    FAILS(CLSDF_INVALID_ARGUMENT, "packed", clsdf_field_writer_append(writer, targets, 1, 5));
    targets[0].array.strides[0] = 0;
    targets[0].array.type = CLSDF_FLOAT64;
    FAILS(CLSDF_INVALID_ARGUMENT, "double", clsdf_field_writer_append(writer, targets, 1, 5));
    clsdf_field_writer_release(writer);
    CHECK(fopen("never.nrrd", "rb") == NULL);

    /* A field of the caller's own values. */
    OK(clsdf_field_create(&description, 0, &other));
    OK(clsdf_field_array(other, CLSDF_DISTANCE, &from_file));
    CHECK(from_file.count == SAMPLES && from_file.type == CLSDF_FLOAT32);
    memcpy(from_file.host, array.host, SAMPLES * sizeof(float));
    OK(clsdf_field_write(other, "own.nrrd"));
    clsdf_field_release(other);

    /* Points. */
    OK(clsdf_points_check_path("points.csv"));
    targets[0] = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT32, values, 2);
    OK(clsdf_points_write(positions[0], 2, targets, 1, "points.csv", 0));
    OK(clsdf_points_read("points.csv", &points));
    OK(clsdf_points_data(points, &found, &count));
    CHECK(count == 2 && memcmp(found, positions, sizeof positions) == 0);
    clsdf_points_release(points);
    FAILS(CLSDF_UNSUPPORTED, "points.xyz", clsdf_points_check_path("points.xyz"));

    check_sparse(transform);
    check_floor();
    check_read_sparse(transform, &grid, &band);

    clsdf_field_release(field);
    clsdf_transform_release(transform);
    clsdf_device_release(device);
    clsdf_mesh_release(mesh);
    /* Nothing can be written from here on, and each call returns. */
    clsdf_abandon_unfinished_files();
    clsdf_io_abandon_unfinished_files();
    return 0;
}
