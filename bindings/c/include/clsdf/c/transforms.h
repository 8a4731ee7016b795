#ifndef CLSDF_C_TRANSFORMS_H
#define CLSDF_C_TRANSFORMS_H

/*
 * Transforms: creation, parts of the domain, sharing between processes, motion.
 * A part of clsdf.h, which programs include; its rules hold.
 */

#include "arrays.h"
#include "calls.h"
#include "grids.h"
#include "meshes.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Transforms ---- */

typedef struct clsdf_transform_options {
    size_t struct_size;
    int32_t sign;       /* CLSDF_SIGN_AUTOMATIC ... */
    int32_t surface;    /* CLSDF_SURFACE_GIVEN, the default, or CLSDF_SURFACE_OUTER */
    int64_t kept_bytes; /* limit of the device memory kept between calls; 0: none; -1: the default */
    double floor;       /* of CLSDF_SIGN_BELOW, which needs one: z below all vertices; DBL_MAX, the default: none */
} clsdf_transform_options;
#define CLSDF_TRANSFORM_OPTIONS_INIT \
    { sizeof(clsdf_transform_options), CLSDF_SIGN_AUTOMATIC, CLSDF_SURFACE_GIVEN, -1, 1.7976931348623157e308 }

/* Memory that a transform keeps between calls, beside the mesh. */
typedef struct clsdf_kept_memory {
    size_t struct_size;
    int64_t host_bytes;
    int64_t device_bytes;
    /* All transforms of the device share these: clsdf_device_release_memory() gives them back. */
    int64_t shared_host_bytes;   /* for copies, most of it pinned */
    int64_t shared_device_bytes; /* that no transform uses */
} clsdf_kept_memory;
#define CLSDF_KEPT_MEMORY_INIT \
    { CLSDF_RESULT_SIZE(clsdf_kept_memory), 0, 0, 0, 0 }

/* A box of the domain, and what is asked in it. */
typedef struct clsdf_region {
    clsdf_box box;
    double half_width; /* the largest distance asked for; positive and finite */
    double spacing;    /* the largest spacing of grids; 0: only points and boxes */
} clsdf_region;

/* Copies and checks the mesh. Compiles nothing: the first call that needs a program does. A warning, such as that a
 * mesh with holes gets distances without a sign, goes to call->log alone: the library prints nothing. */
CLSDF_API clsdf_status clsdf_transform_create(const clsdf_device* device, const clsdf_mesh* mesh,
                                              const clsdf_transform_options* options, const clsdf_call_options* call,
                                              clsdf_transform** transform);
/* The same from arrays, which may be buffers of the device's context. The transform has its own copy: the arrays may go
 * when the call returns. */
CLSDF_API clsdf_status clsdf_transform_from_arrays(const clsdf_device* device, const clsdf_mesh_arrays* arrays,
                                                   const clsdf_transform_options* options,
                                                   const clsdf_call_options* call, clsdf_transform** transform);
/* A transform for a part of the domain, which keeps only what the regions need. Results have the bytes of the whole.
 * Calls outside the regions are CLSDF_INVALID_ARGUMENT; new positions are CLSDF_UNSUPPORTED, unless it has a margin. */
CLSDF_API clsdf_status clsdf_transform_restrict(const clsdf_transform* transform, const clsdf_region* regions,
                                                int64_t count, clsdf_transform** restricted);
/* The same of a part whose vertices may move by up to `margin`, in the mesh's units, from where they are now: its
 * clsdf_transform_set_positions() takes one position for each vertex that clsdf_transform_part_vertices() tells, and
 * results have the bytes of the whole at the same positions. A vertex farther than the margin is
 * CLSDF_INVALID_ARGUMENT, which names it. A transform of the outer surface is CLSDF_UNSUPPORTED. */
CLSDF_API clsdf_status clsdf_transform_restrict_with_margin(const clsdf_transform* transform,
                                                            const clsdf_region* regions, int64_t count, double margin,
                                                            clsdf_transform** restricted);
/* The vertices of a part with a margin, ascending, by their numbers in the mesh of the whole, from the index base of
 * the transform; of vertices with equal coordinates the lowest. *count of them, into `vertices`, which has room for
 * `room`. With vertices null and room 0 only *count is set; if the room is too small nothing is written, and *count is
 * set, too (CLSDF_INVALID_ARGUMENT). A transform without a margin is CLSDF_UNSUPPORTED. */
CLSDF_API clsdf_status clsdf_transform_part_vertices(const clsdf_transform* transform, uint32_t* vertices, int64_t room,
                                                     int64_t* count);

/* A restricted transform as bytes, for another process or for later: *count of them, into `bytes`, which has room for
 * `room`. With bytes null and room 0 only *count is set; if the room is too small nothing is written, and *count is
 * set, too (CLSDF_INVALID_ARGUMENT). A whole transform, or one of the outer surface, is CLSDF_UNSUPPORTED. */
CLSDF_API clsdf_status clsdf_transform_part_bytes(const clsdf_transform* transform, uint8_t* bytes, int64_t room,
                                                  int64_t* count);
/* The restricted transform of these bytes, without the mesh, on any device. They are of the same version of clsdf and
 * of this kind of machine; damaged or foreign bytes are CLSDF_INVALID_ARGUMENT. Their hash tells damage, not forgery.
 * kept_bytes: as of clsdf_transform_options; -1: the default. */
CLSDF_API clsdf_status clsdf_transform_from_part(const clsdf_device* device, const uint8_t* bytes, int64_t count,
                                                 int32_t index_base, int64_t kept_bytes, clsdf_transform** transform);

/* One copy of a prepared mesh for the processes of a node, in memory of the caller's that they share: POSIX shared
 * memory, a window of MPI, a mapped file. It begins at a multiple of 64 bytes.
 *
 * The size of that memory in bytes, about 640 for each triangle. Makes what is not made yet. A transform that is
 * restricted, has moved, or is of the outer surface is CLSDF_UNSUPPORTED. */
CLSDF_API clsdf_status clsdf_transform_prepared_bytes(const clsdf_transform* transform, int64_t* bytes);
/* Writes the prepared mesh into memory of so many bytes, its head last: until the call returns,
 * clsdf_transform_from_shared() refuses the memory. */
CLSDF_API clsdf_status clsdf_transform_share(const clsdf_transform* transform, void* memory, int64_t bytes);
/* A whole transform that reads the prepared mesh in place. The memory stays as it is, and may be read-only, until the
 * transform and its plans are destroyed. Memory without a complete transform, damaged, or of another version of clsdf
 * is CLSDF_INVALID_ARGUMENT: all of it is read once, and a hash tells damage, not forgery. A device with memory of its
 * own gets copies. kept_bytes: as of clsdf_transform_options; -1: the default. */
CLSDF_API clsdf_status clsdf_transform_from_shared(const clsdf_device* device, const void* memory, int64_t bytes,
                                                   int32_t index_base, int64_t kept_bytes, clsdf_transform** transform);

/* New positions of all vertices, on the host or in a buffer; of a part with a margin, of those that it has. After an
 * error the positions are those of before. */
CLSDF_API clsdf_status clsdf_transform_set_positions(clsdf_transform* transform, const clsdf_array* positions,
                                                     const clsdf_call_options* call);
/* Puts the vertices at R x + t; x are the positions that the transform was made with. rotation[9] has the rows of R.
 * Each element of R R^T may differ from the identity's by 1e-12, and det R > 0, else CLSDF_INVALID_ARGUMENT: a rotation
 * in floats, or a product of thousands of rotations, is farther off. Make R from an angle or a quaternion in double
 * precision, or make the rows of a product orthonormal again. */
CLSDF_API clsdf_status clsdf_transform_set_motion(clsdf_transform* transform, const double* rotation,
                                                  const double* translation);

/* The box of the vertices in use, at their present positions. */
CLSDF_API clsdf_status clsdf_transform_box(const clsdf_transform* transform, clsdf_box* box);
CLSDF_API clsdf_status clsdf_transform_topology(const clsdf_transform* transform, clsdf_topology* topology);
/* The rule in use, never automatic. */
CLSDF_API clsdf_status clsdf_transform_sign(const clsdf_transform* transform, int32_t* rule);
CLSDF_API clsdf_status clsdf_transform_index_base(const clsdf_transform* transform, int32_t* index_base);
/* A new reference. */
CLSDF_API clsdf_status clsdf_transform_device(const clsdf_transform* transform, clsdf_device** device);
CLSDF_API clsdf_status clsdf_transform_memory(const clsdf_transform* transform, clsdf_kept_memory* memory);
/* Builds and tests the programs that such a field needs. Computations do it by themselves. */
CLSDF_API clsdf_status clsdf_transform_compile(const clsdf_transform* transform, const clsdf_grid* grid,
                                               const clsdf_band* band, uint32_t outputs, const clsdf_call_options* call,
                                               clsdf_statistics* statistics);

#ifdef __cplusplus
}
#endif

#endif
