#ifndef CLSDF_C_POINTS_H
#define CLSDF_C_POINTS_H

/*
 * Distances at points, places of boxes, winding numbers, files of points.
 * A part of clsdf.h, which programs include; its rules hold.
 */

#include "arrays.h"
#include "calls.h"
#include "grids.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Points ---- */

/* The distance at points, and all else that has an array of points->count items. Beyond half_width, which may be 0 or
 * infinite, the distance is half_width with the point's sign. At most 96 points are answered by the calling thread.
 * A point that is not finite gets the distance NaN and no triangle. A finite one more than 1e14 voxels (1/256 of the
 * mesh's longest side) from the mesh's box gets half_width if that is finite, else NaN, and no triangle. call->log gets
 * one warning with their number. With call->refuse_unusable_points such a point fails the whole call; the message has
 * its index from 0, and no output is written. Targets may lie on the points: they are read first. */
CLSDF_API clsdf_status clsdf_query(const clsdf_transform* transform, const clsdf_array* points, double half_width,
                                   const clsdf_target* targets, int64_t target_count, const clsdf_call_options* call,
                                   clsdf_statistics* statistics);
/* The distances to points[count][3], packed on the host; beyond half_width, which may be HUGE_VAL, half_width with the
 * point's sign. clsdf_query() says more. */
static inline clsdf_status clsdf_query_distance(const clsdf_transform* transform, const double* points, int64_t count,
                                                double half_width, float* distance) {
    const clsdf_array at = clsdf_host_array(CLSDF_FLOAT64, points, count);
    const clsdf_target target = clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT32, distance, count);
    return clsdf_query(transform, &at, half_width, &target, 1, NULL, NULL);
}
/* The places (CLSDF_WITHIN ...) of `count` boxes. */
CLSDF_API clsdf_status clsdf_classify(const clsdf_transform* transform, const clsdf_box* boxes, int64_t count,
                                      double half_width, uint8_t* places);
/* The generalised winding number at points->count points anywhere, in floats or doubles: an integer for a closed mesh.
 * The sign rule solid_angle takes points with 1/2 or more, or -1/2 or less, to be inside. NaN for a point that is not
 * finite. results->count is 0 or that of the points. */
CLSDF_API clsdf_status clsdf_winding(const clsdf_transform* transform, const clsdf_array* points,
                                     const clsdf_array* results, const clsdf_call_options* call);

/* ---- Files of points ---- */

/* Reads points from .npy (n, 3), .csv (columns x, y, z) or .ply. */
CLSDF_API clsdf_status clsdf_points_read(const char* path, clsdf_points** points);
/* double[count][3], in the handle's memory. Threads: any number. */
CLSDF_API clsdf_status clsdf_points_data(const clsdf_points* points, const double** positions, int64_t* count);
/* Writes what clsdf_query() found, a row for each point, by the file's ending: .npy, .csv or .ply. `positions` is
 * double[count][3]; `results` are packed arrays on the host of the types that clsdf_output_describe() states. `outputs`
 * is needed only without points. Triangles are written as they are. */
CLSDF_API clsdf_status clsdf_points_write(const double* positions, int64_t count, const clsdf_target* results,
                                          int64_t result_count, const char* path, uint32_t outputs);
/* The error that clsdf_points_write() would give for the ending or the folder. */
CLSDF_API clsdf_status clsdf_points_check_path(const char* path);
/* For a program that is about to end: removes the unfinished files that clsdf_mesh_write() and clsdf_points_write() are
 * writing, on all threads. The program must end now. Not for signal handlers. With clsdf_io.h, call
 * clsdf_io_abandon_unfinished_files() instead. */
CLSDF_API void clsdf_abandon_unfinished_files(void);

#ifdef __cplusplus
}
#endif

#endif
