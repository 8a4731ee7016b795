// The winding number of a point in each of the eight looks (segment_crossings.h), as lib/segments/walk.hpp has it; for
// parity the number of crossings.
#ifndef CLSDF_LOOK_WINDINGS_H
#define CLSDF_LOOK_WINDINGS_H

#include "simd.h"

typedef struct LookWindings {
    int of_looks[8];
} LookWindings;

INLINE void add_to_looks(__private LookWindings* at, uint looks, int change) {
    for (uint look = 0; look < 8; ++look) at->of_looks[look] += looks >> look & 1u ? change : 0;
}

// In every look, so that a point on a wall is outside.
INLINE bool are_inside(__private const LookWindings* at, int parity) {
    bool are = true;
    for (uint look = 0; look < 8; ++look)
        are = are && (parity ? (at->of_looks[look] & 1) != 0 : at->of_looks[look] != 0);
    return are;
}

// A key of a row's crossing: from that sample on, counted in the row, the winding number is another one.
#define CLSDF_CROSSING_KEY(sample, looks, is_up) ((uint)(sample) << 9 | (looks) << 1 | (is_up))
#define CLSDF_SAMPLE_OF_CROSSING(key) ((key) >> 9)

INLINE void add_crossing(__private LookWindings* at, uint key) {
    add_to_looks(at, key >> 1 & 0xFFu, key & 1u ? 1 : -1);
}

#endif
