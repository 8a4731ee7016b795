#ifndef CLSDF_C_SCENES_H
#define CLSDF_C_SCENES_H

/*
 * Scenes: many bodies with poses, their fields, and points among them.
 * A part of clsdf.h, which programs include; its rules hold.
 */

#include "arrays.h"
#include "calls.h"
#include "grids.h"
#include "meshes.h"
#include "transforms.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Scenes: many bodies with poses, their fields, and points among them (docs/scenes.md) ---- */

/* The pose of a body, whose points x are at R x + t. */
typedef struct clsdf_pose {
    double rotation[9]; /* R, by rows */
    double translation[3];
} clsdf_pose;
#define CLSDF_POSE_INIT                \
    {                                  \
        {1, 0, 0, 0, 1, 0, 0, 0, 1}, { \
            0, 0, 0                    \
        }                              \
    }
/* The pose of a 4 x 4 matrix by rows, double[16], whose last row is 0, 0, 0, 1. Its rotation may be rounded to floats,
 * and is replaced by the nearest rotation, with the same bytes on every machine. */
CLSDF_API clsdf_status clsdf_pose_of_matrix(const double* matrix, clsdf_pose* pose);

typedef struct clsdf_scene_options {
    size_t struct_size;
    int64_t kept_bytes; /* limit of the memory that is kept of each mesh; 0: none; -1: the default */
    int32_t index_base; /* 0 or 1: from which bodies, the points of pairs and the triangles of results count. Numbers in
                           messages count from 0 */
    /* CLSDF_SURFACE_GIVEN, the default: the distance is the least of the bodies'. CLSDF_SURFACE_OUTER: that to the
     * surface of the union of the bodies that are on, within overlaps, too; each body's mesh is replaced by its own
     * outer surface when it is added. */
    int32_t surface;
} clsdf_scene_options;
#define CLSDF_SCENE_OPTIONS_INIT \
    { sizeof(clsdf_scene_options), -1, 0, CLSDF_SURFACE_GIVEN }

/* A scene without bodies; `options` may be null. device: whose memory points and results may be in; the host computes.
 * Calls that change a scene: threads: one. Calls of a const scene: threads: any number. After an error the scene is
 * that of before. */
CLSDF_API clsdf_status clsdf_scene_create(const clsdf_device* device, const clsdf_scene_options* options,
                                          clsdf_scene** scene);
/* Adds a mesh, which is copied, and gives the body's number, which stays: they are given in the order of the calls.
 * sign: CLSDF_SIGN_AUTOMATIC ...; CLSDF_SIGN_BELOW is CLSDF_UNSUPPORTED. pose: null: R = 1, t = 0. */
CLSDF_API clsdf_status clsdf_scene_add(clsdf_scene* scene, const clsdf_mesh* mesh, int32_t sign, const clsdf_pose* pose,
                                       const clsdf_call_options* call, int64_t* body);
/* Adds a body that has the mesh and the sign rule of another one. */
CLSDF_API clsdf_status clsdf_scene_add_instance(clsdf_scene* scene, int64_t of, const clsdf_pose* pose, int64_t* body);
/* Moves the bodies, bodies[count], or all of them if `bodies` is null and `count` is their number. Elements of R R^T
 * may differ from the identity's by 1e-5, so that rotations may be rounded to floats: each is replaced by the nearest
 * one. CLSDF_INVALID_ARGUMENT names the body of a matrix that is no rotation; no body moves then. */
CLSDF_API clsdf_status clsdf_scene_set_poses(clsdf_scene* scene, const int64_t* bodies, const clsdf_pose* poses,
                                             int64_t count);
/* Gives the mesh of a body, and so all its instances, new positions before their poses. */
CLSDF_API clsdf_status clsdf_scene_set_positions(clsdf_scene* scene, int64_t body, const clsdf_array* positions,
                                                 const clsdf_call_options* call);
/* 0: switches a body off, as if it were not there; 1: on again. */
CLSDF_API clsdf_status clsdf_scene_set_active(clsdf_scene* scene, int64_t body, int32_t active);
CLSDF_API clsdf_status clsdf_scene_size(const clsdf_scene* scene, int64_t* count);
CLSDF_API clsdf_status clsdf_scene_active(const clsdf_scene* scene, int64_t body, int32_t* active);
/* With the rotation that is used. */
CLSDF_API clsdf_status clsdf_scene_pose(const clsdf_scene* scene, int64_t body, clsdf_pose* pose);
/* The rule in use, never CLSDF_SIGN_AUTOMATIC. */
CLSDF_API clsdf_status clsdf_scene_sign(const clsdf_scene* scene, int64_t body, int32_t* rule);
/* 1: a body that is on has a sign. */
CLSDF_API clsdf_status clsdf_scene_has_sign(const clsdf_scene* scene, int32_t* has_sign);
/* Around the bodies that are on, where they are. */
CLSDF_API clsdf_status clsdf_scene_box(const clsdf_scene* scene, clsdf_box* box);
/* The memory that is kept of all meshes. */
CLSDF_API clsdf_status clsdf_scene_memory(const clsdf_scene* scene, clsdf_kept_memory* memory);
/* The outer surface of the bodies that are on, where they are: faces are cut where bodies meet, and what lies in
 * another body is left out. Distances to this mesh are those to the union, within overlaps, too, where those of the
 * scene are only a lower bound of the depth. It is made anew by each call: for bodies at rest. The index base is the
 * scene's; of `call`, which may be null, should_stop counts; `report`, which may be null, counts triangles of the
 * bodies' own outer surfaces. CLSDF_UNSUPPORTED if a body has no outer surface, as an open one. */
CLSDF_API clsdf_status clsdf_scene_outer(const clsdf_scene* scene, const clsdf_call_options* call, clsdf_mesh** outer,
                                         clsdf_outer_report* report);

/* As clsdf_compute() and clsdf_compute_field(): the least of the bodies' signed distances, with the outputs of the body
 * that has it, and CLSDF_BODY, which count from index_base. A sample in the depth of a body, beyond its band, is beyond
 * the band of the field. Each body has the bytes of a transform of its own that was moved there. Fields of a scene take
 * turns. CLSDF_UNSUPPORTED for CLSDF_SITE and CLSDF_BARYCENTRIC of a scene with CLSDF_SURFACE_OUTER. */
CLSDF_API clsdf_status clsdf_scene_compute(const clsdf_scene* scene, const clsdf_grid* grid, const clsdf_band* band,
                                           const clsdf_target* targets, int64_t target_count,
                                           const clsdf_call_options* call, clsdf_statistics* statistics);
CLSDF_API clsdf_status clsdf_scene_compute_field(const clsdf_scene* scene, const clsdf_grid* grid,
                                                 const clsdf_band* band, uint32_t outputs,
                                                 const clsdf_call_options* call, clsdf_statistics* statistics,
                                                 clsdf_field** field);

/* As clsdf_query(), of the body whose signed distance is the least; closest points, gradients and offsets are in the
 * scene's coordinates, triangles and sites those of its mesh; CLSDF_BODY says which body. `own`, which may be null, has
 * an item for each point: 1 if the distance is that of the union of the bodies, 0 if the union's surface may be farther
 * away. */
CLSDF_API clsdf_status clsdf_scene_query(const clsdf_scene* scene, const clsdf_array* points, double half_width,
                                         const clsdf_target* targets, int64_t target_count, uint8_t* own,
                                         const clsdf_call_options* call, clsdf_statistics* statistics);
/* The outputs of pairs of a point and a body, pairs[count][2], by that body alone; targets have `count` items. */
CLSDF_API clsdf_status clsdf_scene_query_pairs(const clsdf_scene* scene, const clsdf_array* points,
                                               const uint32_t* pairs, int64_t count, double half_width,
                                               const clsdf_target* targets, int64_t target_count,
                                               const clsdf_call_options* call, clsdf_statistics* statistics);
/* 1 for each point that is inside a body, else 0. A point on the surface of a body is not inside this one. */
CLSDF_API clsdf_status clsdf_scene_contains(const clsdf_scene* scene, const clsdf_array* points, uint8_t* inside,
                                            const clsdf_call_options* call);
/* The sum of the bodies' winding numbers, in their order, for each point. */
CLSDF_API clsdf_status clsdf_scene_winding(const clsdf_scene* scene, const clsdf_array* points, double* results,
                                           const clsdf_call_options* call);
/* The places of `count` boxes: CLSDF_INSIDE one of the bodies, CLSDF_OUTSIDE all of them (CLSDF_BEYOND if no body has a
 * sign), else CLSDF_WITHIN. */
CLSDF_API clsdf_status clsdf_scene_classify(const clsdf_scene* scene, const clsdf_box* boxes, int64_t count,
                                            double half_width, uint8_t* places);

#ifdef __cplusplus
}
#endif

#endif
