// A brick's 32 sub-blocks of 4 x 2 x 2 samples, each one or two vectors: x runs fastest over the samples, then y, then
// z.
//
// They are numbered with y running fastest and x slowest, so that those of one x, a plane of 4 x 4, are whole vectors
// of blocks. Sub-blocks of 2 x 2 x 2 would save distances, but double the tests, and take longer.
#ifndef CLSDF_SUBBLOCKS_H
#define CLSDF_SUBBLOCKS_H

#include "bits.h"
#include "lanes.h"
#include "layout.h"

#define SUBBLOCK_X 4
#define SUBBLOCK_SAMPLES 16
#define SUBBLOCK_VECTORS (SUBBLOCK_SAMPLES / LANES)
#define SUBBLOCK_PLANES (CLSDF_BRICK / SUBBLOCK_X)
#define SUBBLOCK_PLANE 16
#define SUBBLOCKS (SUBBLOCK_PLANES * SUBBLOCK_PLANE)

// A bit a sub-block.
typedef uint SubblockMask;

// Positions of the samples of a sub-block's v-th vector, relative to its centre.
#define LANE_I (convert_floatL(LANE_NUMBERS % SUBBLOCK_X) - 0.5f * (SUBBLOCK_X - 1))
#define LANE_J (convert_floatL(LANE_NUMBERS / SUBBLOCK_X % 2) - 0.5f)
#define LANE_K(v) (convert_floatL((LANE_NUMBERS + (v)*LANES) / (2 * SUBBLOCK_X)) - 0.5f)

// Positions of the sub-blocks' centres relative to the brick's: x of those of a plane; y and z of sub-block b, and of
// the v-th vector of a plane.
static inline float subblock_i(uint plane) {
    return (float)(plane * SUBBLOCK_X) - 0.5f * (CLSDF_BRICK - SUBBLOCK_X);
}
static inline float subblock_j(uint b) {
    return (float)(b % 4 * 2) - 0.5f * (CLSDF_BRICK - 2);
}
static inline float subblock_k(uint b) {
    return (float)(b % SUBBLOCK_PLANE / 4 * 2) - 0.5f * (CLSDF_BRICK - 2);
}
static inline floatL subblocks_j(uint v) {
    return convert_floatL((LANE_NUMBERS + v * LANES) % 4 * 2) - 0.5f * (CLSDF_BRICK - 2);
}
static inline floatL subblocks_k(uint v) {
    return convert_floatL((LANE_NUMBERS + v * LANES) / 4 * 2) - 0.5f * (CLSDF_BRICK - 2);
}

// Positions of the samples of the v-th vector of sub-block b, relative to the brick's centre.
static inline floatL samples_i(uint b) {
    return LANE_I + subblock_i(b / SUBBLOCK_PLANE);
}
static inline floatL samples_j(uint b) {
    return LANE_J + subblock_j(b);
}
static inline floatL samples_k(uint b, uint v) {
    return LANE_K(v) + subblock_k(b);
}

#endif
