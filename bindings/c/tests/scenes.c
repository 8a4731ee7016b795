/* Many bodies: cubes with poses, whose distances are known. */
#include "test.h"

#include <math.h>

static int is_near(double found, double expected) {
    return fabs(found - expected) < 1e-13;
}

static clsdf_pose pose_at(double x) {
    clsdf_pose pose = CLSDF_POSE_INIT;
    pose.translation[0] = x;
    return pose;
}

static clsdf_status query(clsdf_scene* scene, const double* points, int64_t count, double half_width, double* distance,
                          uint32_t* bodies, uint8_t* own) {
    const clsdf_array at = clsdf_host_array(CLSDF_FLOAT64, points, count);
    clsdf_target targets[2];
    targets[0] = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT64, distance, count);
    targets[1] = clsdf_host_target(CLSDF_BODY, CLSDF_UINT32, bodies, count);
    return clsdf_scene_query(scene, &at, half_width, targets, bodies == NULL ? 1 : 2, own, NULL, NULL);
}

int main(void) {
    static const double vertices[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                          {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
    static const uint32_t triangles[12][3] = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                                              {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
    /* Outside, in both, in both near the face of one that lies in the other, far away. */
    static const double points[4][3] = {{0, 0, 3}, {0.7, 0, 0}, {0.4, 0, 0}, {0, 0, 9}};
    static const double matrix[16] = {0, -1, 0, 2, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    static const uint32_t pairs[3][2] = {{1, 2}, {4, 1}, {2, 1}};
    static const uint32_t wrong_pairs[2][2] = {{1, 3}, {0, 1}};
    static const int64_t second[1] = {2}, twice[2] = {2, 2}, third[1] = {3};
    static const clsdf_box boxes[2] = {{{-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}}, {{5, 5, 5}, {6, 6, 6}}};
    const clsdf_array at = clsdf_host_array(CLSDF_FLOAT64, &points[0][0], 4);
    clsdf_mesh_arrays arrays = CLSDF_MESH_ARRAYS_INIT;
    clsdf_scene_options options = CLSDF_SCENE_OPTIONS_INIT;
    clsdf_kept_memory memory = CLSDF_KEPT_MEMORY_INIT;
    clsdf_statistics statistics = CLSDF_STATISTICS_INIT;
    clsdf_device* device = NULL;
    clsdf_mesh *mesh = NULL, *outer = NULL;
    clsdf_outer_report report = CLSDF_OUTER_REPORT_INIT;
    const uint32_t *faces_of_outer, *bodies_of_outer;
    int64_t count_of_bodies;
    clsdf_scene* scene = NULL;
    clsdf_pose pose, poses[2];
    clsdf_target targets[3];
    clsdf_array larger;
    clsdf_field* field = NULL;
    /* Samples along x through both cubes: beyond the band, in the first, in the second, ... */
    static const uint32_t body_of[8] = {0, 1, 2, 0, 2, 2, 2, 0};
    static const double value_of[8] = {-0.6, -0.5, -0.5, -0.6, -0.5, 0, 0.5, 0.6};
    clsdf_grid grid = {{0, 0, 0}, {0.5, 0.5, 0.5}, {8, 1, 1}, {0, 0, 0}};
    clsdf_band band = clsdf_band_symmetric(0.6);
    float values[8];
    uint32_t body_values[8];
    double distance[4], winding[4], vertices_of_larger[8][3];
    uint32_t bodies[4], triangle[4];
    uint8_t own[4], inside[4], places[2];
    int64_t body = -1, count = -1;
    int32_t flag = -1, i;
    arrays.vertices = clsdf_host_array(CLSDF_FLOAT64, &vertices[0][0], 8);
    arrays.triangles = clsdf_host_array(CLSDF_UINT32, &triangles[0][0], 12);
    OK(clsdf_device_automatic(&device));
    OK(clsdf_mesh_create(&arrays, &mesh));
    options.index_base = 2;
    FAILS(CLSDF_INVALID_ARGUMENT, "2", clsdf_scene_create(device, &options, &scene));
    options.index_base = 1;
    options.surface = 2;
    FAILS(CLSDF_INVALID_ARGUMENT, "clsdf_scene_options.surface is", clsdf_scene_create(device, &options, &scene));
    /* (0.7, 0, 0) is 0.3 and 0.2 deep in the two cubes, and 1 in their union. */
    options.surface = CLSDF_SURFACE_OUTER;
    OK(clsdf_scene_create(device, &options, &scene));
    OK(clsdf_scene_add(scene, mesh, CLSDF_SIGN_AUTOMATIC, NULL, NULL, &body));
    pose = pose_at(1.5);
    OK(clsdf_scene_add_instance(scene, 1, &pose, &body));
    OK(query(scene, &points[0][0], 4, HUGE_VAL, distance, NULL, NULL));
    CHECK(is_near(distance[0], 2) && is_near(distance[1], -1) && is_near(distance[2], -1));
    FAILS(CLSDF_UNSUPPORTED, "site",
          clsdf_scene_compute_field(scene, &grid, &band, CLSDF_SET(CLSDF_SITE), NULL, NULL, &field));
    clsdf_scene_release(scene);
    options.surface = CLSDF_SURFACE_GIVEN;
    OK(clsdf_scene_create(device, &options, &scene));
    FAILS(CLSDF_INVALID_ARGUMENT, "has no bodies", query(scene, &points[0][0], 4, HUGE_VAL, distance, NULL, NULL));
    OK(clsdf_scene_add(scene, mesh, CLSDF_SIGN_AUTOMATIC, NULL, NULL, &body));
    CHECK(body == 1);
    pose = pose_at(1.5);
    OK(clsdf_scene_add_instance(scene, 1, &pose, &body));
    CHECK(body == 2);
    OK(clsdf_scene_size(scene, &count));
    OK(clsdf_scene_has_sign(scene, &flag));
    CHECK(count == 2 && flag == 1);
    OK(clsdf_scene_sign(scene, 2, &flag));
    CHECK(flag == CLSDF_SIGN_NONZERO);
    OK(clsdf_scene_memory(scene, &memory));
    OK(clsdf_scene_outer(scene, NULL, &outer, &report));
    CHECK(is_near(report.volume, 14) && report.hidden_faces >= 4);
    OK(clsdf_mesh_given_faces(outer, &faces_of_outer, &count));
    OK(clsdf_mesh_given_bodies(outer, &bodies_of_outer, &count_of_bodies));
    CHECK(count > 0 && count_of_bodies == count && bodies_of_outer[0] == 0 && bodies_of_outer[count - 1] == 1);
    for (i = 0; i < count; ++i) CHECK(faces_of_outer[i] < 12);
    OK(clsdf_mesh_given_bodies(mesh, NULL, &count));
    CHECK(count == 0);
    clsdf_mesh_release(outer);

    OK(query(scene, &points[0][0], 4, HUGE_VAL, distance, bodies, own));
    CHECK(is_near(distance[0], 2) && is_near(distance[1], -0.3) && is_near(distance[2], -0.6) &&
          is_near(distance[3], 8));
    CHECK(bodies[0] == 1 && bodies[1] == 1 && bodies[2] == 1 && bodies[3] == 1);
    CHECK(own[0] == 1 && own[1] == 0 && own[2] == 0 && own[3] == 1);
    targets[0] = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT64, distance, 4);
    targets[1] = clsdf_host_target(CLSDF_TRIANGLE, CLSDF_UINT32, triangle, 4);
    targets[2] = clsdf_host_target(CLSDF_BODY, CLSDF_UINT32, bodies, 4);
    OK(clsdf_scene_query(scene, &at, 5, targets, 3, NULL, NULL, &statistics));
    CHECK(bodies[0] == 1 && bodies[3] == 0 && distance[3] == 5);
    CHECK((triangle[0] == 3 || triangle[0] == 4) && triangle[3] == 0 && statistics.unusable_points == 0);

    targets[0].array.count = targets[1].array.count = 3;
    OK(clsdf_scene_query_pairs(scene, &at, &pairs[0][0], 3, HUGE_VAL, targets, 2, NULL, NULL));
    CHECK(is_near(distance[0], sqrt(4.25)) && is_near(distance[1], 8) && is_near(distance[2], -0.3));
    CHECK(triangle[2] == 7 || triangle[2] == 8);
    FAILS(CLSDF_INVALID_ARGUMENT, "body",
          clsdf_scene_query_pairs(scene, &at, &wrong_pairs[0][0], 1, HUGE_VAL, targets, 0, NULL, NULL));
    targets[0].array.count = 1;
    FAILS(CLSDF_INVALID_ARGUMENT, "pair 0 names body 2",
          clsdf_scene_query_pairs(scene, &at, &wrong_pairs[0][0], 1, HUGE_VAL, targets, 1, NULL, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "count from 1",
          clsdf_scene_query_pairs(scene, &at, &wrong_pairs[1][0], 1, HUGE_VAL, targets, 1, NULL, NULL));

    targets[0] = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT32, values, 8);
    targets[1] = clsdf_host_target(CLSDF_BODY, CLSDF_UINT32, body_values, 8);
    OK(clsdf_scene_compute(scene, &grid, &band, targets, 2, NULL, &statistics));
    for (i = 0; i < 8; ++i) CHECK(fabs(values[i] - value_of[i]) < 1e-6 && body_values[i] == body_of[i]);
    OK(clsdf_scene_compute_field(scene, &grid, &band, CLSDF_SET(CLSDF_BODY), NULL, NULL, &field));
    OK(clsdf_field_array(field, CLSDF_BODY, &larger));
    for (i = 0; i < 8; ++i) CHECK(((const uint32_t*)larger.host)[i] == body_of[i]);
    clsdf_field_release(field);

    OK(clsdf_scene_contains(scene, &at, inside, NULL));
    OK(clsdf_scene_winding(scene, &at, winding, NULL));
    OK(clsdf_scene_classify(scene, boxes, 2, 0.1, places));
    CHECK(inside[0] == 0 && inside[1] == 1 && inside[2] == 1 && inside[3] == 0);
    CHECK(is_near(winding[0], 0) && is_near(winding[1], 2) && is_near(winding[3], 0));
    CHECK(places[0] == CLSDF_INSIDE && places[1] == CLSDF_OUTSIDE);

    /* Poses: all, some, a matrix. */
    OK(clsdf_pose_of_matrix(matrix, &pose));
    CHECK(pose.rotation[1] == -1 && pose.rotation[3] == 1 && pose.translation[0] == 2);
    poses[0] = pose_at(0);
    poses[1] = pose;
    OK(clsdf_scene_set_poses(scene, NULL, poses, 2));
    OK(clsdf_scene_pose(scene, 2, &pose));
    CHECK(memcmp(&pose, &poses[1], sizeof pose) == 0);
    pose = pose_at(8);
    OK(clsdf_scene_set_poses(scene, second, &pose, 1));
    FAILS(CLSDF_INVALID_ARGUMENT, "1 poses and 2 bodies", clsdf_scene_set_poses(scene, NULL, &pose, 1));
    FAILS(CLSDF_INVALID_ARGUMENT, "named twice", clsdf_scene_set_poses(scene, twice, poses, 2));
    FAILS(CLSDF_INVALID_ARGUMENT, "no body 3: the scene has 2, counted from 1",
          clsdf_scene_set_poses(scene, third, &pose, 1));
    poses[1].rotation[0] = 1;
    FAILS(CLSDF_INVALID_ARGUMENT, "body 1 is no rotation", clsdf_scene_set_poses(scene, NULL, poses, 2));
    poses[1] = pose_at(HUGE_VAL);
    FAILS(CLSDF_INVALID_ARGUMENT, "translation of body 1", clsdf_scene_set_poses(scene, NULL, poses, 2));
    FAILS(CLSDF_INVALID_ARGUMENT, "last row", clsdf_pose_of_matrix(&vertices[0][0], &pose));
    FAILS(CLSDF_INVALID_ARGUMENT, "poses is null", clsdf_scene_set_poses(scene, NULL, NULL, 2));
    OK(clsdf_scene_pose(scene, 2, &pose));
    CHECK(pose.translation[0] == 8);

    /* New positions, and bodies that are off. */
    for (i = 0; i < 24; ++i) (&vertices_of_larger[0][0])[i] = 2 * (&vertices[0][0])[i];
    larger = clsdf_host_array(CLSDF_FLOAT64, &vertices_of_larger[0][0], 8);
    OK(clsdf_scene_set_positions(scene, 2, &larger, NULL));
    OK(query(scene, &points[0][0], 1, HUGE_VAL, distance, NULL, NULL));
    CHECK(is_near(distance[0], 1));
    OK(clsdf_scene_set_active(scene, 1, 0));
    OK(clsdf_scene_active(scene, 1, &flag));
    CHECK(flag == 0);
    OK(query(scene, &points[0][0], 1, HUGE_VAL, distance, bodies, NULL));
    CHECK(bodies[0] == 2 && is_near(distance[0], sqrt(37)));
    OK(clsdf_scene_set_active(scene, 2, 0));
    FAILS(CLSDF_INVALID_ARGUMENT, "all 2 bodies", clsdf_scene_contains(scene, &at, inside, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "active is 2", clsdf_scene_set_active(scene, 2, 2));
    FAILS(CLSDF_UNSUPPORTED, "below", clsdf_scene_add(scene, mesh, CLSDF_SIGN_BELOW, NULL, NULL, &body));
    FAILS(CLSDF_INVALID_ARGUMENT, "no body 0", clsdf_scene_add_instance(scene, 0, NULL, &body));
    FAILS(CLSDF_INVALID_ARGUMENT, "scene is null", clsdf_scene_size(NULL, &count));
    OK(clsdf_scene_size(scene, &count));
    CHECK(count == 2);

    clsdf_scene_retain(scene);
    clsdf_scene_release(scene);
    clsdf_scene_release(scene);
    clsdf_mesh_release(mesh);
    clsdf_device_release(device);
    return 0;
}
