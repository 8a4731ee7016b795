// The volume that a mesh encloses: the sums of encloses_negative_volume() (lib/engine/surface/volume.cpp), in its
// order.
#ifndef CLSDF_MESH_VOLUME_H
#define CLSDF_MESH_VOLUME_H

#include "mesh_boxes.h"
#include "paired_edges.h"

#pragma OPENCL FP_CONTRACT OFF

// The faces, in the caller's order, are divided by halves into leaves; a
// work-item has a leaf. sums: a sum and the sum of magnitudes of each of 2^levels leaves, zeros if a larger range is a
// leaf.
__kernel void sum_volumes(TopologySizes sizes, uint levels, __global const double* positions,
                          __global const uint* triangles, __global const TopologyResults* results,
                          __global double* sums) {
    const uint leaf = get_global_id(0);
    if (leaf >= 1u << levels) return;
    double centre[3], half_side = 0.0;
    for (uint axis = 0; axis < 3; ++axis) {
        const double lower = results->box[axis], upper = results->box[3 + axis];
        centre[axis] = 0.5 * lower + 0.5 * upper;
        const double half_of_axis = 0.5 * upper - 0.5 * lower;
        half_side = GREATER(half_of_axis, half_side);
    }
    const double inverse = 1.0 / half_side, scale = half_side > 0.0 ? LESSER(inverse, 1e300) : 0.0;
    uint begin = 0, end = sizes.faces;
    for (uint level = levels; level-- > 0;) {
        const bool is_second = leaf >> level & 1u;
        if (end - begin <= CLSDF_VOLUME_LEAF) {
            if (is_second) end = begin;
            continue;
        }
        const uint middle = begin + (end - begin) / 2;
        if (is_second)
            begin = middle;
        else
            end = middle;
    }
    double sum = 0.0, magnitude = 0.0;
    for (uint face = begin; face < end; ++face) {
        double at[3][3];
        for (uint corner = 0; corner < 3; ++corner) {
            const double3 p = position(positions, triangles[3 * (size_t)face + corner]);
            at[corner][0] = (p.x - centre[0]) * scale;
            at[corner][1] = (p.y - centre[1]) * scale;
            at[corner][2] = (p.z - centre[2]) * scale;
        }
        for (uint i = 0; i < 3; ++i) {
            const uint j = next_of(i), k = previous_of(i);
            const double first = at[1][j] * at[2][k], second = at[1][k] * at[2][j];
            sum += at[0][i] * (first - second);
            magnitude += fabs(at[0][i]) * (fabs(first) + fabs(second));
        }
    }
    sums[2 * (size_t)leaf] = sum;
    sums[2 * (size_t)leaf + 1] = magnitude;
}

// One group.
__kernel GROUP_OF_KERNEL void join_volumes(uint levels, __global double* sums, __global TopologyResults* results) {
    const uint leaves = 1u << levels;
    for (uint apart = 1; apart < leaves; apart *= 2) {
        for (uint leaf = get_local_id(0) * 2 * apart; leaf < leaves; leaf += GROUP * 2 * apart) {
            sums[2 * (size_t)leaf] += sums[2 * (size_t)(leaf + apart)];
            sums[2 * (size_t)leaf + 1] += sums[2 * (size_t)(leaf + apart) + 1];
        }
        barrier(CLK_GLOBAL_MEM_FENCE);
    }
    if (get_local_id(0) != 0) return;
    results->volume[0] = sums[0];
    results->volume[1] = sums[1];
}

#endif
