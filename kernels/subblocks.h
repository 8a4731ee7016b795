// A brick's sub-blocks of SUBBLOCK_X x 2 x 2 samples, each a vector: x runs fastest over the lanes, then y.
//
// They are numbered with y running fastest and x slowest, so that those of one x, a plane of 4 x 4, are whole vectors
// of blocks.
#ifndef CLSDF_SUBBLOCKS_H
#define CLSDF_SUBBLOCKS_H

#include "bits.h"
#include "lanes.h"
#include "layout.h"

#define SUBBLOCK_X (LANES / 4)
#define SUBBLOCKS_X (CLSDF_BRICK / SUBBLOCK_X)
#define SUBBLOCK_PLANE 16
#define SUBBLOCKS (SUBBLOCKS_X * SUBBLOCK_PLANE)

// A bit a sub-block.
#if LANES == 16
typedef uint SubblockMask;
#define lowest_subblock lowest_bit
#else
typedef ulong SubblockMask;
#define lowest_subblock lowest_bit_of_long
#endif

// Where a sub-block's samples lie from its centre.
#define LANE_I (convert_floatL(LANE_NUMBERS % SUBBLOCK_X) - 0.5f * (SUBBLOCK_X - 1))
#define LANE_J (convert_floatL(LANE_NUMBERS / SUBBLOCK_X % 2) - 0.5f)
#define LANE_K (convert_floatL(LANE_NUMBERS / (2 * SUBBLOCK_X)) - 0.5f)

// Where the sub-blocks' centres lie from the brick's: x of those of a plane; y and z of the v-th vector of a plane.
static inline float subblock_i(uint plane) {
    return (float)(plane * SUBBLOCK_X) - 0.5f * (CLSDF_BRICK - SUBBLOCK_X);
}
static inline floatL subblocks_j(uint v) {
    return convert_floatL((LANE_NUMBERS + v * LANES) % 4 * 2) - 0.5f * (CLSDF_BRICK - 2);
}
static inline floatL subblocks_k(uint v) {
    return convert_floatL((LANE_NUMBERS + v * LANES) / 4 * 2) - 0.5f * (CLSDF_BRICK - 2);
}

// Where the samples of sub-block b lie from the brick's centre.
static inline floatL samples_i(uint b) {
    return LANE_I + subblock_i(b / SUBBLOCK_PLANE);
}
static inline floatL samples_j(uint b) {
    return LANE_J + ((float)(b % 4 * 2) - 0.5f * (CLSDF_BRICK - 2));
}
static inline floatL samples_k(uint b) {
    return LANE_K + ((float)(b % SUBBLOCK_PLANE / 4 * 2) - 0.5f * (CLSDF_BRICK - 2));
}

#endif
