#ifndef CLSDF_C_CALLS_H
#define CLSDF_C_CALLS_H

/*
 * Options and results of calls.
 * A part of clsdf.h, which programs include; its rules hold.
 */

#include "basics.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Options and results of calls ---- */

typedef int32_t (*clsdf_log_function)(void* user, const char* message);

typedef struct clsdf_progress {
    int32_t stage; /* CLSDF_COMPILING, CLSDF_COMPUTING, CLSDF_TESTING */
    int32_t reserved;
    double fraction; /* of the stage, 0 to 1 */
    int64_t step;    /* of compiling, from 1 */
    int64_t steps;   /* of compiling, at most */
} clsdf_progress;

typedef int32_t (*clsdf_progress_function)(void* user, const clsdf_progress* progress);
/* 0: go on; CLSDF_CANCELLED: cancel. No truth value: 1 would end the call as CLSDF_INVALID_MESH. */
typedef int32_t (*clsdf_stop_function)(void* user);

/* Options of one call. Functions may be null. */
typedef struct clsdf_call_options {
    size_t struct_size;
    void* user;                       /* the first argument of the functions */
    clsdf_progress_function progress; /* called between launches, and before each step of building programs */
    clsdf_stop_function should_stop;  /* asked there, too */
    clsdf_log_function log;           /* warnings of this call */
    void* const* wait_list;           /* cl_events after which the call uses the caller's memory */
    int64_t wait_count;
    int32_t refuse_unusable_points; /* 1: clsdf_query() fails if a point is not finite or too far from the mesh */
    int32_t reserved;
} clsdf_call_options;
#define CLSDF_CALL_OPTIONS_INIT \
    { sizeof(clsdf_call_options), NULL, NULL, NULL, NULL, NULL, 0, 0, 0 }

/* Times (wall-clock seconds of the host) and memory of a call. */
typedef struct clsdf_statistics {
    size_t struct_size;
    int64_t slabs;            /* parts of the grid computed one after the other */
    int64_t device_bytes;     /* the most that buffers took at once; of a plan, its own buffers */
    int64_t host_bytes;       /* the library's arrays on the host for slabs */
    double compile_seconds;   /* building or loading the device's programs, and testing them */
    double polyhedra_seconds; /* preparing the mesh */
    double field_seconds;     /* samples or points */
    int32_t first_use;        /* 1: programs computed for the first time on this device */
    int32_t reserved;
    int64_t unusable_points; /* of clsdf_query(): points that are not finite or too far from the mesh */
} clsdf_statistics;
#define CLSDF_STATISTICS_INIT \
    { CLSDF_RESULT_SIZE(clsdf_statistics), 0, 0, 0, 0, 0, 0, 0, 0, 0 }

#ifdef __cplusplus
}
#endif

#endif
