#ifndef CLSDF_H
#define CLSDF_H

/*
 * clsdf in C99: exact signed distance fields of triangle meshes with OpenCL. docs/c.md has whole programs; the C++
 * headers and docs/library.md define what is computed. The library is libclsdf_c; clsdf_io.h has files of fields.
 *
 * STATUS. A function returns a status: 0 (CLSDF_OK), else a number of clsdf/c/basics.h, and clsdf_last_error() has the
 * message. Functions that cannot fail return their value. A handle or pointer that is null, a handle of another kind,
 * an enumerator out of range, a negative count and a struct of a wrong size are CLSDF_INVALID_ARGUMENT, unless a
 * comment allows them. A call that fails sets the handle that it would make to null; its other results are undefined.
 * Nothing here ends the process on purpose, and no exception leaves; but pointers are not checked beyond null. A wrong
 * address, a handle after its last release, or a void * that is no object of OpenCL is undefined: drivers crash on it.
 *
 * HANDLES are counted references. A function that makes one gives it to the caller, who releases it. Null may be
 * retained and released. An object keeps alive what it needs: a transform its device, for instance. Any number of
 * threads may retain and release a handle, and may use different handles. "Threads: any number" means that threads may
 * use one handle in that call at once; "Threads: one" that no other call may use the handle during that call.
 *
 * STRUCTS. Those that begin with struct_size may grow in later versions: set them with their _INIT macro, then change
 * members. A smaller struct of an older program is accepted, a larger one (up to 4096 bytes) if the bytes that this
 * version does not know are 0. Null means defaults for options, and "not wanted" for results. A struct that calls only
 * fill has an odd struct_size, CLSDF_RESULT_SIZE(type), so that it is never taken for options, nor options for it. The
 * other structs never change. Members called `reserved` must be 0.
 *
 * UNITS. Lengths and positions are in the mesh's units unless a comment says otherwise; counts, indices, offsets and
 * strides are int64_t; sizes, offsets and strides are in bytes.
 *
 * TEXTS are UTF-8 and end with 0. A call that gives one writes it to text[size] with its ending 0, cut if it is too
 * long; *length, if not null, is that of the whole text. `text` may be null if size is 0.
 *
 * TRANSFORMS. Threads: calls with a const transform any number; their work takes turns on the device. Others: one.
 * Triangles of outputs count from the mesh's index base: beyond the band they are -1 with base 0 and 0 with base 1.
 * With base 1 they cost one more pass over the output, and the output must lie on the host: in a buffer, and so in a
 * plan, it is CLSDF_UNSUPPORTED.
 *
 * OPENCL. This header needs none of OpenCL's: a cl_mem, cl_event, cl_context, cl_device_id or cl_command_queue is a
 * void *.
 *
 * CALLBACKS get the `user` pointer of their struct. Unless a comment says otherwise they run on the calling thread, and
 * before the call returns. One that returns a number other than 0 ends the call, which returns that number unchanged: a
 * status of this header, as of a call that failed in the callback, or a number of the program's own from
 * CLSDF_OWN_STATUS on. Other numbers may become statuses of later versions. The message is that of the callback's last
 * failed call, or of its clsdf_set_last_error(). Callbacks must not make or use a transform or plan of the same device:
 * a call that would wait for theirs returns CLSDF_INVALID_ARGUMENT. Only the function that takes slabs may use the
 * transform.
 */

/* Version, status and other numbers, errors, handles */
#include "clsdf/c/basics.h"
/* Arrays in the caller's memory, and outputs */
#include "clsdf/c/arrays.h"
/* Boxes, lengths, bands, grids */
#include "clsdf/c/grids.h"
/* Devices of OpenCL, and threads of the host */
#include "clsdf/c/devices.h"
/* Options and results of calls */
#include "clsdf/c/calls.h"
/* Meshes: arrays, files, topology, welding, groups, outer surfaces */
#include "clsdf/c/meshes.h"
/* Transforms: creation, parts of the domain, sharing between processes, motion */
#include "clsdf/c/transforms.h"
/* Fields: dense and sparse, in the caller's arrays and in the library's memory */
#include "clsdf/c/fields.h"
/* Distances at points, places of boxes, winding numbers, files of points */
#include "clsdf/c/points.h"
/* Scenes: many bodies with poses, their fields, and points among them */
#include "clsdf/c/scenes.h"
/* Links of a grid, crossings of its edges, rays */
#include "clsdf/c/segments.h"
/* Fractions of cells that a mesh fills */
#include "clsdf/c/fractions.h"
/* Plans: fields, links and points that the device computes again and again */
#include "clsdf/c/plans.h"
/* Memory of CUDA as inputs and outputs */
#include "clsdf/c/cuda.h"

#endif
