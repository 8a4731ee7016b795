#ifndef CLSDF_C_PLANS_H
#define CLSDF_C_PLANS_H

/*
 * Plans: fields, links and points that the device computes again and again.
 * A part of clsdf.h, which programs include; its rules hold.
 */

#include "arrays.h"
#include "calls.h"
#include "fields.h"
#include "grids.h"
#include "segments.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Plans ---- */

/* A plan has what it needs and may outlive the transform. Threads: one, in every call with a plan. */

/* A plan of one grid, without targets: clsdf_plan_enqueue_to() gives them, packed and aligned. With index base 1 the
 * triangle is CLSDF_UNSUPPORTED. */
CLSDF_API clsdf_status clsdf_plan_create(const clsdf_transform* transform, const clsdf_grid* grid,
                                         const clsdf_band* band, uint32_t outputs, const clsdf_call_options* call,
                                         clsdf_plan** plan);
/* Plans of boxes, into buffers of the device's context, which must outlive them. The structs need not. */
CLSDF_API clsdf_status clsdf_plan_create_requests(const clsdf_transform* transform, const clsdf_request* requests,
                                                  int64_t count, const clsdf_call_options* call, clsdf_plan** plan);
CLSDF_API clsdf_status clsdf_plan_create_blocks(const clsdf_transform* transform, const clsdf_block_set* blocks,
                                                const clsdf_call_options* call, clsdf_plan** plan);
/* The device memory of such a plan, which is made and given back. */
CLSDF_API clsdf_status clsdf_plan_bytes_requests(const clsdf_transform* transform, const clsdf_request* requests,
                                                 int64_t count, const clsdf_call_options* call, int64_t* bytes);
CLSDF_API clsdf_status clsdf_plan_bytes_blocks(const clsdf_transform* transform, const clsdf_block_set* blocks,
                                               const clsdf_call_options* call, int64_t* bytes);

/* Enqueues all requests on a cl_command_queue (null: the device's own) after the events. Never blocks. *done, if not
 * null, gets the cl_event of the end, which the caller releases; null after an error. */
CLSDF_API clsdf_status clsdf_plan_enqueue(clsdf_plan* plan, void* queue, void* const* wait_list, int64_t wait_count,
                                          void** done);
/* One run into other targets: targets[count], one for each request. */
CLSDF_API clsdf_status clsdf_plan_enqueue_to(clsdf_plan* plan, void* queue, const clsdf_targets* targets, int64_t count,
                                             void* const* wait_list, int64_t wait_count, void** done);
/* Prepares the next runs for the present positions of the transform, which made the plan or has its device, and has its
 * index base. Blocks.
 * After an error the plan must be updated again, but for requests or grids that are refused. */
CLSDF_API clsdf_status clsdf_plan_update(clsdf_plan* plan, const clsdf_transform* transform,
                                         const clsdf_call_options* call);
/* The same with a grid for each request. */
CLSDF_API clsdf_status clsdf_plan_update_grids(clsdf_plan* plan, const clsdf_transform* transform,
                                               const clsdf_grid* grids, int64_t count, const clsdf_call_options* call);
/* The same with other requests, any number. */
CLSDF_API clsdf_status clsdf_plan_update_requests(clsdf_plan* plan, const clsdf_transform* transform,
                                                  const clsdf_request* requests, int64_t count,
                                                  const clsdf_call_options* call);
CLSDF_API clsdf_status clsdf_plan_update_blocks(clsdf_plan* plan, const clsdf_transform* transform,
                                                const clsdf_block_set* blocks, const clsdf_call_options* call);
CLSDF_API clsdf_status clsdf_plan_sign(const clsdf_plan* plan, int32_t* rule);
/* Of making or updating it. */
CLSDF_API clsdf_status clsdf_plan_statistics(const clsdf_plan* plan, clsdf_statistics* statistics);
CLSDF_API clsdf_status clsdf_plan_request_count(const clsdf_plan* plan, int64_t* count);
/* Request `index` from 0. Its targets: the first `size` of *target_count. Pointers may be null. */
CLSDF_API clsdf_status clsdf_plan_request(const clsdf_plan* plan, int64_t index, clsdf_grid* grid, clsdf_band* band,
                                          clsdf_target* targets, int64_t size, int64_t* target_count);

/* A sparse field that stays in memory of the device: counts, bricks, runs and values have the bytes and the order of
 * clsdf_compute_sparse(), and a run reads nothing back. room: how many bricks and runs a run has room for. With index
 * base 1 the triangle is CLSDF_UNSUPPORTED. */
CLSDF_API clsdf_status clsdf_sparse_plan_create(const clsdf_transform* transform, const clsdf_sparse_request* request,
                                                const clsdf_sparse_counts* room, const clsdf_call_options* call,
                                                clsdf_sparse_plan** plan);
/* As clsdf_plan_enqueue(), into this memory. */
CLSDF_API clsdf_status clsdf_sparse_plan_enqueue(clsdf_sparse_plan* plan, void* queue,
                                                 const clsdf_sparse_buffers* buffers, void* const* wait_list,
                                                 int64_t wait_count, void** done);
/* As clsdf_plan_update(). */
CLSDF_API clsdf_status clsdf_sparse_plan_update(clsdf_sparse_plan* plan, const clsdf_transform* transform,
                                                const clsdf_call_options* call);
/* The same with another grid, band and outputs, and with other room. */
CLSDF_API clsdf_status clsdf_sparse_plan_update_request(clsdf_sparse_plan* plan, const clsdf_transform* transform,
                                                        const clsdf_sparse_request* request,
                                                        const clsdf_sparse_counts* room,
                                                        const clsdf_call_options* call);
/* Its field and its room. Pointers may be null. */
CLSDF_API clsdf_status clsdf_sparse_plan_request(const clsdf_sparse_plan* plan, clsdf_sparse_request* request,
                                                 clsdf_sparse_counts* room);
CLSDF_API clsdf_status clsdf_sparse_plan_sign(const clsdf_sparse_plan* plan, int32_t* rule);
/* Of making or updating it. */
CLSDF_API clsdf_status clsdf_sparse_plan_statistics(const clsdf_sparse_plan* plan, clsdf_statistics* statistics);

/* A plan of the links of a grid, whose runs write at most `room` rows into memory of the device, with the bytes of
 * clsdf_links(). The links are found when the plan is made or updated, on a GPU by kernels; a run reads nothing back.
 * With index base 1 triangles are CLSDF_UNSUPPORTED. */
CLSDF_API clsdf_status clsdf_link_plan_create(const clsdf_transform* transform, const clsdf_grid* grid,
                                              const int32_t* directions, int64_t direction_count, int64_t room,
                                              const clsdf_link_options* options, const clsdf_call_options* call,
                                              clsdf_link_plan** plan);
/* As clsdf_plan_enqueue(), into this memory. */
CLSDF_API clsdf_status clsdf_link_plan_enqueue(clsdf_link_plan* plan, void* queue, const clsdf_link_buffers* buffers,
                                               void* const* wait_list, int64_t wait_count, void** done);
/* As clsdf_plan_update(); after an error the plan is as it was. */
CLSDF_API clsdf_status clsdf_link_plan_update(clsdf_link_plan* plan, const clsdf_transform* transform,
                                              const clsdf_call_options* call);
/* The same with another grid and other room. */
CLSDF_API clsdf_status clsdf_link_plan_update_grid(clsdf_link_plan* plan, const clsdf_transform* transform,
                                                   const clsdf_grid* grid, int64_t room,
                                                   const clsdf_call_options* call);
/* Pointers may be null. */
CLSDF_API clsdf_status clsdf_link_plan_grid(const clsdf_link_plan* plan, clsdf_grid* grid, int64_t* room);
CLSDF_API clsdf_status clsdf_link_plan_sign(const clsdf_link_plan* plan, int32_t* rule);
/* Of making or updating it. */
CLSDF_API clsdf_status clsdf_link_plan_statistics(const clsdf_link_plan* plan, clsdf_statistics* statistics);

/* A plan of points: at most `count` of them at a time, in memory of the device. Its own memory is about 200 bytes a
 * point, of at most 2^20 points. With index base 1 the triangle is CLSDF_UNSUPPORTED. A mesh with a coordinate that is
 * not 0 and, in units of about 1/256 of its longest side, smaller than 2^-300 or greater than 2^300 is
 * CLSDF_INVALID_ARGUMENT. */
CLSDF_API clsdf_status clsdf_point_plan_create(const clsdf_transform* transform, int64_t count, double half_width,
                                               uint32_t outputs, const clsdf_call_options* call,
                                               clsdf_point_plan** plan);
/* Enqueues the search for points on a cl_command_queue (null: the device's own) after the events. Never blocks, and
 * nothing comes to the host; the bytes are those of clsdf_query(). Points, targets and status are buffers of the
 * device's context, of any offset and strides, one target for each output of the plan. status, which may be null: a
 * byte of each point, CLSDF_FOUND or why it has no distance. *done as of clsdf_plan_enqueue(). */
CLSDF_API clsdf_status clsdf_point_plan_enqueue(clsdf_point_plan* plan, void* queue, const clsdf_array* points,
                                                const clsdf_target* targets, int64_t target_count,
                                                const clsdf_array* status, void* const* wait_list, int64_t wait_count,
                                                void** done);
/* Prepares the next runs for the present positions of the transform, which made the plan or has its device, and has its
 * index base. Blocks. After an error the plan is as it was. */
CLSDF_API clsdf_status clsdf_point_plan_update(clsdf_point_plan* plan, const clsdf_transform* transform,
                                               const clsdf_call_options* call);
/* The most points of a run. */
CLSDF_API clsdf_status clsdf_point_plan_count(const clsdf_point_plan* plan, int64_t* count);
CLSDF_API clsdf_status clsdf_point_plan_sign(const clsdf_point_plan* plan, int32_t* rule);
/* Of making or updating it. */
CLSDF_API clsdf_status clsdf_point_plan_statistics(const clsdf_point_plan* plan, clsdf_statistics* statistics);

#ifdef __cplusplus
}
#endif

#endif
