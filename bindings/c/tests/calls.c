/* What each call gives: other calls of the interface must agree with it. */
#include "test.h"

enum { N = 12, SAMPLES = N * N * N };

static clsdf_device* device;
static clsdf_mesh* mesh;           /* a torus */
static clsdf_transform* transform; /* of it */
static clsdf_grid grid;            /* around it, N^3 samples */
static clsdf_band band;
static float distance[SAMPLES]; /* of the grid: what other calls are compared with */
static uint32_t triangle[SAMPLES];

static void check_devices(void) {
    clsdf_devices* list;
    clsdf_device* other;
    clsdf_device_info info = CLSDF_DEVICE_INFO_INIT, listed = CLSDF_DEVICE_INFO_INIT;
    clsdf_device_limits limits = CLSDF_DEVICE_LIMITS_INIT;
    clsdf_thread_limit *limit, *lower;
    void *context = NULL, *id = NULL, *queue = NULL, *memory = NULL;
    char text[32];
    int64_t length = 0, before = clsdf_thread_count();
    clsdf_status status;

    OK(clsdf_devices_list(&list));
    CHECK(clsdf_devices_count(list) > 0);
    FAILS(CLSDF_INVALID_ARGUMENT, "there is no device",
          clsdf_devices_describe(list, clsdf_devices_count(list), &listed));
    OK(clsdf_device_describe(device, &info));
    CHECK(info.name[0] != 0 && info.why_not[0] == 0 && info.fp64 == 1 && info.memory > 0 && info.index >= 0);
    CHECK(info.only_if_named[0] == 0);
    /* The driver's file is told if clsdf has opened it. */
    CHECK(info.source != CLSDF_DEVICE_FILE && (info.source == CLSDF_REGISTERED) == (info.driver_file[0] == 0));
    OK(clsdf_devices_describe(list, info.index, &listed));
    CHECK(strcmp(info.name, listed.name) == 0 && info.id == listed.id && info.kind == listed.kind);
    OK(clsdf_device_handles(device, &context, &id, &queue));
    CHECK(context != NULL && id == info.id && queue != NULL);
    OK(clsdf_device_from_handles(context, id, queue, &other));
    clsdf_device_release(other);
    snprintf(text, sizeof text, "%d", (int)info.index);
    OK(clsdf_device_select(text, &other));
    clsdf_device_release(other);
    OK(clsdf_device_strongest(&other));
    clsdf_device_release(other);
    clsdf_devices_release(list);

    limits.memory = 1 << 28;
    OK(clsdf_device_limited(device, &limits, &other));
    OK(clsdf_device_describe(other, &listed));
    CHECK(listed.memory == 1 << 28);
    clsdf_device_release(other);
    limits.compute_units = 1 << 20;
    status = clsdf_device_limited(device, &limits, &other);
    CHECK((status == CLSDF_INVALID_ARGUMENT || status == CLSDF_UNSUPPORTED) && other == NULL);
    OK(clsdf_device_of_rank(1, 2, &other));
    OK(clsdf_device_describe(other, &listed));
    CHECK(listed.compute_units >= 1 && listed.compute_units <= info.compute_units);
    clsdf_device_release(other);
    FAILS(CLSDF_INVALID_ARGUMENT, "rank is 2 of 2", clsdf_device_of_rank(2, 2, &other));

    OK(clsdf_device_record_folder(device, text, sizeof text, &length));
    CHECK(length == 0 && text[0] == 0);
    OK(clsdf_device_keep_records(device, "records of the C test"));
    OK(clsdf_device_record_folder(device, text, 5, &length));
    CHECK(length >= 21 && strlen(text) == 4); /* cut */
    OK(clsdf_device_forget_records(device));
    OK(clsdf_device_release_memory(device, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "descriptor -1 is not open", clsdf_device_import_memory(device, -1, 4096, &memory));
    CHECK(memory == NULL);
    OK(clsdf_device_keep_records(device, NULL));
    OK(clsdf_device_read_programs(device, ""));
    OK(clsdf_device_write_programs(device, NULL));
    OK(clsdf_default_record_folder(NULL, 0, &length));

    OK(clsdf_limit_threads(2, &limit));
    OK(clsdf_limit_threads(1, &lower));
    CHECK(clsdf_thread_count() == 1);
    clsdf_thread_limit_release(lower);
    clsdf_thread_limit_release(limit);
    CHECK(clsdf_thread_count() == before);
}

static void check_grids(void) {
    const int64_t two[3] = {2, 2, 2}, five[3] = {5, 6, 7}, minus[3] = {-3, 0, 1};
    clsdf_grid_options options = CLSDF_GRID_OPTIONS_INIT;
    clsdf_grid_division division = CLSDF_GRID_DIVISION_INIT;
    clsdf_grid other;
    clsdf_length length = {0.5, CLSDF_EXTENT, 0};
    clsdf_box box = {{0, 0, 0}, {1, 2, 4}};
    double position[3], voxel, value;
    int64_t count;
    OK(clsdf_box_longest_side(&box, &value));
    CHECK(value == 4);
    OK(clsdf_length_resolve(&length, 0.1, 8, &value));
    CHECK(value == 4);
    division.cells[0] = division.cells[1] = division.cells[2] = 8;
    OK(clsdf_grid_between(&box, &division, &other));
    CHECK(other.size[0] == 9 && other.origin[2] == 0 && other.spacing[0] == 0.125 && other.spacing[2] == 0.5);
    division.cell_centred = 1;
    OK(clsdf_grid_between(&box, &division, &other));
    CHECK(other.size[0] == 8 && other.origin[2] == 0.25);
    box.upper[2] = 0; /* a slice */
    division.cells[2] = 1;
    OK(clsdf_grid_between(&box, &division, &other));
    CHECK(other.size[2] == 1 && other.origin[2] == 0 && other.spacing[2] == 0.125 && other.origin[1] == 0.125);
    box.upper[2] = 4;
    division.samples[0] = 2;
    FAILS(CLSDF_INVALID_ARGUMENT, "give one of them", clsdf_grid_between(&box, &division, &other));
    options.spacing[0] = options.spacing[1] = options.spacing[2] = 0.5;
    options.margin.value = 1;
    options.margin.unit = CLSDF_VOXELS;
    OK(clsdf_grid_around_box(&box, &options, &other));
    CHECK(other.size[0] == 5 && other.size[1] == 7 && other.size[2] == 11 && other.origin[2] == -0.5);
    OK(clsdf_grid_voxel(&other, &voxel));
    CHECK(voxel == 0.5);
    OK(clsdf_grid_part(&other, two, two, &other));
    OK(clsdf_grid_position(&other, 1, 0, 0, position));
    CHECK(position[0] == 1 && position[2] == 0.5 && other.first[0] == 2);
    OK(clsdf_grid_box(&other, &box));
    CHECK(box.lower[0] == 0.5 && box.upper[0] == 1);
    FAILS(CLSDF_INVALID_ARGUMENT, "part", clsdf_grid_part(&other, two, two, &other));
    OK(clsdf_grid_block(&other, minus, five, &other));
    CHECK(other.first[0] == -3 && other.size[2] == 7 && clsdf_grid_offset(&other, 1, 2, 3) == 1 + 5 * (2 + 6 * 3));
    OK(clsdf_grid_grown(&other, 1, &other));
    OK(clsdf_grid_sample_count(&other, &count));
    CHECK(other.first[0] == -4 && count == 7 * 8 * 9);
    OK(clsdf_grid_refined(&other, 2, &other));
    CHECK(other.size[0] == 13 && other.spacing[0] == 0.25);
    OK(clsdf_grid_cell_centred(&other, &other));
    OK(clsdf_grid_refined_cells(&other, 2, &other));
    CHECK(other.size[0] == 26);
    OK(clsdf_grid_validate(&other));
}

static int32_t keep_message(void* user, const char* message) {
    strncat(user, message, 399 - strlen(user));
    return CLSDF_OK;
}

static int32_t end_with_7(void* user, const char* message) {
    (void)user;
    (void)message;
    return 7;
}

/* "tetrahedron.ply" and a file with an edge as one mesh. */
static void check_files(void) {
    static const char text[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nf 1 2 3\n";
    const char* paths[] = {"tetrahedron.ply", "edge.obj"};
    char messages[400] = "";
    clsdf_read_options options = CLSDF_READ_OPTIONS_INIT;
    clsdf_mesh* mesh = NULL;
    const uint32_t* indices;
    int64_t count;
    FILE* file = fopen("edge.obj", "w");
    CHECK(file != NULL && fputs(text, file) >= 0 && fclose(file) == 0);
    options.user = messages;
    options.log = keep_message;
    OK(clsdf_mesh_read_files(paths, 2, &options, &mesh));
    OK(clsdf_mesh_triangles(mesh, &indices, &count));
    CHECK(count == 5 && indices[12] == 4 && indices[14] == 6);
    CHECK(strstr(messages, "edge.obj: 1 face of fewer than three corners is skipped, the first at line 4") != NULL);
    clsdf_mesh_release(mesh);
    OK(clsdf_mesh_read_files(paths, 1, NULL, &mesh));
    clsdf_mesh_release(mesh);
    /* The second face names a vertex that does not exist. */
    file = fopen("edge.obj", "w");
    CHECK(file != NULL && fputs(text, file) >= 0 && fputs("f 1 2 9\n", file) >= 0 && fclose(file) == 0);
    FAILS(CLSDF_INVALID_MESH, "skip_bad_facets", clsdf_mesh_read_files(paths, 2, &options, &mesh));
    options.skip_bad_facets = 2;
    FAILS(CLSDF_INVALID_ARGUMENT, "skip_bad_facets is 2", clsdf_mesh_read_files(paths, 2, &options, &mesh));
    options.skip_bad_facets = 1;
    messages[0] = 0;
    OK(clsdf_mesh_read_files(paths, 2, &options, &mesh));
    OK(clsdf_mesh_triangles(mesh, &indices, &count));
    CHECK(count == 5 && strstr(messages, "left out, the first at line 6 (there is no vertex 9)") != NULL);
    clsdf_mesh_release(mesh);
    options.log = end_with_7;
    CHECK(clsdf_mesh_read_files(paths, 2, &options, &mesh) == 7);
    FAILS(CLSDF_INVALID_ARGUMENT, "no file", clsdf_mesh_read_files(NULL, 0, NULL, &mesh));
    FAILS(CLSDF_INVALID_ARGUMENT, "paths is null", clsdf_mesh_read_files(NULL, 1, NULL, &mesh));
}

/* Axes and groups of files, and groups of a mesh of four triangles. */
static void check_groups(clsdf_mesh* mesh) {
    static const char text[] = "v 0 0 0\nv 1 0 0\nv 0 2 3\ng inlet\nf 1 2 3\no wing\nf 1 3 2\n";
    const char* paths[] = {"tetrahedron.ply", "groups.obj"};
    const char* given[] = {"wall", "inlet"};
    const uint32_t given_numbers[4] = {0, 1, 0, 0}, beyond[4] = {0, 2, 0, 0};
    clsdf_read_options options = CLSDF_READ_OPTIONS_INIT;
    clsdf_mesh* other = NULL;
    const uint32_t* numbers;
    const double* positions;
    const char* name;
    int64_t count;
    FILE* file = fopen("groups.obj", "w");
    CHECK(file != NULL && fputs(text, file) >= 0 && fclose(file) == 0);
    options.up = "y";
    options.rotate[2] = 90;
    OK(clsdf_mesh_read_files(paths + 1, 1, &options, &other));
    OK(clsdf_mesh_vertices(other, &positions, &count)); /* (0, 2, 3) -> (0, -3, 2) -> (3, 0, 2) */
    CHECK(count == 3 && positions[6] == 3 && positions[7] == 0 && positions[8] == 2);
    OK(clsdf_mesh_group_count(other, &count));
    CHECK(count == 2);
    OK(clsdf_mesh_group_name(other, 1, &name));
    CHECK(strcmp(name, "wing/inlet") == 0);
    OK(clsdf_mesh_group_numbers(other, &numbers, &count));
    CHECK(count == 2 && numbers[0] == 0 && numbers[1] == 1);
    clsdf_mesh_release(other);
    options.up = "up";
    FAILS(CLSDF_INVALID_ARGUMENT, "'up' is no axis", clsdf_mesh_read_files(paths, 1, &options, &other));
    options.up = NULL;
    options.group_by = "label";
    FAILS(CLSDF_INVALID_ARGUMENT, "no property 'label'", clsdf_mesh_read_files(paths, 1, &options, &other));
    options.group_by = "red";
    OK(clsdf_mesh_read_files(paths, 1, &options, &other));
    OK(clsdf_mesh_group_name(other, 0, &name));
    CHECK(strcmp(name, "255") == 0);
    clsdf_mesh_release(other);
    OK(clsdf_mesh_read_files(paths, 2, NULL, &other));
    OK(clsdf_mesh_group_name(other, 2, &name));
    CHECK(strcmp(name, "groups/wing/inlet") == 0);
    clsdf_mesh_release(other);

    OK(clsdf_mesh_group_count(mesh, &count));
    CHECK(count == 0);
    OK(clsdf_mesh_set_groups(mesh, given, 2, given_numbers, 4));
    FAILS(CLSDF_INVALID_ARGUMENT, "triangle 1 has the group 2", clsdf_mesh_set_groups(mesh, given, 2, beyond, 4));
    FAILS(CLSDF_INVALID_ARGUMENT, "names is null", clsdf_mesh_set_groups(mesh, NULL, 2, given_numbers, 4));
    OK(clsdf_mesh_weld(mesh, &other));
    OK(clsdf_mesh_group_numbers(other, &numbers, &count));
    CHECK(count == 4 && memcmp(numbers, given_numbers, sizeof given_numbers) == 0);
    OK(clsdf_mesh_group_name(other, 1, &name));
    CHECK(strcmp(name, "inlet") == 0);
    FAILS(CLSDF_INVALID_ARGUMENT, "index is 2", clsdf_mesh_group_name(other, 2, &name));
    clsdf_mesh_release(other);
    OK(clsdf_mesh_set_groups(mesh, NULL, 0, NULL, 0));
    OK(clsdf_mesh_group_numbers(mesh, NULL, &count));
    CHECK(count == 0);
}

/* Two cubes of side 2, about (0, 0, 0) and (1, 0, 0): a bar of 3 by 2 by 2. */
static void check_outer_surface(void) {
    double vertices[16][3];
    int32_t faces[24][3];
    static const int32_t cube[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                        {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    clsdf_mesh_arrays arrays = CLSDF_MESH_ARRAYS_INIT;
    clsdf_outer_report report = CLSDF_OUTER_REPORT_INIT;
    clsdf_topology topology = CLSDF_TOPOLOGY_INIT;
    clsdf_transform_options options = CLSDF_TRANSFORM_OPTIONS_INIT;
    clsdf_transform* of_union;
    const double inside[3] = {0.5, 0, 0};
    clsdf_array point = clsdf_host_array(CLSDF_FLOAT64, inside, 1);
    clsdf_target found[2];
    double depth;
    uint32_t nearest;
    clsdf_mesh *two, *outer, *none;
    const double* positions_of_outer;
    clsdf_array same;
    const uint32_t* given;
    int64_t count, triangles;
    int i, k;
    for (i = 0; i < 16; ++i) {
        vertices[i][0] = (i & 1 ? 1 : -1) + (i < 8 ? 0 : 1);
        vertices[i][1] = i & 2 ? 1 : -1;
        vertices[i][2] = i & 4 ? 1 : -1;
    }
    for (i = 0; i < 24; ++i)
        for (k = 0; k < 3; ++k) faces[i][k] = cube[i % 12][k] + (i < 12 ? 0 : 8);
    arrays.vertices = clsdf_host_array(CLSDF_FLOAT64, vertices, 16);
    arrays.triangles = clsdf_host_array(CLSDF_INT32, faces, 24);
    CHECK(clsdf_mesh_create(&arrays, &two) == CLSDF_OK);
    CHECK(clsdf_mesh_outer(two, CLSDF_SIGN_AUTOMATIC, NULL, &outer, &report) == CLSDF_OK);
    CHECK(report.volume == 12 && report.area == 32);
    CHECK(report.whole_faces + report.partial_faces + report.hidden_faces == 24 && report.hidden_faces >= 4);
    CHECK(clsdf_mesh_triangles(outer, NULL, &triangles) == CLSDF_OK);
    CHECK(clsdf_mesh_given_faces(outer, &given, &count) == CLSDF_OK && count == triangles);
    for (i = 0; i < count; ++i) CHECK(given[i] < 24);
    CHECK(clsdf_mesh_topology(outer, &topology) == CLSDF_OK && topology.balanced && topology.overlapping_parts == 0);
    CHECK(clsdf_mesh_given_faces(two, NULL, &count) == CLSDF_OK && count == 0);
    CHECK(clsdf_mesh_outer(two, CLSDF_SIGN_BELOW, NULL, &none, NULL) == CLSDF_UNSUPPORTED && none == NULL);
    options.surface = CLSDF_SURFACE_OUTER;
    OK(clsdf_transform_create(device, two, &options, NULL, &of_union));
    found[0] = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT64, &depth, 1);
    found[1] = clsdf_host_target(CLSDF_TRIANGLE, CLSDF_UINT32, &nearest, 1);
    OK(clsdf_query(of_union, &point, 9, found, 2, NULL, NULL));
    CHECK(depth > -1 - 1e-12 && depth < -1 + 1e-12 && nearest < 24);
    OK(clsdf_transform_topology(of_union, &topology));
    CHECK(topology.hidden_faces == report.hidden_faces && topology.partial_faces == report.partial_faces);
    CHECK(clsdf_mesh_vertices(outer, &positions_of_outer, &count) == CLSDF_OK);
    same = clsdf_host_array(CLSDF_FLOAT64, positions_of_outer, count);
    CHECK(clsdf_mesh_set_positions(outer, &same) == CLSDF_OK); /* its parts may meet from now on */
    CHECK(clsdf_mesh_given_faces(outer, NULL, &count) == CLSDF_OK && count == 0);
    clsdf_transform_release(of_union);
    clsdf_mesh_release(outer);
    clsdf_mesh_release(two);
}

static void check_meshes(void) {
    const float vertices[4][4] = {{0, 0, 0, 9}, {1, 0, 0, 9}, {0, 1, 0, 9}, {0, 0, 1, 9}};
    const int64_t faces[3][4] = {{1, 1, 1, 2}, {3, 2, 4, 3}, {2, 4, 3, 4}}; /* from 1, by component */
    clsdf_mesh_arrays arrays = CLSDF_MESH_ARRAYS_INIT;
    clsdf_topology topology = CLSDF_TOPOLOGY_INIT;
    clsdf_defects defects = CLSDF_DEFECTS_INIT;
    clsdf_mesh *own, *other;
    clsdf_box box;
    const double *positions, *again;
    const uint32_t* indices;
    const uint8_t colours[12] = {255, 0, 0};
    const char* name;
    char warning[64], flat[200];
    clsdf_weld_report welded = CLSDF_WELD_REPORT_INIT;
    int64_t count, length;
    int32_t rule, base;
    uint64_t hash, other_hash;
    double moved[4][3];
    clsdf_array array;
    float moved_vertices[4][4], found;
    int64_t moved_faces[3][4], swapped;
    const double point[3] = {0, 0, 3};
    const clsdf_array at = clsdf_host_array(CLSDF_FLOAT64, point, 1);
    const clsdf_target target = float_target(&found, 1);
    clsdf_transform* of_arrays;

    arrays.vertices = clsdf_host_array(CLSDF_FLOAT32, vertices, 4);
    arrays.vertices.strides[0] = sizeof vertices[0];
    arrays.vertices.bytes = sizeof vertices;
    arrays.triangles = clsdf_host_array(CLSDF_INT64, faces, 4);
    arrays.triangles.component_stride = sizeof faces[0]; /* structure of arrays */
    arrays.index_base = 1;
    arrays.name = "tetrahedron";
    /* The arrays may go when the call returns. */
    memcpy(moved_faces, faces, sizeof faces);
    memcpy(moved_vertices, vertices, sizeof vertices);
    arrays.vertices.host = moved_vertices;
    arrays.triangles.host = moved_faces;
    OK(clsdf_transform_from_arrays(device, &arrays, NULL, NULL, &of_arrays));
    memset(moved_vertices, 0xFF, sizeof moved_vertices);
    memset(moved_faces, 0xFF, sizeof moved_faces);
    OK(clsdf_transform_box(of_arrays, &box));
    CHECK(box.upper[0] == 1 && box.upper[2] == 1);
    OK(clsdf_query(of_arrays, &at, HUGE_VAL, &target, 1, NULL, NULL));
    CHECK(found > 1.99 && found < 2.01);
    clsdf_transform_release(of_arrays);
    memcpy(moved_faces, faces, sizeof faces);
    memcpy(moved_vertices, vertices, sizeof vertices);
    OK(clsdf_mesh_create(&arrays, &own));
    OK(clsdf_mesh_triangles(own, &indices, &count));
    CHECK(count == 4 && indices[0] == 0 && indices[1] == 2 && indices[2] == 1 && indices[9] == 1 && indices[11] == 3);
    OK(clsdf_mesh_vertices(own, &positions, &count));
    CHECK(count == 4 && positions[3] == 1 && positions[11] == 1);
    OK(clsdf_mesh_index_base(own, &base));
    OK(clsdf_mesh_name(own, &name));
    CHECK(base == 1 && strcmp(name, "tetrahedron") == 0);
    OK(clsdf_mesh_topology(own, &topology));
    OK(clsdf_mesh_defects(own, &defects));
    CHECK(topology.closed == 1 && topology.balanced == 1 && topology.open_edges == 0 && defects.components == 1);
    OK(clsdf_mesh_sign(own, CLSDF_SIGN_AUTOMATIC, &rule, warning, sizeof warning, &length));
    CHECK(rule == CLSDF_SIGN_NONZERO && length == 0 && warning[0] == 0);

    OK(clsdf_mesh_write(own, "tetrahedron.ply", colours, 4));
    OK(clsdf_mesh_read("tetrahedron.ply", &other));
    OK(clsdf_mesh_triangles(other, &indices, &count));
    CHECK(count == 4 && indices[1] == 2);
    clsdf_mesh_release(other);
    FAILS(CLSDF_INVALID_ARGUMENT, "colour", clsdf_mesh_write(own, "tetrahedron.ply", colours, 3));
    check_files();
    check_groups(own);
    OK(clsdf_mesh_weld(own, &other));
    OK(clsdf_mesh_index_base(other, &base));
    CHECK(base == 1);
    OK(clsdf_mesh_hash(own, &hash));
    OK(clsdf_mesh_hash(other, &other_hash));
    CHECK(other_hash == hash);
    clsdf_mesh_release(other);
    FAILS(CLSDF_INVALID_ARGUMENT, "0 or more", clsdf_mesh_weld_within(own, -1, &other));
    FAILS(CLSDF_INVALID_ARGUMENT, "no face", clsdf_mesh_weld_within(own, 2, &other)); /* one point */
    OK(clsdf_mesh_weld_within(own, 1e-3, &other));
    OK(clsdf_mesh_vertices(other, &again, &count));
    CHECK(count == 4);
    OK(clsdf_mesh_describe_weld(own, other, &welded, warning, sizeof warning, &length));
    CHECK(welded.lost_faces == 0 && welded.coinciding_faces == 0 && length == 0 && warning[0] == 0);
    CHECK(welded.volume_before > 0.16 && welded.volume_after == welded.volume_before);
    clsdf_mesh_release(other);
    memcpy(moved, positions, sizeof moved);
    moved[3][2] = 1e-4; /* a flat tetrahedron: its tip falls onto the corner below it */
    array = clsdf_host_array(CLSDF_FLOAT64, moved, 4);
    OK(clsdf_mesh_set_positions(own, &array));
    OK(clsdf_mesh_weld_within(own, 1e-3, &other));
    OK(clsdf_mesh_describe_weld(own, other, &welded, flat, sizeof flat, NULL));
    CHECK(welded.lost_faces == 2 && welded.coinciding_faces == 2 && welded.volume_after == 0);
    CHECK(strstr(flat, "give a smaller") != NULL);
    clsdf_mesh_release(other);

    memcpy(moved, positions, sizeof moved);
    moved[3][2] = 5;
    array = clsdf_host_array(CLSDF_FLOAT64, moved, 4);
    OK(clsdf_mesh_set_positions(own, &array));
    OK(clsdf_mesh_box(own, &box));
    CHECK(box.upper[2] == 5 && box.upper[0] == 1);
    CHECK(positions[11] == 5); /* the address is still the mesh's */
    OK(clsdf_mesh_vertices(own, &again, NULL));
    CHECK(again == positions);
    OK(clsdf_mesh_hash(own, &other_hash));
    CHECK(other_hash != hash);
    array.count = 3;
    FAILS(CLSDF_INVALID_ARGUMENT, "4 vertices", clsdf_mesh_set_positions(own, &array));

    /* One face is missing. */
    arrays.triangles.count = 3;
    clsdf_mesh_release(own);
    OK(clsdf_mesh_create(&arrays, &own));
    OK(clsdf_mesh_topology(own, &topology));
    CHECK(topology.closed == 0 && topology.open_edges == 3 && topology.first_open_count == 3);
    CHECK(topology.boundary_edges == 3 && topology.parts == 0 && topology.duplicate_faces == 0);
    FAILS(CLSDF_INVALID_MESH, "edge", clsdf_mesh_sign(own, CLSDF_SIGN_PARITY, &rule, NULL, 0, NULL));
    OK(clsdf_mesh_sign(own, CLSDF_SIGN_AUTOMATIC, &rule, warning, sizeof warning, &length));
    CHECK(rule == CLSDF_SIGN_NONE && length >= (int64_t)sizeof warning && strlen(warning) == sizeof warning - 1);
    clsdf_mesh_release(own);

    /* One face looks the other way. */
    arrays.triangles.count = 4;
    memcpy(moved_faces, faces, sizeof faces);
    swapped = moved_faces[1][2];
    moved_faces[1][2] = moved_faces[2][2];
    moved_faces[2][2] = swapped;
    OK(clsdf_mesh_create(&arrays, &own));
    OK(clsdf_mesh_topology(own, &topology));
    CHECK(topology.balanced == 1 && topology.reoriented_faces == 1 && topology.parts == 1);
    clsdf_mesh_release(own);
    CHECK(clsdf_shape_count() > 10 && clsdf_shape_name(0)[0] != 0 && clsdf_shape_description(0)[0] != 0);
}

/* Other types, strides and halos get the same values, and no other byte changes. */
static void check_arrays(void) {
    enum { H = 2, M = N + 2 * H };
    static double phi[M][M][M], gradient[3][SAMPLES];
    static float packed[SAMPLES][3], of_slices[SAMPLES];
    static int32_t signed_triangle[SAMPLES];
    clsdf_target targets[3];
    int64_t i, j, k, n = 0;
    for (i = 0; i < M * M * M; ++i) (&phi[0][0][0])[i] = 77;
    targets[0] = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT64, &phi[H][H][H], 0);
    targets[0].array.strides[0] = sizeof(double);
    targets[0].array.strides[1] = sizeof phi[0][0];
    targets[0].array.strides[2] = sizeof phi[0];
    targets[1] = clsdf_host_target(CLSDF_GRADIENT, CLSDF_FLOAT64, gradient, SAMPLES);
    targets[1].array.component_stride = sizeof gradient[0];
    targets[2] = clsdf_host_target(CLSDF_TRIANGLE, CLSDF_INT32, signed_triangle, SAMPLES);
    OK(clsdf_compute(transform, &grid, &band, targets, 3, NULL, NULL));
    for (k = 0; k < N; ++k)
        for (j = 0; j < N; ++j)
            for (i = 0; i < N; ++i, ++n) {
                CHECK(phi[k + H][j + H][i + H] - distance[n] < 1e-6 && distance[n] - phi[k + H][j + H][i + H] < 1e-6);
                CHECK(signed_triangle[n] == (int32_t)triangle[n]);
                phi[k + H][j + H][i + H] = 77;
            }
    for (i = 0; i < M * M * M; ++i) CHECK((&phi[0][0][0])[i] == 77);

    targets[0] = float_target(of_slices, SAMPLES);
    targets[1] = clsdf_host_target(CLSDF_GRADIENT, CLSDF_AUTOMATIC, packed, SAMPLES);
    OK(clsdf_compute(transform, &grid, &band, targets, 2, NULL, NULL));
    CHECK(memcmp(distance, of_slices, sizeof distance) == 0);
    memset(of_slices, 0, sizeof of_slices);
    OK(clsdf_compute_distance(transform, &grid, &band, of_slices));
    CHECK(memcmp(distance, of_slices, sizeof distance) == 0);
    for (n = 0; n < SAMPLES; ++n)
        if (triangle[n] != UINT32_MAX) CHECK(packed[n][1] == (float)gradient[1][n]);

    /* From the last slice to the first. */
    targets[0].array.host = &of_slices[(N - 1) * N * N];
    targets[0].array.strides[0] = 4;
    targets[0].array.strides[1] = 4 * N;
    targets[0].array.strides[2] = -4 * N * N;
    OK(clsdf_compute(transform, &grid, &band, targets, 1, NULL, NULL));
    for (k = 0; k < N; ++k)
        CHECK(memcmp(&of_slices[k * N * N], &distance[(N - 1 - k) * N * N], N * N * sizeof(float)) == 0);
}

/* A slab of the field; or the end of the call. */
static int32_t take_slab(void* user, const clsdf_grid* part, const clsdf_target* values, int64_t count) {
    int64_t* slices = user;
    int64_t n;
    if (*slices < 0) {
        clsdf_set_last_error("the disk is full");
        return 1234;
    }
    for (n = 0; n < count; ++n) {
        const char* bytes = (values[n].output == CLSDF_DISTANCE ? (const char*)distance : (const char*)triangle);
        CHECK(values[n].output == CLSDF_DISTANCE || values[n].output == CLSDF_TRIANGLE);
        CHECK(values[n].array.count == part->size[0] * part->size[1] * part->size[2]);
        CHECK(memcmp(values[n].array.host, bytes + 4 * N * N * part->first[2], (size_t)values[n].array.bytes) == 0);
    }
    CHECK(count == 2);
    *slices += part->size[2];
    return 0;
}

static void check_many(void) {
    enum { B = 4, BLOCKS = 27, OF_BLOCK = B * B * B };
    static float of_request[2][SAMPLES], of_blocks[BLOCKS][OF_BLOCK];
    static int64_t first[BLOCKS][3];
    clsdf_request requests[2];
    clsdf_target targets[2];
    clsdf_block_set blocks = CLSDF_BLOCK_SET_INIT;
    clsdf_statistics statistics = CLSDF_STATISTICS_INIT;
    clsdf_slab_options own_thread = CLSDF_SLAB_OPTIONS_INIT;
    clsdf_field* field;
    clsdf_field_description description = CLSDF_FIELD_DESCRIPTION_INIT;
    clsdf_array array;
    clsdf_grid slabs[1];
    int64_t n, count, slices = 0;
    uint32_t outputs;
    for (n = 0; n < 2; ++n) {
        targets[n] = float_target(of_request[n], SAMPLES);
        requests[n].grid = grid;
        requests[n].band = band;
        requests[n].targets.items = &targets[n];
        requests[n].targets.count = 1;
    }
    OK(clsdf_compute_requests(transform, requests, 2, NULL, &statistics));
    CHECK(memcmp(of_request[0], distance, sizeof distance) == 0 &&
          memcmp(of_request[1], distance, sizeof distance) == 0);
    CHECK(statistics.field_seconds > 0 && statistics.slabs > 0);
    requests[1].band.outside = -1;
    FAILS(CLSDF_INVALID_ARGUMENT, "request 1 of 2: ", clsdf_compute_requests(transform, requests, 2, NULL, NULL));
    targets[1].reserved = 1;
    FAILS(CLSDF_INVALID_ARGUMENT, "request 1 of 2: ", clsdf_compute_requests(transform, requests, 2, NULL, NULL));

    for (n = 0; n < BLOCKS; ++n) {
        first[n][0] = grid.first[0] + B * (n % 3);
        first[n][1] = grid.first[1] + B * (n / 3 % 3);
        first[n][2] = grid.first[2] + B * (n / 9);
    }
    targets[0] = float_target(of_blocks[0], BLOCKS * OF_BLOCK);
    blocks.lattice = grid;
    blocks.band = band;
    blocks.size[0] = blocks.size[1] = blocks.size[2] = B;
    blocks.first = first[0];
    blocks.block_count = BLOCKS;
    blocks.targets.items = targets;
    blocks.targets.count = 1;
    OK(clsdf_compute_blocks(transform, &blocks, NULL, NULL));
    for (n = 0; n < BLOCKS * OF_BLOCK; ++n) {
        const int64_t at = n % OF_BLOCK, *block = first[n / OF_BLOCK];
        CHECK(of_blocks[n / OF_BLOCK][at] ==
              distance[clsdf_grid_offset(&grid, block[0] + at % B, block[1] + at / B % B, block[2] + at / (B * B))]);
    }
    targets[0].array.count = 5;
    targets[0].array.block_stride = sizeof of_blocks[0];
    FAILS(CLSDF_INVALID_ARGUMENT, "27 blocks have 1728 samples", clsdf_compute_blocks(transform, &blocks, NULL, NULL));

    outputs = CLSDF_SET(CLSDF_DISTANCE) | CLSDF_SET(CLSDF_TRIANGLE);
    OK(clsdf_compute_slabs(transform, &grid, &band, outputs, take_slab, &slices, NULL, NULL, NULL));
    CHECK(slices == N);
    own_thread.own_thread = 1;
    OK(clsdf_compute_slabs(transform, &grid, &band, outputs, take_slab, &slices, &own_thread, NULL, NULL));
    CHECK(slices == 2 * N);
    slices = -1;
    FAILS(1234, "the disk is full",
          clsdf_compute_slabs(transform, &grid, &band, outputs, take_slab, &slices, NULL, NULL, NULL));
    FAILS(1234, "the disk is full",
          clsdf_compute_slabs(transform, &grid, &band, outputs, take_slab, &slices, &own_thread, NULL, NULL));
    OK(clsdf_slabs_of(&grid, slabs, 1, &count));
    CHECK(count >= 1 && slabs[0].size[0] == N);

    OK(clsdf_compute_field(transform, &grid, &band, outputs, NULL, NULL, &field));
    OK(clsdf_field_outputs(field, &outputs));
    CHECK(outputs == (CLSDF_SET(CLSDF_DISTANCE) | CLSDF_SET(CLSDF_TRIANGLE)));
    OK(clsdf_field_array(field, CLSDF_TRIANGLE, &array));
    CHECK(array.count == SAMPLES && array.type == CLSDF_UINT32 && memcmp(array.host, triangle, sizeof triangle) == 0);
    OK(clsdf_field_array(field, CLSDF_SITE, &array));
    CHECK(array.host == NULL && array.count == 0);
    OK(clsdf_field_describe(field, &description));
    CHECK(memcmp(&description.grid, &grid, sizeof grid) == 0 && description.sign == CLSDF_SIGN_NONZERO);
    CHECK(strcmp(description.mesh_name, "torus") == 0 && description.band.outside == band.outside);
    clsdf_field_release(field);
}

static void check_points(void) {
    double points[4][3] = {{0, 0, 0}, {9, 9, 9}, {0, 0, 0.01}, {0, 0, 0}};
    double found[4], closest[4][3], in_place[4][3];
    float singles[4];
    uint8_t site[4], place[2];
    clsdf_array array = clsdf_host_array(CLSDF_FLOAT64, points, 4), results;
    clsdf_target targets[2];
    clsdf_box boxes[2];
    clsdf_kept_memory memory = CLSDF_KEPT_MEMORY_INIT;
    clsdf_call_options call = CLSDF_CALL_OPTIONS_INIT;
    clsdf_statistics statistics = CLSDF_STATISTICS_INIT;
    char messages[400] = "";
    int n;
    targets[0] = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT64, found, 4);
    targets[1] = clsdf_host_target(CLSDF_SITE, CLSDF_UINT8, site, 4);
    OK(clsdf_query(transform, &array, 2, targets, 2, NULL, NULL));
    CHECK(found[0] == found[3] && found[1] == 2 && site[1] == 255 && site[0] != 255 && found[0] > 0);
    /* A half width of 0: the sign alone. Targets on the points have the same bytes. */
    OK(clsdf_query(transform, &array, 0, targets, 1, NULL, NULL));
    CHECK(found[0] == 0 && found[1] == 0);
    targets[1] = clsdf_host_target(CLSDF_CLOSEST, CLSDF_FLOAT64, closest, 4);
    OK(clsdf_query(transform, &array, HUGE_VAL, targets, 2, NULL, NULL));
    OK(clsdf_query_distance(transform, &points[0][0], 4, HUGE_VAL, singles));
    for (n = 0; n < 4; ++n) CHECK(singles[n] == (float)found[n]);
    memcpy(in_place, points, sizeof points);
    array.host = in_place;
    targets[1].array.host = in_place;
    OK(clsdf_query(transform, &array, HUGE_VAL, targets, 2, NULL, NULL));
    CHECK(memcmp(in_place, closest, sizeof closest) == 0 && closest[1][0] != 9);
    array.host = points;
    targets[1] = clsdf_host_target(CLSDF_SITE, CLSDF_UINT8, site, 4);
    /* No points: nothing is written. */
    array.count = 0;
    OK(clsdf_query(transform, &array, 2, targets, 2, NULL, NULL));
    array.count = 4;
    targets[0].array.count = 3;
    FAILS(CLSDF_INVALID_ARGUMENT, "exactly 4 items", clsdf_query(transform, &array, 2, targets, 2, NULL, NULL));
    points[1][2] = HUGE_VAL;
    targets[0].array.count = 4;
    for (n = 0; n < 4; ++n) found[n] = 77;
    call.refuse_unusable_points = 1;
    FAILS(CLSDF_INVALID_ARGUMENT, "point 1, counted from 0, at",
          clsdf_query(transform, &array, 2, targets, 2, &call, NULL));
    for (n = 0; n < 4; ++n) CHECK(found[n] == 77);
    call.refuse_unusable_points = 2;
    FAILS(CLSDF_INVALID_ARGUMENT, "refuse_unusable_points is 2",
          clsdf_query(transform, &array, 2, targets, 2, &call, NULL));
    call.refuse_unusable_points = 0;
    call.user = messages;
    call.log = keep_message;
    OK(clsdf_query(transform, &array, 2, targets, 2, &call, &statistics));
    CHECK(statistics.unusable_points == 1 && found[1] != found[1] && site[1] == 255 && site[0] != 255);
    CHECK(strstr(messages, "1 of 4 points has no triangle") != NULL);
    points[1][2] = 1e30;
    OK(clsdf_query(transform, &array, 2, targets, 2, NULL, NULL));
    CHECK(found[1] == 2 && site[1] == 255);
    OK(clsdf_transform_box(transform, &boxes[0]));
    memset(&boxes[1], 0, sizeof boxes[1]); /* the hole of the torus */
    OK(clsdf_classify(transform, boxes, 2, 1e-3, place));
    CHECK(place[0] == CLSDF_WITHIN && place[1] == CLSDF_OUTSIDE);
    results = clsdf_host_array(CLSDF_FLOAT64, found, 4);
    OK(clsdf_winding(transform, &array, &results, NULL));
    CHECK(found[0] == 0 || found[0] == 1);
    results.count = 3;
    FAILS(CLSDF_INVALID_ARGUMENT, "there are 4 points", clsdf_winding(transform, &array, &results, NULL));
    OK(clsdf_transform_memory(transform, &memory));
    CHECK(memory.host_bytes > 0);
}

static void check_rays(void) {
    /* From the middle of a cube, and from its outside. */
    const double from[3][3] = {{0, 0, 0}, {-4, 0.25, 0.5}, {0, 0, 5}}, along[3][3] = {{0, 0, 2}, {2, 0, 0}, {1, 0, 0}},
                 to[3][3] = {{0, 0, 0.5}, {4, 0.25, 0.5}, {1, 0, 5}};
    const clsdf_array origins = clsdf_host_array(CLSDF_FLOAT64, from, 3),
                      directions = clsdf_host_array(CLSDF_FLOAT64, along, 3),
                      ends = clsdf_host_array(CLSDF_FLOAT64, to, 3);
    clsdf_ray_request request = CLSDF_RAY_REQUEST_INIT;
    clsdf_call_options call = CLSDF_CALL_OPTIONS_INIT;
    clsdf_statistics statistics = CLSDF_STATISTICS_INIT;
    double t[3][2];
    int32_t triangles[3][2], counts[3];
    uint8_t any[3], visible[3] = {7, 7, 7};
    clsdf_array seen = clsdf_host_array(CLSDF_UINT8, visible, 3);
    clsdf_mesh* cube;
    clsdf_transform* of_cube;
    const int32_t bases[2] = {0, 1};
    int n;
    for (n = 0; n < 2; ++n) {
        clsdf_mesh_arrays arrays = CLSDF_MESH_ARRAYS_INIT;
        uint32_t corners[12][3];
        double vertices[8][3];
        int k, i;
        static const uint32_t faces[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                              {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
        for (k = 0; k < 8; ++k)
            for (i = 0; i < 3; ++i) vertices[k][i] = (k >> i & 1) != 0 ? 1 : -1;
        for (k = 0; k < 12; ++k)
            for (i = 0; i < 3; ++i) corners[k][i] = faces[k][i] + (uint32_t)bases[n];
        arrays.vertices = clsdf_host_array(CLSDF_FLOAT64, vertices, 8);
        arrays.triangles = clsdf_host_array(CLSDF_UINT32, corners, 12);
        arrays.index_base = bases[n];
        OK(clsdf_mesh_create(&arrays, &cube));
        OK(clsdf_transform_create(device, cube, NULL, NULL, &of_cube));
        request.hits = CLSDF_WALLS;
        request.limit = HUGE_VAL;
        request.most = 2;
        request.t = clsdf_host_array(CLSDF_FLOAT64, t, 3);
        request.triangles = clsdf_host_array(CLSDF_INT32, triangles, 3);
        request.counts = clsdf_host_array(CLSDF_INT32, counts, 3);
        request.any = clsdf_host_array(CLSDF_UINT8, any, 3);
        OK(clsdf_rays(of_cube, &origins, &directions, &request, &call, &statistics));
        CHECK(t[0][0] == 0.5 && t[0][1] == HUGE_VAL && t[1][0] == 1.5 && t[1][1] == 2.5 && t[2][0] == HUGE_VAL);
        CHECK(triangles[0][0] == 2 + bases[n] && triangles[0][1] == -1 + bases[n]);
        CHECK(triangles[1][0] == 8 + bases[n] && triangles[1][1] == 11 + bases[n]);
        CHECK(counts[0] == 1 && counts[1] == 2 && counts[2] == 0 && any[0] == 1 && any[1] == 1 && any[2] == 0);
        CHECK(statistics.unusable_points == 0);
        request.hits = CLSDF_FACES;
        request.limit = 1.5;
        OK(clsdf_rays(of_cube, &origins, &directions, &request, NULL, NULL));
        CHECK(counts[0] == 1 && counts[1] == 1 && counts[2] == 0 && t[1][1] == HUGE_VAL);
        request.t.count = 4;
        FAILS(CLSDF_INVALID_ARGUMENT, "there are 3 rays, and clsdf_ray_request.t.count is 4",
              clsdf_rays(of_cube, &origins, &directions, &request, NULL, NULL));
        OK(clsdf_visible(of_cube, &origins, &ends, CLSDF_WALLS, &seen, NULL, NULL));
        CHECK(visible[0] == 1 && visible[1] == 0 && visible[2] == 1);
        clsdf_transform_release(of_cube);
        clsdf_mesh_release(cube);
    }
}

static void check_motion(void) {
    const double rest[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, turn[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1}, up[3] = {0, 0, 0.5},
                 no_rotation[9] = {2, 0, 0, 0, 1, 0, 0, 0, 1}, nowhere[3] = {0, 0, 0};
    const double turned[9] = {cos(0.3), -sin(0.3), 0, sin(0.3), cos(0.3), 0, 0, 0, 1};
    double in_floats[9], *moved;
    static float values[SAMPLES], distance_of_moved[SAMPLES];
    uint32_t* numbers;
    const clsdf_target target = float_target(values, SAMPLES);
    clsdf_transform *other, *part, *again;
    uint8_t *bytes, *memory;
    clsdf_topology topology = CLSDF_TOPOLOGY_INIT;
    clsdf_region region;
    clsdf_device* same;
    clsdf_box box;
    clsdf_array array;
    const double* positions;
    int64_t count, n;
    int32_t rule, base;
    OK(clsdf_transform_create(device, mesh, NULL, NULL, &other));
    OK(clsdf_transform_set_motion(other, turn, up));
    OK(clsdf_transform_box(other, &box));
    OK(clsdf_compute(other, &grid, &band, &target, 1, NULL, NULL));
    CHECK(memcmp(values, distance, sizeof values) != 0);
    FAILS(CLSDF_INVALID_ARGUMENT, "rotation", clsdf_transform_set_motion(other, no_rotation, up));
    for (n = 0; n < 9; ++n) in_floats[n] = (float)turned[n];
    FAILS(CLSDF_INVALID_ARGUMENT, "to 1e-12", clsdf_transform_set_motion(other, in_floats, up));
    FAILS(CLSDF_INVALID_ARGUMENT, "quaternion", clsdf_transform_set_motion(other, in_floats, up));
    OK(clsdf_transform_set_motion(other, turned, up));
    OK(clsdf_transform_set_motion(other, rest, nowhere));
    OK(clsdf_compute(other, &grid, &band, &target, 1, NULL, NULL));
    CHECK(memcmp(values, distance, sizeof values) == 0);
    OK(clsdf_mesh_vertices(mesh, &positions, &count));
    array = clsdf_host_array(CLSDF_FLOAT64, positions, count);
    OK(clsdf_transform_set_positions(other, &array, NULL));
    array.count = 7;
    FAILS(CLSDF_INVALID_ARGUMENT, "7", clsdf_transform_set_positions(other, &array, NULL));
    OK(clsdf_compute(other, &grid, &band, &target, 1, NULL, NULL));
    CHECK(memcmp(values, distance, sizeof values) == 0);

    OK(clsdf_grid_box(&grid, &region.box));
    region.half_width = band.outside;
    OK(clsdf_grid_voxel(&grid, &region.spacing));
    OK(clsdf_transform_restrict(other, &region, 1, &part));
    FAILS(CLSDF_UNSUPPORTED, "with a margin", clsdf_transform_part_vertices(part, NULL, 0, &count));
    OK(clsdf_transform_restrict_with_margin(other, &region, 1, 0.125, &again));
    OK(clsdf_transform_part_vertices(again, NULL, 0, &count));
    numbers = malloc((size_t)count * sizeof *numbers);
    moved = malloc((size_t)count * 3 * sizeof *moved);
    FAILS(CLSDF_INVALID_ARGUMENT, "has room for 7", clsdf_transform_part_vertices(again, numbers, 7, &count));
    OK(clsdf_transform_part_vertices(again, numbers, count, &count));
    for (n = 0; n < count; ++n) { /* the region is all of the mesh */
        CHECK(numbers[n] == (uint32_t)n);
        moved[3 * n] = positions[3 * n] + 0.1;
        moved[3 * n + 1] = positions[3 * n + 1];
        moved[3 * n + 2] = positions[3 * n + 2];
    }
    array = clsdf_host_array(CLSDF_FLOAT64, moved, count);
    OK(clsdf_transform_set_positions(again, &array, NULL));
    OK(clsdf_compute(again, &grid, &band, &target, 1, NULL, NULL));
    memcpy(distance_of_moved, values, sizeof values);
    OK(clsdf_transform_set_positions(other, &array, NULL));
    OK(clsdf_compute(other, &grid, &band, &target, 1, NULL, NULL));
    CHECK(memcmp(values, distance_of_moved, sizeof values) == 0 && memcmp(values, distance, sizeof values) != 0);
    moved[5] += 0.125;
    FAILS(CLSDF_INVALID_ARGUMENT, "vertex 1 of", clsdf_transform_set_positions(again, &array, NULL));
    free(numbers);
    free(moved);
    clsdf_transform_release(again);
    clsdf_transform_release(other);
    OK(clsdf_compute(part, &grid, &band, &target, 1, NULL, NULL));
    CHECK(memcmp(values, distance, sizeof values) == 0);
    FAILS(CLSDF_UNSUPPORTED, "restrict", clsdf_transform_set_motion(part, turn, up));
    OK(clsdf_transform_topology(part, &topology));
    OK(clsdf_transform_sign(part, &rule));
    OK(clsdf_transform_index_base(part, &base));
    CHECK(topology.closed == 1 && rule == CLSDF_SIGN_NONZERO && base == 0);
    OK(clsdf_transform_part_bytes(part, NULL, 0, &count));
    CHECK(count > 1000);
    bytes = malloc((size_t)count);
    FAILS(CLSDF_INVALID_ARGUMENT, "has room for 7", clsdf_transform_part_bytes(part, bytes, 7, &count));
    OK(clsdf_transform_part_bytes(part, bytes, count, &count));
    FAILS(CLSDF_INVALID_ARGUMENT, "kept_bytes", clsdf_transform_from_part(device, bytes, count, 0, -2, &again));
    OK(clsdf_transform_from_part(device, bytes, count, 0, 0, &again));
    memset(values, 0, sizeof values);
    OK(clsdf_compute(again, &grid, &band, &target, 1, NULL, NULL));
    CHECK(memcmp(values, distance, sizeof values) == 0);
    clsdf_transform_release(again);
    bytes[count - 1] ^= 1;
    FAILS(CLSDF_INVALID_ARGUMENT, "changed", clsdf_transform_from_part(device, bytes, count, 0, -1, &again));
    CHECK(again == NULL);
    free(bytes);
    FAILS(CLSDF_UNSUPPORTED, "is restricted", clsdf_transform_prepared_bytes(part, &count));
    OK(clsdf_transform_prepared_bytes(transform, &count));
    bytes = malloc((size_t)count + 64);
    memory = bytes + (64 - (uintptr_t)bytes % 64);
    FAILS(CLSDF_INVALID_ARGUMENT, "as prepared_bytes() says", clsdf_transform_share(transform, memory, count - 1));
    OK(clsdf_transform_share(transform, memory, count));
    OK(clsdf_transform_from_shared(device, memory, count, 0, 1 << 20, &again));
    memset(values, 0, sizeof values);
    OK(clsdf_compute(again, &grid, &band, &target, 1, NULL, NULL));
    CHECK(memcmp(values, distance, sizeof values) == 0);
    clsdf_transform_release(again);
    memory[count - 1] ^= 1;
    FAILS(CLSDF_INVALID_ARGUMENT, "was changed", clsdf_transform_from_shared(device, memory, count, 0, -1, &again));
    CHECK(again == NULL);
    free(bytes);
    OK(clsdf_transform_device(part, &same));
    OK(clsdf_transform_compile(part, &grid, &band, CLSDF_SET(CLSDF_CLOSEST), NULL, NULL));
    clsdf_device_release(same);
    clsdf_transform_release(part);
}

static int32_t take_slab_from_1(void* user, const clsdf_grid* part, const clsdf_target* values, int64_t count) {
    const uint32_t* from_1 = values[1].array.host;
    int64_t n, *slices = user;
    CHECK(count == 2 && values[1].output == CLSDF_TRIANGLE && values[1].array.count == N * N * part->size[2]);
    for (n = 0; n < values[1].array.count; ++n) CHECK(from_1[n] == triangle[N * N * part->first[2] + n] + 1U);
    *slices += part->size[2];
    return 0;
}

/* Without distances, the field is below 0 inside. */
static void check_exact_signs(void) {
    static float values[SAMPLES];
    clsdf_band exact = clsdf_band_signs_only();
    clsdf_target target = float_target(values, SAMPLES);
    int64_t n, inside = 0;
    exact.exact_signs = 1;
    OK(clsdf_compute(transform, &grid, &exact, &target, 1, NULL, NULL));
    for (n = 0; n < SAMPLES; ++n) {
        CHECK((values[n] < 0) == (distance[n] < 0));
        inside += values[n] < 0 ? 1 : 0;
    }
    CHECK(inside > 0 && inside < SAMPLES);
}

/* With indices from 1, triangles of outputs count from 1, and 0 is none. */
static void check_base(void) {
    static uint32_t from_1[SAMPLES], of_query[3];
    static int32_t of_blocks[2 * SAMPLES], strided[2 * SAMPLES];
    static float values[2 * SAMPLES];
    const int64_t first[2][3] = {{0, 0, 0}, {0, 0, 0}};
    const double points[3][3] = {{0, 0, 0}, {9, 9, 9}, {0.5, 0.5, 0}};
    const clsdf_array at = clsdf_host_array(CLSDF_FLOAT64, points, 3);
    clsdf_block_set blocks = CLSDF_BLOCK_SET_INIT;
    clsdf_request request;
    clsdf_target targets[2];
    clsdf_transform* of_base_1;
    clsdf_field* field;
    clsdf_array array;
    int64_t n, beyond = 0;
    OK(clsdf_mesh_set_index_base(mesh, 1));
    OK(clsdf_transform_create(device, mesh, NULL, NULL, &of_base_1));
    OK(clsdf_mesh_set_index_base(mesh, 0));
    targets[0] = float_target(values, SAMPLES);
    targets[1] = clsdf_host_target(CLSDF_TRIANGLE, CLSDF_UINT32, from_1, SAMPLES);
    OK(clsdf_compute(of_base_1, &grid, &band, targets, 2, NULL, NULL));
    for (n = 0; n < SAMPLES; ++n) {
        CHECK(from_1[n] == triangle[n] + 1U);
        beyond += from_1[n] == 0 ? 1 : 0;
    }
    CHECK(beyond > 0 && beyond < SAMPLES);

    /* Every second number of an array, backwards; the others stay. */
    for (n = 0; n < 2 * SAMPLES; ++n) strided[n] = -7;
    targets[1] = clsdf_host_target(CLSDF_TRIANGLE, CLSDF_INT32, &strided[2 * SAMPLES - 2], 0);
    targets[1].array.strides[0] = -8;
    targets[1].array.strides[1] = -8 * N;
    targets[1].array.strides[2] = -8 * N * N;
    request.grid = grid;
    request.band = band;
    request.targets.items = targets;
    request.targets.count = 2;
    OK(clsdf_compute_requests(of_base_1, &request, 1, NULL, NULL));
    for (n = 0; n < SAMPLES; ++n)
        CHECK(strided[2 * SAMPLES - 2 - 2 * n] == (int32_t)from_1[n] && strided[2 * n + 1] == -7);

    targets[0] = float_target(values, 2 * SAMPLES);
    targets[1] = clsdf_host_target(CLSDF_TRIANGLE, CLSDF_INT32, of_blocks, 2 * SAMPLES);
    blocks.lattice = grid;
    blocks.band = band;
    blocks.size[0] = blocks.size[1] = blocks.size[2] = N;
    blocks.first = first[0];
    blocks.block_count = 2;
    blocks.targets = request.targets;
    OK(clsdf_compute_blocks(of_base_1, &blocks, NULL, NULL));
    CHECK(memcmp(of_blocks, from_1, sizeof from_1) == 0);
    CHECK(memcmp(of_blocks + SAMPLES, from_1, sizeof from_1) == 0);

    targets[0] = float_target(values, 3);
    targets[1] = clsdf_host_target(CLSDF_TRIANGLE, CLSDF_UINT32, of_query, 3);
    OK(clsdf_query(of_base_1, &at, 1, targets, 2, NULL, NULL));
    CHECK(of_query[0] > 0 && of_query[1] == 0);
    targets[1] = clsdf_host_target(CLSDF_TRIANGLE, CLSDF_INT32, &strided[4], 3); /* every second one, backwards */
    targets[1].array.strides[0] = -8;
    for (n = 0; n < 5; ++n) strided[n] = -7;
    OK(clsdf_query(of_base_1, &at, 1, targets, 2, NULL, NULL));
    for (n = 0; n < 3; ++n) CHECK(strided[4 - 2 * n] == (int32_t)of_query[n]);
    CHECK(strided[1] == -7 && strided[3] == -7);
    n = 0;
    OK(clsdf_compute_slabs(of_base_1, &grid, &band, CLSDF_SET(CLSDF_DISTANCE) | CLSDF_SET(CLSDF_TRIANGLE),
                           take_slab_from_1, &n, NULL, NULL, NULL));
    CHECK(n == N);
    OK(clsdf_compute_field(of_base_1, &grid, &band, CLSDF_SET(CLSDF_TRIANGLE), NULL, NULL, &field));
    OK(clsdf_field_array(field, CLSDF_TRIANGLE, &array));
    CHECK(memcmp(array.host, from_1, sizeof from_1) == 0);
    for (n = 0; n < 2; ++n) {
        OK(clsdf_field_set_index_base(field, 0));
        CHECK(*(const uint32_t*)array.host == from_1[0] - 1);
    }
    OK(clsdf_field_set_index_base(field, 1));
    CHECK(memcmp(array.host, from_1, sizeof from_1) == 0);
    FAILS(CLSDF_INVALID_ARGUMENT, "2", clsdf_field_set_index_base(field, 2));
    clsdf_field_release(field);
    clsdf_transform_release(of_base_1);
}

typedef struct {
    int calls;
    int32_t answer;
    char message[256];
} caller;

static int32_t progressed(void* user, const clsdf_progress* progress) {
    caller* own = user;
    CHECK(progress->fraction >= 0 && progress->fraction <= 1);
    ++own->calls;
    return own->answer;
}
static int32_t stopped(void* user) {
    caller* own = user;
    ++own->calls;
    return own->answer;
}
static int32_t logged(void* user, const char* message) {
    caller* own = user;
    ++own->calls;
    snprintf(own->message, sizeof own->message, "%s", message);
    return own->answer;
}

/* Handles what fails in it, and leaves a message: neither is the call's. */
static int32_t careless(void* user, const char* message) {
    caller* own = user;
    (void)message;
    ++own->calls;
    FAILS(CLSDF_INVALID_ARGUMENT, "null", clsdf_band_validate(NULL));
    clsdf_set_last_error("a message of the program's");
    return own->answer;
}

static void check_callbacks(void) {
    const double vertices[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const uint32_t face[3] = {0, 1, 2};
    static float values[SAMPLES];
    const clsdf_target target = float_target(values, SAMPLES);
    clsdf_call_options call = CLSDF_CALL_OPTIONS_INIT;
    clsdf_mesh_arrays arrays = CLSDF_MESH_ARRAYS_INIT;
    clsdf_transform* open;
    caller own = {0, 0, ""};
    call.user = &own;
    call.progress = progressed;
    OK(clsdf_compute(transform, &grid, &band, &target, 1, &call, NULL));
    CHECK(own.calls > 0);
    own.answer = -42;
    FAILS(-42, "callback progress", clsdf_compute(transform, &grid, &band, &target, 1, &call, NULL));
    call.progress = NULL;
    call.should_stop = stopped;
    own.answer = CLSDF_CANCELLED;
    FAILS(CLSDF_CANCELLED, "should_stop", clsdf_compute(transform, &grid, &band, &target, 1, &call, NULL));
    own.answer = 1; /* as a truth value */
    FAILS(CLSDF_INVALID_MESH, "CLSDF_CANCELLED is the status",
          clsdf_compute(transform, &grid, &band, &target, 1, &call, NULL));
    own.answer = 0;
    own.calls = 0;
    OK(clsdf_compute(transform, &grid, &band, &target, 1, &call, NULL));
    CHECK(own.calls > 0 && memcmp(values, distance, sizeof values) == 0);

    arrays.vertices = clsdf_host_array(CLSDF_FLOAT64, vertices, 3);
    arrays.triangles = clsdf_host_array(CLSDF_UINT32, face, 1);
    call.should_stop = NULL;
    call.log = logged;
    own.calls = 0;
    OK(clsdf_transform_from_arrays(device, &arrays, NULL, &call, &open));
    CHECK(own.calls == 1 && strstr(own.message, "not closed") != NULL);
    clsdf_transform_release(open);
    own.answer = 5;
    FAILS(5, "callback log", clsdf_transform_from_arrays(device, &arrays, NULL, &call, &open));
    own.answer = CLSDF_OWN_STATUS + 3;
    FAILS(CLSDF_OWN_STATUS + 3, "status 1003 (the program's own)",
          clsdf_transform_from_arrays(device, &arrays, NULL, &call, &open));
    CHECK(open == NULL);
    call.log = careless;
    own.answer = 0;
    own.calls = 0;
    OK(clsdf_transform_from_arrays(device, &arrays, NULL, &call, &open)); /* and no message */
    CHECK(own.calls == 1);
    clsdf_transform_release(open);
    own.answer = CLSDF_OWN_STATUS;
    FAILS(CLSDF_OWN_STATUS, "a message of the program's",
          clsdf_transform_from_arrays(device, &arrays, NULL, &call, &open));
    CHECK(strcmp(clsdf_status_name(CLSDF_OWN_STATUS), "unknown") == 0);
}

/* Two triangles at z = 2, with a floor. */
static void check_terrain(void) {
    const double corners[4][3] = {{0, 0, 2}, {4, 0, 2}, {4, 4, 2}, {0, 4, 2}},
                 points[3][3] = {{2, 2, 1}, {2, 2, 3}, {5, 2, 1}};
    const int32_t faces[2][3] = {{0, 1, 2}, {0, 2, 3}};
    clsdf_mesh_arrays arrays = CLSDF_MESH_ARRAYS_INIT;
    clsdf_transform_options options = CLSDF_TRANSFORM_OPTIONS_INIT;
    clsdf_topology topology = CLSDF_TOPOLOGY_INIT;
    clsdf_mesh *terrain = NULL, *closed = NULL;
    clsdf_transform* below = NULL;
    float distances[3];
    const clsdf_grid column = {{1, 2, -1.5}, {1, 1, 1}, {1, 1, 5}, {0, 0, 0}};
    const int32_t direction[2][3] = {{0, 0, 1}, {0, 0, -1}};
    clsdf_link_arrays links = {0};
    uint8_t flags[2];
    int64_t count;
    int32_t rule;
    arrays.vertices = clsdf_host_array(CLSDF_FLOAT64, corners, 4);
    arrays.triangles = clsdf_host_array(CLSDF_INT32, faces, 2);
    OK(clsdf_mesh_create(&arrays, &terrain));
    OK(clsdf_mesh_topology(terrain, &topology));
    CHECK(topology.downward_faces == 0 && topology.rim_loops == 1 && topology.overlapping_rim_edges == 0);
    FAILS(CLSDF_INVALID_ARGUMENT, "lowest vertex", clsdf_mesh_close_down(terrain, 2, &closed));
    OK(clsdf_mesh_close_down(terrain, -1, &closed));
    OK(clsdf_mesh_topology(closed, &topology));
    CHECK(topology.balanced == 1 && topology.inside_out == 0);
    options.sign = CLSDF_SIGN_BELOW;
    FAILS(CLSDF_INVALID_ARGUMENT, "needs a floor", clsdf_transform_create(device, terrain, &options, NULL, &below));
    options.floor = -1;
    OK(clsdf_transform_create(device, terrain, &options, NULL, &below));
    OK(clsdf_transform_sign(below, &rule));
    OK(clsdf_query_distance(below, points[0], 3, 100, distances));
    CHECK(rule == CLSDF_SIGN_BELOW && distances[0] == -1 && distances[1] == 1 && distances[2] > 1);
    links.room = 2;
    links.flags = flags;
    OK(clsdf_links(below, &column, &direction[0][0], 2, NULL, &links, NULL, NULL, &count));
    CHECK(count == 2 && flags[0] == CLSDF_LINK_CLOSING && flags[1] == 0);
    clsdf_transform_release(below);
    clsdf_mesh_release(closed);
    clsdf_mesh_release(terrain);
}

/* A lamp on a box, above a gap and open towards it. */
static void check_detail(void) {
    static const int32_t faces[12][3] = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                                         {2, 6, 7}, {2, 7, 3}, {4, 5, 7}, {4, 7, 6}, {0, 2, 3}, {0, 3, 1}};
    double corners[16][3];
    int32_t both[22][3];
    clsdf_mesh_arrays arrays = CLSDF_MESH_ARRAYS_INIT;
    clsdf_topology topology = CLSDF_TOPOLOGY_INIT;
    clsdf_mesh* lamp = NULL;
    int i, k;
    for (i = 0; i < 16; ++i) {
        corners[i][0] = i < 8 ? 8 * (i & 1) : 1 + (i & 1);
        corners[i][1] = i < 8 ? 8 * (i >> 1 & 1) : 1 + (i >> 1 & 1);
        corners[i][2] = i < 8 ? 4 * (i >> 2 & 1) : 4.1 + 2 * (i >> 2 & 1);
    }
    for (i = 0; i < 22; ++i)
        for (k = 0; k < 3; ++k) both[i][k] = i < 12 ? faces[i][k] : faces[i - 12][k] + 8;
    arrays.vertices = clsdf_host_array(CLSDF_FLOAT64, corners, 16);
    arrays.triangles = clsdf_host_array(CLSDF_INT32, both, 22);
    OK(clsdf_mesh_create(&arrays, &lamp));
    OK(clsdf_mesh_topology(lamp, &topology));
    CHECK(topology.detail_parts == 1 && topology.detail_faces == 10 && topology.first_detail_face == 12);
    clsdf_mesh_release(lamp);
}

int main(void) {
    clsdf_target targets[2];
    CHECK(clsdf_version() == CLSDF_VERSION && strcmp(clsdf_version_text(), "0.1.0") == 0);
    CHECK(strcmp(clsdf_status_name(CLSDF_INVALID_MESH), "invalid_mesh") == 0 &&
          strcmp(clsdf_type_name(CLSDF_FLOAT64), "double") == 0 &&
          strcmp(clsdf_sign_name(CLSDF_SIGN_PARITY), "parity") == 0 &&
          strcmp(clsdf_sign_name(CLSDF_SIGN_SOLID_ANGLE), "solid-angle") == 0 &&
          strcmp(clsdf_sign_name(CLSDF_SIGN_BELOW), "below") == 0 &&
          strcmp(clsdf_device_kind_name(CLSDF_GPU), "gpu") == 0 &&
          strcmp(clsdf_device_source_name(CLSDF_UNREGISTERED), "unregistered") == 0);
    OK(clsdf_device_automatic(&device));
    check_terrain();
    check_detail();
    OK(clsdf_mesh_shape("torus", &mesh));
    OK(clsdf_transform_create(device, mesh, NULL, NULL, &transform));
    {
        clsdf_grid_options options = CLSDF_GRID_OPTIONS_INIT;
        clsdf_box box;
        double voxel;
        options.resolution = N;
        options.cubic = 1;
        OK(clsdf_mesh_box(mesh, &box));
        OK(clsdf_grid_around_box(&box, &options, &grid));
        OK(clsdf_grid_voxel(&grid, &voxel));
        band = clsdf_band_symmetric(1.5 * voxel);
    }
    targets[0] = float_target(distance, SAMPLES);
    targets[1] = clsdf_host_target(CLSDF_TRIANGLE, CLSDF_UINT32, triangle, SAMPLES);
    OK(clsdf_compute(transform, &grid, &band, targets, 2, NULL, NULL));

    check_devices();
    check_grids();
    check_meshes();
    check_outer_surface();
    check_arrays();
    check_many();
    check_points();
    check_rays();
    check_motion();
    check_exact_signs();
    check_base();
    check_callbacks();

    /* What holds a reference keeps the object. */
    clsdf_mesh_retain(mesh);
    clsdf_mesh_release(mesh);
    clsdf_device_release(device);
    OK(clsdf_compute(transform, &grid, &band, targets, 2, NULL, NULL));
    clsdf_transform_release(transform);
    clsdf_mesh_release(mesh);
    return 0;
}
