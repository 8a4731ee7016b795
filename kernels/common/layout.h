// One definition for the host and the kernels: where a part of the lattice and its bricks lie.
//
// A brick is 8 x 8 x 8 samples, a coarse brick 4 x 4 x 4 bricks; both tile the lattice from its sample (0, 0, 0),
// whatever part of it is computed. Bricks and coarse bricks of the part are numbered with x running fastest.
#ifndef CLSDF_LAYOUT_H
#define CLSDF_LAYOUT_H

#include "polyhedron.h"

#define CLSDF_BRICK 8
#define CLSDF_COARSE 32
#define CLSDF_BRICKS_PER_COARSE 4
// The bricks of a coarse brick. A mask of 64 bits has one bit per brick.
#define CLSDF_COARSE_BRICKS 64

// The minima of a brick: of each sample a squared distance and, if more is asked for than that, the number of the
// nearest polyhedron.
#define CLSDF_MINIMUM_BYTES(with_nearest) (CLSDF_BRICK * CLSDF_BRICK * CLSDF_BRICK * ((with_nearest) ? 8 : 4))

// The vector body takes so many polyhedra of a coarse brick's list at a time.
#define CLSDF_LIST_PART 2048
// A work-item's own memory there: a bit for each polyhedron and each brick, and two lists, each with
// room for a vector.
#define CLSDF_SCRATCH_BYTES (CLSDF_COARSE_BRICKS * CLSDF_LIST_PART / 8 + 2 * 4 * (CLSDF_LIST_PART + 16))

// The nearest triangle of a sample beyond the band, and the nearest polyhedron of one that none holds.
#define CLSDF_NO_TRIANGLE 0xFFFFFFFFu
#define CLSDF_NO_POLYHEDRON 0xFFFFFFFFu

// A brick's mark is 0 until it is computed. Bricks with this one need not be computed and are not filled.
#define CLSDF_UNWANTED_BRICK 2
// A sparse field: the mark of a brick without values that is inside. One that is outside keeps the mark 0.
#define CLSDF_INSIDE_BRICK 3

// The stored bricks of a sparse field, which have values: three counts, then from CLSDF_STORED on the bricks' numbers.
// The values of brick listed[CLSDF_STORED + n] of the part are at n in the arrays of outputs, 512 samples with x
// running fastest. A dense field has no such array.
#define CLSDF_STORED_COUNT 0    // how many there are; those beyond the room are only counted
#define CLSDF_STORED_ROOM 1     // how many there is room for
#define CLSDF_STORED_IN_BAND 2  // the first ones, which have samples of the band; the others have both signs only
#define CLSDF_STORED 4
#define CLSDF_BRICK_SAMPLES 512

// The counters of the counting variant of the kernels, a set for each work-item.
#define CLSDF_COUNT_BRICK_PAIRS 0
#define CLSDF_COUNT_LANES 1
#define CLSDF_COUNT_COVERED 2
#define CLSDF_COUNT_BAND 3
#define CLSDF_COUNTERS 4

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

typedef struct Layout {
    clsdf_int32 first[3];         // the part's first sample
    clsdf_int32 size[3];          // its samples, x, y, z
    clsdf_int32 brick_first[3];   // the first brick that overlaps it, in bricks of the lattice
    clsdf_int32 bricks[3];        // how many bricks overlap it, per axis
    clsdf_int32 coarse_first[3];  // the same in coarse bricks
    clsdf_int32 coarse_bricks[3];
    clsdf_int32
        sign_words;  // 32-bit words a row of sign bits has; bit 0 of a row is the part's first brick's first sample

    // Lengths in units (see `unit`).
    float half_width;      // of the band, the larger side; a finite bound if the band is infinite
    float inside_squared;  // squared half widths, possibly infinite
    float outside_squared;
    float slack_rate;  // slack of a test = slack of its level + slack_rate * bound
    float brick_slack;
    float coarse_slack;
    float brick_radius;  // distance from a brick's centre to its farthest sample
    float coarse_radius;
    float spacing[3];

    // The kernels' unit of length in the mesh's units: the greatest power of two that is not above the voxel, so that
    // results are scaled without rounding.
    float unit;
    float inside_fill;  // -inside and outside, as written beyond the band, in the mesh's units
    float outside_fill;
    float least_inside;  // exact signs: the least distance of a sample that is inside, in the mesh's units; else 0
} Layout;

// The group body looks at so many entries of a list together.
#define CLSDF_WINDOW(group) (4 * (group))

// The group body: the bricks of a coarse brick, a work-group each. A long list is shared, since a launch takes at least
// as long as its longest group.
typedef struct BrickTask {
    clsdf_uint32 slot;    // of the coarse brick in the order
    clsdf_uint32 shares;  // of its list
    clsdf_uint32 share;   // 0 to shares - 1: takes the windows share, share + shares, ...; shares: joins their minima
    clsdf_uint32 minima;  // where those of share 0 are stored, in sets for CLSDF_COARSE_BRICKS bricks
    clsdf_uint32 window;  // entries of a window, CLSDF_WINDOW at most
} BrickTask;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(BrickTask) == 20);
static_assert(sizeof(Layout) == 136);
static_assert(offsetof(Layout, sign_words) == 72);
static_assert(offsetof(Layout, unit) == 120);
}  // namespace clsdf
#endif

#endif
