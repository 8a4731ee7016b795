// The pieces that cut each slice, by count, scan, fill: no other slice of a piece is ever looked at.
//
// Each work-item takes a contiguous range of pieces and counts into a histogram of its own, so that no atomics are
// needed and the lists are in the order of the pieces, whatever the number of work-items:
//   counts[(slice - the part's first) * parts + part], scanned, is where a part's entries of a slice begin.

#include "piece.h"

// Slices [begin, end) of the lattice. With `fill` 0 it counts; with 1 it writes (piece, slice), `counts` being where
// each part's entries begin, `base` entries before the first of `active`.
__kernel void slices_active(Layout layout, uint count, __global const Piece* pieces, int begin, int end,
                            __global uint* counts, __global uint2* active, uint base, int fill) {
    const uint part = get_global_id(0), parts = get_global_size(0);
    const uint last = (uint)((ulong)count * (part + 1) / parts);
    for (uint i = (uint)((ulong)count * part / parts); i < last; ++i) {
        const int slice_end = min(pieces[i].slice_end, end);
        for (int slice = max(pieces[i].slice_begin, begin); slice < slice_end; ++slice) {
            const uint slot = counts[(size_t)(slice - layout.first[2]) * parts + part]++;
            if (fill) active[slot - base] = (uint2)(i, as_uint(slice));
        }
    }
}
