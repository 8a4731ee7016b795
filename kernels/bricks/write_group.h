// Writes the samples of a brick of a work-group into the field, dense or sparse.
#ifndef CLSDF_WRITE_GROUP_H
#define CLSDF_WRITE_GROUP_H

#include "group_batches.h"
#include "sample_values.h"
#ifdef NEAREST
#include "finish.h"
#endif

// The place of a brick in the list of a sparse field, or CLSDF_NOT_STORED if no sample of it is in the band or there
// is no more room. number: the brick's in the part. All work-items get the same.
#define CLSDF_NOT_STORED 0xFFFFFFFFu
static inline uint list_brick(Layout layout, int3 relative_brick, size_t number, __global const uint* sign_bits,
                              __private const ItemMinimum* minimum, __global uchar* computed, __global uint* listed,
                              __local uint* shared) {
    const uint item = get_local_id(0);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item == 0) *shared = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    bool has_band = false;
    for (uint s = 0; s < SAMPLES_PER_ITEM; ++s) {
        const uint sample = s * GROUP + item;
        const int3 in_bricks =
            relative_brick * CLSDF_BRICK + sample_of(sample / SMALL_SUBBLOCK_SAMPLES, sample % SMALL_SUBBLOCK_SAMPLES);
        const bool negative = is_inside(sign_row(layout, sign_bits, in_bricks.y, in_bricks.z), in_bricks.x);
        bool in_band;
        signed_distance(layout, negative, minimum->squared[s], &in_band);
        has_band = has_band || in_band;
    }
    if (has_band) atomic_or(shared, 1u);
    barrier(CLK_LOCAL_MEM_FENCE);
    const bool is_listed = *shared != 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item == 0) {
        uint at = CLSDF_NOT_STORED;
        if (is_listed) {
            computed[number] = 1;
            at = atomic_inc(listed + CLSDF_STORED_COUNT);
            if (at < listed[CLSDF_STORED_ROOM])
                listed[CLSDF_STORED + at] = (uint)number;
            else
                at = CLSDF_NOT_STORED;
        }
        *shared = at;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    return *shared;
}

// Writes the work-item's samples. relative_brick: the brick's position in the part. at: its place in the list of a
// sparse field, or CLSDF_NOT_STORED in a dense one.
static inline void write_samples(Layout layout, Brick brick, int3 relative_brick, uint at,
                                 __global const uint* sign_bits, __private const ItemMinimum* minimum,
                                 __global float* distance,
#ifdef NEAREST
                                 __local const BrickMinima* minima, __private const Finishing* finishing,
#endif
                                 __private uint* counters) {
    const int3 part_first = vload3(0, layout.first), size = vload3(0, layout.size);
    for (uint s = 0; s < SAMPLES_PER_ITEM; ++s) {
        const uint sample = s * GROUP + get_local_id(0);
        const int3 in_brick = sample_of(sample / SMALL_SUBBLOCK_SAMPLES, sample % SMALL_SUBBLOCK_SAMPLES);
        const int3 to = brick.first + in_brick - part_first;
        const bool is_sparse = at != CLSDF_NOT_STORED;
        if (!is_sparse && (any(to < 0) || any(to >= size))) continue;
        const int3 in_bricks = relative_brick * CLSDF_BRICK + in_brick;
        const bool negative = is_inside(sign_row(layout, sign_bits, in_bricks.y, in_bricks.z), in_bricks.x);
        const size_t offset = is_sparse ? (size_t)at * CLSDF_BRICK_SAMPLES +
                                              (in_brick.z * CLSDF_BRICK + in_brick.y) * CLSDF_BRICK + in_brick.x
                                        : sample_offset(layout, to.x, to.y, to.z);
#ifdef NEAREST
        const float squared = minima->squared[sample];
#else
        const float squared = minimum->squared[s];
#endif
        bool in_band;
        const float value = signed_distance(layout, negative, squared, &in_band);
#ifdef NEAREST
        if (!IS_DOUBLE(finishing, distance)) distance[offset] = value;
        if (in_band && minima->polyhedron[sample] != CLSDF_NO_POLYHEDRON) {
            finish_sample(finishing, to + part_first, minima->polyhedron[sample], negative, offset);
        } else {
            if (IS_DOUBLE(finishing, distance)) finishing->of_distance[offset] = distance_beyond(finishing, negative);
            leave_sample(finishing, offset);
        }
#else
        distance[offset] = value;
#endif
#ifdef COUNT
        counters[CLSDF_COUNT_BAND] += in_band;
#endif
    }
}

#endif
