/* What is wrong gives a status and a message, and changes nothing. */
#include "test.h"

#include <stdlib.h>

static const char* const missing = "null";

static void check_null(void) {
    const clsdf_ray_request rays = CLSDF_RAY_REQUEST_INIT;
    const double three[3] = {0, 0, 0};
    const clsdf_band band = clsdf_band_full();
    clsdf_grid grid = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {0, 0, 0}};
    clsdf_box box = {{0, 0, 0}, {1, 1, 1}};
    clsdf_array array = CLSDF_ARRAY_INIT;
    clsdf_device* device = NULL;
    clsdf_mesh* mesh = NULL;
    clsdf_transform* transform = NULL;
    clsdf_plan* plan = NULL;
    clsdf_point_plan* point_plan = NULL;
    clsdf_field* field = NULL;
    clsdf_points* points = NULL;
    clsdf_thread_limit* limit = NULL;
    clsdf_devices* devices = NULL;
    clsdf_topology topology = CLSDF_TOPOLOGY_INIT;
    float value = 0;
    const clsdf_target target = float_target(&value, 1);
    int32_t number;
    int64_t count;
    uint64_t hash;
    const char* name;
    void* memory;

    /* Null handles may be retained and released. */
    clsdf_devices_retain(NULL), clsdf_devices_release(NULL);
    clsdf_device_retain(NULL), clsdf_device_release(NULL);
    clsdf_mesh_retain(NULL), clsdf_mesh_release(NULL);
    clsdf_transform_retain(NULL), clsdf_transform_release(NULL);
    clsdf_plan_retain(NULL), clsdf_plan_release(NULL);
    clsdf_point_plan_retain(NULL), clsdf_point_plan_release(NULL);
    clsdf_field_retain(NULL), clsdf_field_release(NULL);
    clsdf_points_retain(NULL), clsdf_points_release(NULL);
    clsdf_thread_limit_retain(NULL), clsdf_thread_limit_release(NULL);
    CHECK(clsdf_devices_count(NULL) == 0);

    /* Nothing else takes them. */
#define NULL_FAILS(call) FAILS(CLSDF_INVALID_ARGUMENT, missing, call)
    NULL_FAILS(clsdf_devices_describe(NULL, 0, NULL));
    NULL_FAILS(clsdf_devices_list(NULL));
    NULL_FAILS(clsdf_device_strongest(NULL));
    NULL_FAILS(clsdf_device_select(NULL, &device));
    NULL_FAILS(clsdf_device_from_handles(NULL, NULL, NULL, &device));
    NULL_FAILS(clsdf_device_limited(NULL, NULL, &device));
    NULL_FAILS(clsdf_device_describe(NULL, NULL));
    NULL_FAILS(clsdf_device_handles(NULL, NULL, NULL, NULL));
    NULL_FAILS(clsdf_device_keep_records(NULL, NULL));
    NULL_FAILS(clsdf_device_read_programs(NULL, NULL));
    NULL_FAILS(clsdf_device_write_programs(NULL, NULL));
    NULL_FAILS(clsdf_device_forget_records(NULL));
    NULL_FAILS(clsdf_device_release_memory(NULL, NULL));
    NULL_FAILS(clsdf_device_import_memory(NULL, 0, 1, &memory));
    NULL_FAILS(clsdf_device_record_folder(NULL, NULL, 0, NULL));
    NULL_FAILS(clsdf_mesh_create(NULL, &mesh));
    NULL_FAILS(clsdf_mesh_shape(NULL, &mesh));
    NULL_FAILS(clsdf_mesh_shape("cube", NULL));
    NULL_FAILS(clsdf_mesh_read(NULL, &mesh));
    NULL_FAILS(clsdf_mesh_weld(NULL, &mesh));
    NULL_FAILS(clsdf_mesh_weld_within(NULL, 0, &mesh));
    NULL_FAILS(clsdf_mesh_close_down(NULL, 0, &mesh));
    NULL_FAILS(clsdf_mesh_describe_weld(NULL, NULL, NULL, NULL, 0, NULL));
    NULL_FAILS(clsdf_mesh_write(NULL, "x.ply", NULL, 0));
    NULL_FAILS(clsdf_mesh_set_positions(NULL, NULL));
    NULL_FAILS(clsdf_mesh_set_index_base(NULL, 0));
    NULL_FAILS(clsdf_mesh_vertices(NULL, NULL, NULL));
    NULL_FAILS(clsdf_mesh_triangles(NULL, NULL, NULL));
    NULL_FAILS(clsdf_mesh_index_base(NULL, &number));
    NULL_FAILS(clsdf_mesh_name(NULL, &name));
    NULL_FAILS(clsdf_mesh_box(NULL, &box));
    NULL_FAILS(clsdf_mesh_hash(NULL, &hash));
    NULL_FAILS(clsdf_mesh_topology(NULL, &topology));
    NULL_FAILS(clsdf_mesh_defects(NULL, NULL));
    NULL_FAILS(clsdf_mesh_sign(NULL, 0, &number, NULL, 0, NULL));
    NULL_FAILS(clsdf_grid_around_mesh(NULL, 10, &band, &grid));
    NULL_FAILS(clsdf_grid_around_box(NULL, NULL, &grid));
    NULL_FAILS(clsdf_grid_around_box(&box, NULL, NULL));
    NULL_FAILS(clsdf_grid_between(NULL, NULL, &grid));
    NULL_FAILS(clsdf_grid_part(&grid, NULL, NULL, &grid));
    NULL_FAILS(clsdf_grid_block(NULL, NULL, NULL, &grid));
    NULL_FAILS(clsdf_grid_grown(&grid, 1, NULL));
    NULL_FAILS(clsdf_grid_refined(NULL, 2, &grid));
    NULL_FAILS(clsdf_grid_refined_cells(NULL, 2, &grid));
    NULL_FAILS(clsdf_grid_cell_centred(NULL, &grid));
    NULL_FAILS(clsdf_grid_position(&grid, 0, 0, 0, NULL));
    NULL_FAILS(clsdf_grid_box(&grid, NULL));
    NULL_FAILS(clsdf_grid_voxel(&grid, NULL));
    NULL_FAILS(clsdf_grid_sample_count(&grid, NULL));
    NULL_FAILS(clsdf_grid_validate(NULL));
    NULL_FAILS(clsdf_band_validate(NULL));
    NULL_FAILS(clsdf_box_longest_side(NULL, NULL));
    NULL_FAILS(clsdf_length_resolve(NULL, 1, 1, NULL));
    NULL_FAILS(clsdf_output_describe(0, NULL));
    NULL_FAILS(clsdf_transform_create(NULL, NULL, NULL, NULL, &transform));
    NULL_FAILS(clsdf_transform_from_arrays(NULL, NULL, NULL, NULL, &transform));
    NULL_FAILS(clsdf_transform_restrict(NULL, NULL, 0, &transform));
    NULL_FAILS(clsdf_transform_part_bytes(NULL, NULL, 0, &count));
    NULL_FAILS(clsdf_transform_prepared_bytes(NULL, &count));
    NULL_FAILS(clsdf_transform_share(NULL, NULL, 0));
    NULL_FAILS(clsdf_transform_from_shared(NULL, NULL, 0, 0, -1, &transform));
    NULL_FAILS(clsdf_transform_from_part(NULL, NULL, 0, 0, -1, &transform));
    NULL_FAILS(clsdf_transform_set_positions(NULL, &array, NULL));
    NULL_FAILS(clsdf_transform_set_motion(NULL, three, three));
    NULL_FAILS(clsdf_compute(NULL, &grid, &band, &target, 1, NULL, NULL));
    NULL_FAILS(clsdf_compute_requests(NULL, NULL, 0, NULL, NULL));
    NULL_FAILS(clsdf_compute_blocks(NULL, NULL, NULL, NULL));
    NULL_FAILS(clsdf_compute_slabs(NULL, &grid, &band, 0, NULL, NULL, NULL, NULL, NULL));
    NULL_FAILS(clsdf_compute_field(NULL, &grid, &band, 0, NULL, NULL, &field));
    NULL_FAILS(clsdf_slabs_of(NULL, NULL, 0, &count));
    NULL_FAILS(clsdf_query(NULL, &array, 1, &target, 1, NULL, NULL));
    NULL_FAILS(clsdf_classify(NULL, NULL, 0, 1, NULL));
    NULL_FAILS(clsdf_winding(NULL, &array, &array, NULL));
    NULL_FAILS(clsdf_rays(NULL, &array, &array, &rays, NULL, NULL));
    NULL_FAILS(clsdf_visible(NULL, &array, &array, CLSDF_WALLS, &array, NULL, NULL));
    NULL_FAILS(clsdf_transform_box(NULL, &box));
    NULL_FAILS(clsdf_transform_topology(NULL, &topology));
    NULL_FAILS(clsdf_transform_sign(NULL, &number));
    NULL_FAILS(clsdf_transform_index_base(NULL, &number));
    NULL_FAILS(clsdf_transform_device(NULL, &device));
    NULL_FAILS(clsdf_transform_memory(NULL, NULL));
    NULL_FAILS(clsdf_transform_compile(NULL, &grid, &band, 0, NULL, NULL));
    NULL_FAILS(clsdf_plan_create(NULL, &grid, &band, 0, NULL, &plan));
    NULL_FAILS(clsdf_plan_create_requests(NULL, NULL, 0, NULL, &plan));
    NULL_FAILS(clsdf_plan_create_blocks(NULL, NULL, NULL, &plan));
    NULL_FAILS(clsdf_plan_bytes_requests(NULL, NULL, 0, NULL, &count));
    NULL_FAILS(clsdf_plan_bytes_blocks(NULL, NULL, NULL, &count));
    NULL_FAILS(clsdf_plan_enqueue(NULL, NULL, NULL, 0, NULL));
    NULL_FAILS(clsdf_plan_enqueue_to(NULL, NULL, NULL, 0, NULL, 0, NULL));
    NULL_FAILS(clsdf_plan_update(NULL, NULL, NULL));
    NULL_FAILS(clsdf_plan_update_grids(NULL, NULL, NULL, 0, NULL));
    NULL_FAILS(clsdf_plan_update_requests(NULL, NULL, NULL, 0, NULL));
    NULL_FAILS(clsdf_plan_update_blocks(NULL, NULL, NULL, NULL));
    NULL_FAILS(clsdf_plan_sign(NULL, &number));
    NULL_FAILS(clsdf_plan_statistics(NULL, NULL));
    NULL_FAILS(clsdf_plan_request_count(NULL, &count));
    NULL_FAILS(clsdf_plan_request(NULL, 0, NULL, NULL, NULL, 0, NULL));
    NULL_FAILS(clsdf_point_plan_create(NULL, 1, 1, 0, NULL, &point_plan));
    NULL_FAILS(clsdf_point_plan_enqueue(NULL, NULL, &array, &target, 1, NULL, NULL, 0, NULL));
    NULL_FAILS(clsdf_point_plan_update(NULL, NULL, NULL));
    NULL_FAILS(clsdf_point_plan_count(NULL, &count));
    NULL_FAILS(clsdf_point_plan_sign(NULL, &number));
    NULL_FAILS(clsdf_point_plan_statistics(NULL, NULL));
    NULL_FAILS(clsdf_field_create(NULL, 0, &field));
    NULL_FAILS(clsdf_field_describe(NULL, NULL));
    NULL_FAILS(clsdf_field_outputs(NULL, NULL));
    NULL_FAILS(clsdf_field_array(NULL, 0, &array));
    NULL_FAILS(clsdf_field_set_index_base(NULL, 0));
    NULL_FAILS(clsdf_points_read(NULL, &points));
    NULL_FAILS(clsdf_points_data(NULL, NULL, NULL));
    NULL_FAILS(clsdf_points_write(NULL, 1, NULL, 0, "x.csv", 0));
    NULL_FAILS(clsdf_points_check_path(NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "threads", clsdf_limit_threads(0, &limit));
    CHECK(device == NULL && mesh == NULL && transform == NULL && plan == NULL && point_plan == NULL && field == NULL &&
          points == NULL && limit == NULL && devices == NULL);
}

static void check_wrong_handles(const clsdf_device* device, const clsdf_mesh* mesh) {
    clsdf_device* made = NULL;
    clsdf_transform* transform = (clsdf_transform*)&made;
    clsdf_box box;
    FAILS(CLSDF_INVALID_ARGUMENT, "the handle given as a device is one of a mesh",
          clsdf_device_limited((const clsdf_device*)mesh, NULL, &made));
    FAILS(CLSDF_INVALID_ARGUMENT, "the handle given as a mesh is one of a device",
          clsdf_mesh_box((const clsdf_mesh*)device, &box));
    FAILS(CLSDF_INVALID_ARGUMENT, "transform", clsdf_transform_box((const clsdf_transform*)mesh, &box));
    FAILS(CLSDF_INVALID_ARGUMENT, "one of a device",
          clsdf_transform_create(device, (const clsdf_mesh*)device, NULL, NULL, &transform));
    CHECK(transform == NULL);
}

/* Sizes of structs. */
static void check_sizes(const clsdf_device* device, const clsdf_mesh* mesh) {
    struct {
        clsdf_transform_options known;
        uint64_t later[2];
    } larger = {CLSDF_TRANSFORM_OPTIONS_INIT, {0, 0}};
    struct {
        clsdf_defects known;
        uint64_t later[2];
    } result = {CLSDF_DEFECTS_INIT, {7, 7}};
    clsdf_transform_options options = CLSDF_TRANSFORM_OPTIONS_INIT;
    clsdf_call_options call = CLSDF_CALL_OPTIONS_INIT;
    clsdf_defects defects = CLSDF_DEFECTS_INIT;
    clsdf_transform* transform;
    size_t size;
    /* Nonsense, as of memory that was not set. */
    const size_t wrong[] = {0, 1, 7, sizeof(size_t), 23, 1 << 20, (size_t)-1};
    for (size = 0; size < sizeof wrong / sizeof *wrong; ++size) {
        options.struct_size = wrong[size];
        FAILS(CLSDF_INVALID_ARGUMENT, "clsdf_transform_options.struct_size is",
              clsdf_transform_create(device, mesh, &options, NULL, &transform));
        defects.struct_size = wrong[size];
        FAILS(CLSDF_INVALID_ARGUMENT, "clsdf_defects.struct_size is", clsdf_mesh_defects(mesh, &defects));
    }
    call.struct_size = 4;
    FAILS(CLSDF_INVALID_ARGUMENT, "clsdf_call_options.struct_size is 4",
          clsdf_transform_create(device, mesh, NULL, &call, &transform));

    /* Of a later version: with nothing that this one does not know, it works. */
    larger.known.struct_size = sizeof larger;
    OK(clsdf_transform_create(device, mesh, &larger.known, NULL, &transform));
    clsdf_transform_release(transform);
    larger.later[1] = 1;
    FAILS(CLSDF_INVALID_ARGUMENT, "is not 0", clsdf_transform_create(device, mesh, &larger.known, NULL, &transform));
    /* Results that this version does not know are 0. */
    result.known.struct_size = CLSDF_RESULT_SIZE(result);
    OK(clsdf_mesh_defects(mesh, &result.known));
    CHECK(result.known.components > 0 && result.later[0] == 0 && result.later[1] == 0);
    CHECK(result.known.struct_size == CLSDF_RESULT_SIZE(result));

    /* Of an older version: members that it does not have are not read or written. */
    options.struct_size = 16; /* without kept_bytes */
    options.sign = CLSDF_SIGN_NONE;
    options.kept_bytes = -77;
    OK(clsdf_transform_create(device, mesh, &options, NULL, &transform));
    clsdf_transform_release(transform);
    defects.struct_size = 24 + 1;
    defects.components = -5;
    OK(clsdf_mesh_defects(mesh, &defects));
    CHECK(defects.components == -5 && defects.duplicate_faces == 0);
}

/* The last two arguments in the wrong order: neither struct is read or written as the other. */
static void check_order(const clsdf_transform* transform, const clsdf_grid* grid, const clsdf_band* band) {
    static float values[125];
    const clsdf_target target = float_target(values, 125);
    clsdf_call_options call = CLSDF_CALL_OPTIONS_INIT;
    clsdf_statistics statistics = CLSDF_STATISTICS_INIT;
    void* const address = values;
    call.user = address;
    values[0] = 77;
    FAILS(CLSDF_INVALID_ARGUMENT, "that of a struct that calls read",
          clsdf_compute(transform, grid, band, &target, 1, NULL, (clsdf_statistics*)(void*)&call));
    CHECK(call.user == address && values[0] == 77);
    FAILS(CLSDF_INVALID_ARGUMENT, "that of a struct that calls fill",
          clsdf_compute(transform, grid, band, &target, 1, (const clsdf_call_options*)(void*)&statistics, NULL));
    OK(clsdf_compute(transform, grid, band, &target, 1, &call, &statistics));
}

/* A count that is not that of the samples or points is refused, whatever the layout, and nothing is written. */
static void check_counts(const clsdf_transform* transform, const clsdf_grid* grid, const clsdf_band* band) {
    enum { SAMPLES = 125, POINTS = 100 };
    static float values[3 * 2 * SAMPLES], normals[3 * SAMPLES];
    static double points[POINTS][3];
    const clsdf_array at = clsdf_host_array(CLSDF_FLOAT64, points, POINTS);
    clsdf_target targets[2];
    int64_t n;
    for (n = 0; n < 3 * 2 * SAMPLES; ++n) values[n] = 77;
    targets[0] = float_target(values, 10);
    targets[0].array.strides[0] = 8;
    FAILS(CLSDF_INVALID_ARGUMENT, "100 points, and the array of the output distance has 10; give it exactly 100 items",
          clsdf_query(transform, &at, 1, targets, 1, NULL, NULL));
    targets[0].array.strides[0] = 0;
    targets[0].array.offset = 4;
    FAILS(CLSDF_INVALID_ARGUMENT, "exactly 125 items", clsdf_compute(transform, grid, band, targets, 1, NULL, NULL));
    targets[0] = float_target(values, SAMPLES);
    targets[1] = clsdf_host_target(CLSDF_GRADIENT, CLSDF_FLOAT32, normals, 10);
    targets[1].array.component_stride = 4 * SAMPLES;
    FAILS(CLSDF_INVALID_ARGUMENT, "output gradient has 10",
          clsdf_compute(transform, grid, band, targets, 2, NULL, NULL));
    targets[0].array.strides[0] = 8;
    targets[0].array.strides[1] = 40;
    targets[0].array.strides[2] = 200;
    targets[0].array.count = SAMPLES + 1;
    FAILS(CLSDF_INVALID_ARGUMENT, "exactly 125 items", clsdf_compute(transform, grid, band, targets, 1, NULL, NULL));
    for (n = 0; n < 3 * 2 * SAMPLES; ++n) CHECK(values[n] == 77);
    targets[0].array.count = SAMPLES;
    targets[1].array.count = SAMPLES;
    OK(clsdf_compute(transform, grid, band, targets, 2, NULL, NULL));
    for (n = 0; n < 2 * SAMPLES; ++n) CHECK((values[n] == 77) == (n % 2 == 1));
}

static void check_numbers(const clsdf_device* device, clsdf_mesh* mesh) {
    clsdf_ray_request rays = CLSDF_RAY_REQUEST_INIT;
    clsdf_transform_options options = CLSDF_TRANSFORM_OPTIONS_INIT;
    clsdf_output_info info = CLSDF_OUTPUT_INFO_INIT;
    clsdf_grid_options around = CLSDF_GRID_OPTIONS_INIT;
    clsdf_call_options call = CLSDF_CALL_OPTIONS_INIT;
    clsdf_mesh_arrays arrays = CLSDF_MESH_ARRAYS_INIT;
    clsdf_transform* transform;
    clsdf_mesh* none;
    clsdf_field* field;
    clsdf_band band = clsdf_band_full();
    clsdf_grid grid = {{-1, -1, -1}, {0.5, 0.5, 0.5}, {5, 5, 5}, {0, 0, 0}};
    clsdf_box box = {{0, 0, 0}, {1, 1, 1}};
    clsdf_target targets[2];
    float values[125];
    uint8_t place;
    double vertices[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    uint32_t triangle[3] = {0, 1, 2};
    double point[3] = {0, 0, 0};
    clsdf_array points = clsdf_host_array(CLSDF_FLOAT64, point, 1);
    int32_t n;

    for (n = -1; n <= 6; n += 7) {
        options.sign = n;
        FAILS(CLSDF_INVALID_ARGUMENT, "clsdf_transform_options.sign is",
              clsdf_transform_create(device, mesh, &options, NULL, &transform));
    }
    options.sign = 0;
    options.kept_bytes = -2;
    FAILS(CLSDF_INVALID_ARGUMENT, "kept_bytes is -2", clsdf_transform_create(device, mesh, &options, NULL, &transform));
    options.kept_bytes = -1;
    options.surface = 2;
    FAILS(CLSDF_INVALID_ARGUMENT, "clsdf_transform_options.surface is",
          clsdf_transform_create(device, mesh, &options, NULL, &transform));
    FAILS(CLSDF_INVALID_ARGUMENT, "output", clsdf_output_describe(-1, &info));
    FAILS(CLSDF_INVALID_ARGUMENT, "output", clsdf_output_describe((int32_t)clsdf_output_count(), &info));
    around.margin.unit = 3;
    FAILS(CLSDF_INVALID_ARGUMENT, "clsdf_length.unit is 3", clsdf_grid_around_box(&box, &around, &grid));
    around.margin.unit = CLSDF_EXTENT;
    around.cubic = 2;
    FAILS(CLSDF_INVALID_ARGUMENT, "cubic is 2", clsdf_grid_around_box(&box, &around, &grid));
    FAILS(CLSDF_INVALID_ARGUMENT, "index_base is 2", clsdf_mesh_set_index_base(mesh, 2));
    CHECK(strcmp(clsdf_status_name(77), "unknown") == 0 && strcmp(clsdf_type_name(-3), "unknown") == 0 &&
          strcmp(clsdf_sign_name(9), "unknown") == 0 && strcmp(clsdf_device_kind_name(9), "unknown") == 0 &&
          strcmp(clsdf_device_source_name(9), "unknown") == 0);
    CHECK(clsdf_shape_name(-1) == NULL && clsdf_shape_description(clsdf_shape_count()) == NULL);

    OK(clsdf_transform_create(device, mesh, NULL, NULL, &transform));
    targets[0] = targets[1] = float_target(values, 125);
    FAILS(CLSDF_INVALID_ARGUMENT, "distance", clsdf_compute(transform, &grid, &band, targets, 2, NULL, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "distance", clsdf_compute(transform, &grid, &band, NULL, 0, NULL, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "count", clsdf_compute(transform, &grid, &band, targets, -1, NULL, NULL));
    targets[0].output = 99;
    FAILS(CLSDF_INVALID_ARGUMENT, "99", clsdf_compute(transform, &grid, &band, targets, 1, NULL, NULL));
    targets[0] = float_target(values, 124);
    FAILS(CLSDF_INVALID_ARGUMENT, "125", clsdf_compute(transform, &grid, &band, targets, 1, NULL, NULL));
    check_counts(transform, &grid, &band);
    check_order(transform, &grid, &band);
    targets[0] = float_target(values, 125);
    targets[0].array.type = 8;
    FAILS(CLSDF_INVALID_ARGUMENT, "clsdf_array.type is 8",
          clsdf_compute(transform, &grid, &band, targets, 1, NULL, NULL));
    targets[0].array.type = CLSDF_UINT8;
    FAILS(CLSDF_UNSUPPORTED, "distance", clsdf_compute(transform, &grid, &band, targets, 1, NULL, NULL));
    targets[0] = float_target(values, 125);
    targets[0].array.offset = -4;
    FAILS(CLSDF_INVALID_ARGUMENT, "offset", clsdf_compute(transform, &grid, &band, targets, 1, NULL, NULL));
    targets[0].array.offset = 0;
    band.signs_only = 3;
    FAILS(CLSDF_INVALID_ARGUMENT, "signs_only is 3", clsdf_compute(transform, &grid, &band, targets, 1, NULL, NULL));
    band = clsdf_band_full();
    band.exact_signs = 2;
    FAILS(CLSDF_INVALID_ARGUMENT, "exact_signs is 2", clsdf_compute(transform, &grid, &band, targets, 1, NULL, NULL));
    band = clsdf_band_symmetric(-1);
    FAILS(CLSDF_INVALID_ARGUMENT, "band", clsdf_compute(transform, &grid, &band, targets, 1, NULL, NULL));
    band = clsdf_band_full();
    grid.size[1] = -5;
    FAILS(CLSDF_INVALID_ARGUMENT, "-5", clsdf_compute(transform, &grid, &band, targets, 1, NULL, NULL));
    grid.size[1] = 5;
    FAILS(CLSDF_INVALID_ARGUMENT, "outputs",
          clsdf_compute_field(transform, &grid, &band, 1U << 31, NULL, NULL, &field));
    FAILS(CLSDF_INVALID_ARGUMENT, "sink",
          clsdf_compute_slabs(transform, &grid, &band, 0, NULL, NULL, NULL, NULL, NULL));
    call.wait_count = 1;
    FAILS(CLSDF_INVALID_ARGUMENT, "wait_list", clsdf_compute(transform, &grid, &band, targets, 1, &call, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "requests", clsdf_compute_requests(transform, NULL, 3, NULL, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "places", clsdf_classify(transform, &box, 1, 1, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "results", clsdf_winding(transform, &points, NULL, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "directions", clsdf_rays(transform, &points, NULL, &rays, NULL, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "clsdf_ray_request", clsdf_rays(transform, &points, &points, NULL, NULL, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "no array", clsdf_rays(transform, &points, &points, &rays, NULL, NULL));
    rays.hits = 2;
    FAILS(CLSDF_INVALID_ARGUMENT, "clsdf_ray_request.hits is 2",
          clsdf_rays(transform, &points, &points, &rays, NULL, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "hits is 7", clsdf_visible(transform, &points, &points, 7, &points, NULL, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "visible", clsdf_visible(transform, &points, &points, 0, NULL, NULL, NULL));
    box.lower[1] = 2;
    FAILS(CLSDF_INVALID_ARGUMENT, "box", clsdf_classify(transform, &box, 1, 1, &place));
    points.type = CLSDF_AUTOMATIC;
    FAILS(CLSDF_INVALID_ARGUMENT, "points.type is 0", clsdf_query(transform, &points, 1, targets, 1, NULL, NULL));
    points.type = CLSDF_FLOAT64;
    points.host = NULL;
    FAILS(CLSDF_INVALID_ARGUMENT, "points has no memory", clsdf_query(transform, &points, 1, targets, 1, NULL, NULL));
    clsdf_transform_release(transform);

    /* Meshes name the element and the value, in the caller's numbers. */
    arrays.vertices = clsdf_host_array(CLSDF_FLOAT64, vertices, 3);
    arrays.triangles = clsdf_host_array(CLSDF_UINT32, triangle, 1);
    arrays.index_base = 1;
    arrays.name = "plate";
    FAILS(CLSDF_INVALID_MESH, "plate: triangle 1 has the vertex index 0; with index base 1 triangles count from 1",
          clsdf_mesh_create(&arrays, &none));
    triangle[0] = 4;
    FAILS(CLSDF_INVALID_MESH, "1 to 3", clsdf_mesh_create(&arrays, &none));
    arrays.index_base = 0;
    FAILS(CLSDF_INVALID_MESH, "triangle 0 has the vertex index 4", clsdf_mesh_create(&arrays, &none));
    FAILS(CLSDF_INVALID_MESH, "triangles and indices count from 0", clsdf_mesh_create(&arrays, &none));
    triangle[0] = 1;
    triangle[1] = 2;
    triangle[2] = 3;
    arrays.index_base = 1;
    vertices[7] = HUGE_VAL;
    FAILS(CLSDF_INVALID_MESH, "vertex 2, used by triangle 0, is not finite", clsdf_mesh_create(&arrays, &none));
    FAILS(CLSDF_INVALID_MESH, "count from 0", clsdf_mesh_create(&arrays, &none));
    vertices[7] = 1;
    arrays.index_base = 2;
    FAILS(CLSDF_INVALID_ARGUMENT, "index_base is 2", clsdf_mesh_create(&arrays, &none));
    arrays.index_base = 0;
    for (n = 0; n < 3; ++n) triangle[n] = (uint32_t)n;
    arrays.triangles.count = 0;
    FAILS(CLSDF_INVALID_MESH, "triangle", clsdf_mesh_create(&arrays, &none));
    arrays.triangles.count = 1;
    arrays.triangles.bytes = 8;
    FAILS(CLSDF_INVALID_MESH, "2 numbers", clsdf_mesh_create(&arrays, &none));
    FAILS(CLSDF_UNREADABLE_INPUT, "nowhere.ply", clsdf_mesh_read("nowhere.ply", &none));
    FAILS(CLSDF_INVALID_ARGUMENT, "cube", clsdf_mesh_shape("cubf", &none));
    FAILS(CLSDF_NO_DEVICE, "no such device", clsdf_device_select("no such device", (clsdf_device**)&none));
    /* A success clears the message. */
    OK(clsdf_band_validate(&band));
}

int main(void) {
    clsdf_device* device;
    clsdf_mesh* mesh;
    check_null();
    OK(clsdf_device_automatic(&device));
    OK(clsdf_mesh_shape("cube", &mesh));
    check_wrong_handles(device, mesh);
    check_sizes(device, mesh);
    check_numbers(device, mesh);
    clsdf_mesh_release(mesh);
    clsdf_device_release(device);
    return 0;
}
