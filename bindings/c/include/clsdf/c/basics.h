#ifndef CLSDF_C_BASICS_H
#define CLSDF_C_BASICS_H

/*
 * Version, status and other numbers, errors, handles.
 * A part of clsdf.h, which programs include; its rules hold.
 */

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define CLSDF_API __attribute__((visibility("default")))
#else
#define CLSDF_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Version ---- */

#define CLSDF_VERSION_MAJOR 0
#define CLSDF_VERSION_MINOR 1
#define CLSDF_VERSION_PATCH 0
#define CLSDF_MAKE_VERSION(major, minor, patch) ((major)*1000000 + (minor)*1000 + (patch))
#define CLSDF_VERSION CLSDF_MAKE_VERSION(CLSDF_VERSION_MAJOR, CLSDF_VERSION_MINOR, CLSDF_VERSION_PATCH)

/* The library's CLSDF_VERSION. It differs from the macro if the program was compiled with another version's header. */
CLSDF_API int64_t clsdf_version(void);
/* The library's "major.minor.patch"; lives as long as the process. */
CLSDF_API const char* clsdf_version_text(void);

/* struct_size of a struct that calls fill. */
#define CLSDF_RESULT_SIZE(type) (sizeof(type) + 1)

/* ---- Numbers: they never change ---- */

typedef int32_t clsdf_status;
#define CLSDF_OK 0
#define CLSDF_INVALID_MESH 1     /* index out of range, vertex in use not finite, no triangle, sign rule not met */
#define CLSDF_UNREADABLE_INPUT 2 /* a file that cannot be opened, is truncated or malformed */
#define CLSDF_INVALID_ARGUMENT 3 /* an argument that makes no sense */
#define CLSDF_NO_DEVICE 4        /* no OpenCL device, or none of the name asked for */
#define CLSDF_DEVICE_FAILURE 5   /* an OpenCL call failed: clsdf_last_opencl_error() */
#define CLSDF_OUT_OF_MEMORY 6    /* of the host or the device */
#define CLSDF_UNSUPPORTED 7      /* a correct request that this build or device does not support */
#define CLSDF_CANCELLED 8        /* for callbacks that cancel */
#define CLSDF_OUTPUT_FAILURE 9   /* a result could not be written; nothing is left under its final name */
#define CLSDF_WRONG_RESULTS 10   /* the device computes wrong values in the test at its first use */
#define CLSDF_UNEXPECTED (-1)    /* a failure that the library does not expect; its message says which */
#define CLSDF_OWN_STATUS 1000    /* from here on: a program's own numbers, which clsdf never returns by itself */

/* Types of the numbers in an array. */
#define CLSDF_AUTOMATIC 0 /* of an output: the type that clsdf_output_describe() states */
#define CLSDF_FLOAT32 1
#define CLSDF_FLOAT64 2
#define CLSDF_INT32 3
#define CLSDF_INT64 4
#define CLSDF_UINT32 5
#define CLSDF_UINT64 6
#define CLSDF_UINT8 7

/* Outputs. Beyond the band triangle and body are index_base - 1 (in uint32: 4294967295 or 0), the site 255, and vectors
 * are NaN. */
#define CLSDF_DISTANCE 0    /* signed; always computed */
#define CLSDF_TRIANGLE 1    /* the nearest triangle; if an edge or a vertex is nearest, the lowest that shares it */
#define CLSDF_SITE 2        /* 0 to 2: a vertex of it, 3 to 5: an edge, 6: its face; see CLSDF_SURFACE_OUTER */
#define CLSDF_CLOSEST 3     /* the position of the closest point: float64 */
#define CLSDF_GRADIENT 4    /* of the signed distance: a unit vector */
#define CLSDF_BARYCENTRIC 5 /* of the closest point: the weights of the triangle's vertices 1 and 2 (from 0) */
#define CLSDF_OFFSET 7      /* from the sample or point to the closest point */
#define CLSDF_BODY 8        /* of a scene: the body of the nearest triangle; of a mesh index_base */

/* A set of outputs: CLSDF_SET(CLSDF_TRIANGLE) | CLSDF_SET(CLSDF_SITE). */
#define CLSDF_SET(output) ((uint32_t)1 << (output))

/* Rules of the sign. */
/* balanced: nonzero; closed: parity; open: solid_angle if few points are in doubt; else none (call->log warns unless it
 * is nonzero) */
#define CLSDF_SIGN_AUTOMATIC 0
#define CLSDF_SIGN_NONZERO 1     /* inside if the winding number is not zero; needs a balanced mesh */
#define CLSDF_SIGN_PARITY 2      /* inside if a ray crosses the surface an odd number of times; needs a closed mesh */
#define CLSDF_SIGN_NONE 3        /* the distance alone */
#define CLSDF_SIGN_SOLID_ANGLE 4 /* inside if the winding number is one half or more, or -1/2 or less; any mesh */
#define CLSDF_SIGN_BELOW \
    5 /* inside below a terrain and above clsdf_transform_options.floor, between walls from its rim */

/* The surface that distances are measured to. */
#define CLSDF_SURFACE_GIVEN 0 /* all faces as given, also within other parts */
/* The outer surface of overlapping parts, as clsdf_mesh_outer() makes it. Triangles are told by the faces as given that
 * they are parts of; a site beside those of a triangle, 7, is an edge or a vertex at which faces cut each other. */
#define CLSDF_SURFACE_OUTER 1

/* The hits that count where a segment or a ray meets the surface. */
#define CLSDF_WALLS 0 /* where inside and outside meet, by the sign rule: never a face within the body */
#define CLSDF_FACES 1 /* every face as given, also of sheets and of meshes without a sign */

/* The place of a box. */
#define CLSDF_WITHIN 0  /* the surface may be within the half width of a point of the box */
#define CLSDF_INSIDE 1  /* the surface is farther from every point of the box, and all are inside */
#define CLSDF_OUTSIDE 2 /* the same, and all are outside */
#define CLSDF_BEYOND 3  /* the same, of a mesh without a sign */

/* The outcome of a point in a plan's run. */
#define CLSDF_FOUND 0
#define CLSDF_NOT_FINITE 1 /* the distance is NaN; there is no triangle */
#define CLSDF_TOO_FAR 2    /* the distance is the half width, or NaN if that is infinite; there is no triangle */
#define CLSDF_SIGN_OPEN 3  /* exact arithmetic did not suffice: NaN, no triangle; clsdf_query() has the sign */

#define CLSDF_GPU 0
#define CLSDF_PROCESSOR 1
#define CLSDF_ACCELERATOR 2
#define CLSDF_OTHER_DEVICE 3

/* How a device was found. */
#define CLSDF_REGISTERED 0   /* OpenCL's loader lists it */
#define CLSDF_BUNDLED 1      /* of the driver that the package with this library contains */
#define CLSDF_UNREGISTERED 2 /* of a GPU's driver in the path of the system's loader, which OpenCL's does not know */
#define CLSDF_DEVICE_FILE 3  /* a GPU's file in /dev, and no device that can be used */

/* Units of a length. */
#define CLSDF_MESH_UNITS 0
#define CLSDF_VOXELS 1
#define CLSDF_EXTENT 2 /* the longest side of the mesh's box: 0.1 is 10% of it */

/* Stages of a call. */
#define CLSDF_COMPILING 0
#define CLSDF_COMPUTING 1
#define CLSDF_TESTING 2 /* programs compute a known field */

/* The names of these numbers, as "invalid_mesh", "float", "nonzero", "gpu"; "unknown" for a number of none. They live
 * as long as the process. */
CLSDF_API const char* clsdf_status_name(clsdf_status status);
CLSDF_API const char* clsdf_type_name(int32_t type);
CLSDF_API const char* clsdf_sign_name(int32_t rule);
CLSDF_API const char* clsdf_device_kind_name(int32_t kind);
CLSDF_API const char* clsdf_device_source_name(int32_t source);

/* ---- Errors ---- */

/* The message of this thread's last call that returned a status: "" after a success, whatever its callbacks did. Valid
 * until the thread's next call. The text is the one that C++ gets. */
CLSDF_API const char* clsdf_last_error(void);
/* The number that the failed call of OpenCL returned (cl_int); 0 for other errors. */
CLSDF_API int32_t clsdf_last_opencl_error(void);
/* For callbacks that end a call: the message of the call. Null: none. */
CLSDF_API void clsdf_set_last_error(const char* message);

/* ---- Handles ---- */

typedef struct clsdf_devices clsdf_devices;           /* a list of the devices of this machine */
typedef struct clsdf_device clsdf_device;             /* an OpenCL device, with a context and a queue */
typedef struct clsdf_mesh clsdf_mesh;                 /* a checked mesh, a copy of arrays or files */
typedef struct clsdf_transform clsdf_transform;       /* the distance to a mesh, on a device */
typedef struct clsdf_scene clsdf_scene;               /* many bodies, each a mesh with a pose */
typedef struct clsdf_plan clsdf_plan;                 /* boxes that are computed again and again */
typedef struct clsdf_sparse_plan clsdf_sparse_plan;   /* a sparse field that is computed again and again */
typedef struct clsdf_point_plan clsdf_point_plan;     /* points that are looked up again and again */
typedef struct clsdf_link_plan clsdf_link_plan;       /* links that go to memory of the device again and again */
typedef struct clsdf_field clsdf_field;               /* a field in the library's memory */
typedef struct clsdf_sparse_field clsdf_sparse_field; /* a sparse field in the library's memory */
typedef struct clsdf_points clsdf_points;             /* points read from a file */
typedef struct clsdf_cuda_device clsdf_cuda_device;   /* an NVIDIA GPU as a device of OpenCL and of CUDA */
typedef struct clsdf_cuda_memory clsdf_cuda_memory;   /* memory that CUDA and OpenCL both have */
typedef struct clsdf_cuda_arrays clsdf_cuda_arrays;   /* arrays in memory of CUDA, for calls and plans */
typedef struct clsdf_thread_limit clsdf_thread_limit; /* as long as it lives, the host's loops have fewer threads */

CLSDF_API void clsdf_devices_retain(clsdf_devices* devices);
CLSDF_API void clsdf_devices_release(clsdf_devices* devices);
CLSDF_API void clsdf_device_retain(clsdf_device* device);
CLSDF_API void clsdf_device_release(clsdf_device* device);
CLSDF_API void clsdf_mesh_retain(clsdf_mesh* mesh);
CLSDF_API void clsdf_mesh_release(clsdf_mesh* mesh);
CLSDF_API void clsdf_transform_retain(clsdf_transform* transform);
CLSDF_API void clsdf_transform_release(clsdf_transform* transform);
CLSDF_API void clsdf_scene_retain(clsdf_scene* scene);
CLSDF_API void clsdf_scene_release(clsdf_scene* scene);
CLSDF_API void clsdf_plan_retain(clsdf_plan* plan);
/* The last release waits for what the plan has enqueued. */
CLSDF_API void clsdf_plan_release(clsdf_plan* plan);
CLSDF_API void clsdf_sparse_plan_retain(clsdf_sparse_plan* plan);
CLSDF_API void clsdf_sparse_plan_release(clsdf_sparse_plan* plan);
CLSDF_API void clsdf_point_plan_retain(clsdf_point_plan* plan);
CLSDF_API void clsdf_point_plan_release(clsdf_point_plan* plan);
CLSDF_API void clsdf_link_plan_retain(clsdf_link_plan* plan);
CLSDF_API void clsdf_link_plan_release(clsdf_link_plan* plan);
CLSDF_API void clsdf_field_retain(clsdf_field* field);
CLSDF_API void clsdf_field_release(clsdf_field* field);
CLSDF_API void clsdf_sparse_field_retain(clsdf_sparse_field* field);
CLSDF_API void clsdf_sparse_field_release(clsdf_sparse_field* field);
CLSDF_API void clsdf_points_retain(clsdf_points* points);
CLSDF_API void clsdf_points_release(clsdf_points* points);
CLSDF_API void clsdf_cuda_device_retain(clsdf_cuda_device* device);
CLSDF_API void clsdf_cuda_device_release(clsdf_cuda_device* device);
CLSDF_API void clsdf_cuda_memory_retain(clsdf_cuda_memory* memory);
/* Memory is freed when its handle and the arrays that use it are released, which waits for the device. */
CLSDF_API void clsdf_cuda_memory_release(clsdf_cuda_memory* memory);
CLSDF_API void clsdf_cuda_arrays_retain(clsdf_cuda_arrays* arrays);
/* The last release is also clsdf_cuda_arrays_abandon(). Work that was enqueued goes on. */
CLSDF_API void clsdf_cuda_arrays_release(clsdf_cuda_arrays* arrays);
CLSDF_API void clsdf_thread_limit_retain(clsdf_thread_limit* limit);
CLSDF_API void clsdf_thread_limit_release(clsdf_thread_limit* limit);

#ifdef __cplusplus
}
#endif

#endif
