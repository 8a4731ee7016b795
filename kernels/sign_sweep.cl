// Inside or outside at every sample: the exact winding number by a sweep along x (METHOD, section 7 and 8.5).
//
// y and z of the vertices are snapped to multiples of 2^-b spacings, such that samples are exact: sample (j, k) lies at
// (j << bits_y, k << bits_z). A triangle projected along x covers a row (j, k) iff three edge functions, exact
// integers, say so; a row through an edge or a vertex counts as moved by (+epsilon, +epsilon^2) in (y, z), so that a
// closed mesh is crossed consistently by every row. The snapped mesh is combinatorially the same and differs by 2^-21
// voxel, hence so can the sign. Where the row meets the triangle is interpolated in double with the edge functions as
// weights: all are of one sign, nothing cancels. (The triangle's plane would be extrapolated on steep triangles.)
//
// Crossings are counted by row, scanned, scattered, sorted by row; a running sum of their orientation is the winding
// number.

#include "layout.h"
#include "sweep_vertex.h"

typedef struct Wide {  // hi 2^64 + lo
    long hi;
    ulong lo;
} Wide;

inline Wide wide_product(long a, long b) {
    Wide w;
    w.hi = mul_hi(a, b);
    w.lo = (ulong)a * (ulong)b;
    return w;
}

inline Wide wide_difference(Wide a, Wide b) {
    Wide w;
    w.lo = a.lo - b.lo;
    w.hi = a.hi - b.hi - (a.lo < b.lo ? 1 : 0);
    return w;
}

inline double wide_to_double(Wide w) {
    return (double)w.hi * 18446744073709551616.0 + (double)w.lo;
}

// Whether the sample (y, z), or its symbolic displacement where it lies on the line, is left of p -> q; the edge
// function is returned through `weight`. Products of 63 bits are enough where the triangle is small; `wide` takes 128.
inline bool left_of(SweepVertex p, SweepVertex q, long y, long z, bool wide, __private double* weight) {
    const long dy = q.y - p.y, dz = q.z - p.z;
    int sign;
    if (wide) {
        const Wide e = wide_difference(wide_product(dy, z - p.z), wide_product(dz, y - p.y));
        *weight = wide_to_double(e);
        sign = e.hi < 0 ? -1 : (e.hi > 0 || e.lo > 0 ? 1 : 0);
    } else {
        const long e = dy * (z - p.z) - dz * (y - p.y);
        *weight = (double)e;
        sign = e < 0 ? -1 : (e > 0 ? 1 : 0);
    }
    return sign > 0 || (sign == 0 && (dz < 0 || (dz == 0 && dy > 0)));
}

inline Wide twice_area(SweepVertex a, SweepVertex b, SweepVertex c) {
    return wide_difference(wide_product(b.y - a.y, c.z - a.z), wide_product(b.z - a.z, c.y - a.y));
}

// One work-item a triangle of [begin, end) and a strip of the part's slices. With `fill` 0 it counts crossings by row;
// with 1 it writes their keys, `cursors` being where each row's begin. Key: 2 k + (1 where the surface faces -x there),
// k the first sample at or after the crossing, counted from the first brick's first sample and clamped to [0,
// row_length].
__kernel void sign_crossings(Layout layout, uint begin, uint end, __global const uint* triangles,
                             __global const SweepVertex* vertices, int bits_y, int bits_z, __global uint* cursors,
                             __global uint* keys, int fill) {
    const uint t = begin + get_global_id(0);
    const uint strip = get_global_id(1), strips = get_global_size(1);
    if (t >= end) return;
    SweepVertex a = vertices[triangles[3 * t]], b = vertices[triangles[3 * t + 1]], c = vertices[triangles[3 * t + 2]];
    const long low_y = min(a.y, min(b.y, c.y)), high_y = max(a.y, max(b.y, c.y));
    const long low_z = min(a.z, min(b.z, c.z)), high_z = max(a.z, max(b.z, c.z));
    const long first_y = (long)layout.brick_first[1] * CLSDF_BRICK, first_z = (long)layout.brick_first[2] * CLSDF_BRICK;
    const long rows_y = (long)layout.bricks[1] * CLSDF_BRICK, rows_z = (long)layout.bricks[2] * CLSDF_BRICK;
    const long begin_y = max(first_y, -((-low_y) >> bits_y)), end_y = min(first_y + rows_y - 1, high_y >> bits_y);
    const long begin_z = max(first_z + rows_z * strip / strips, -((-low_z) >> bits_z)),
               end_z = min(first_z + rows_z * (strip + 1) / strips - 1, high_z >> bits_z);
    if (begin_y > end_y || begin_z > end_z) return;

    const Wide area = twice_area(a, b, c);
    if (area.hi == 0 && area.lo == 0) return;
    const uint faces_back = area.hi < 0;
    if (faces_back) {
        const SweepVertex swap = b;
        b = c;
        c = swap;
    }
    const bool wide = high_y - low_y >= (1L << 30) || high_z - low_z >= (1L << 30);
    const long first_x = (long)layout.brick_first[0] * CLSDF_BRICK, row_length = (long)layout.bricks[0] * CLSDF_BRICK;
    for (long z = begin_z; z <= end_z; ++z)
        for (long y = begin_y; y <= end_y; ++y) {
            double wa, wb, wc;
            if (!left_of(b, c, y << bits_y, z << bits_z, wide, &wa) ||
                !left_of(c, a, y << bits_y, z << bits_z, wide, &wb) ||
                !left_of(a, b, y << bits_y, z << bits_z, wide, &wc))
                continue;
            const size_t row = (size_t)(z - first_z) * rows_y + (y - first_y);
            const uint slot = atomic_inc(cursors + row);
            if (!fill) continue;
            const double x = (wa * a.x + wb * b.x + wc * c.x) / (wa + wb + wc);
            const double sample = clamp(ceil(x) - (double)first_x, 0.0, (double)row_length);
            keys[slot] = 2 * (uint)sample + faces_back;
        }
}

// Sorts keys[0, count); rows have few crossings as a rule, and n log n operations where they have many.
inline void sort_keys(__global uint* keys, uint count) {
    if (count <= 16) {
        for (uint i = 1; i < count; ++i) {
            const uint key = keys[i];
            uint j = i;
            for (; j > 0 && keys[j - 1] > key; --j) keys[j] = keys[j - 1];
            keys[j] = key;
        }
        return;
    }
    // Heap sort.
    for (uint heap = count, root = count / 2; heap > 1;) {
        if (root > 0) {
            --root;
        } else {
            --heap;
            const uint top = keys[0];
            keys[0] = keys[heap];
            keys[heap] = top;
        }
        const uint key = keys[root];
        uint parent = root;
        for (uint child = 2 * parent + 1; child < heap; child = 2 * parent + 1) {
            if (child + 1 < heap && keys[child + 1] > keys[child]) ++child;
            if (keys[child] <= key) break;
            keys[parent] = keys[child];
            parent = child;
        }
        keys[parent] = key;
    }
}

// One work-item a row, of [begin_row, end_row), of samples of the part's bricks: its sign bits, 1 inside.
__kernel void sign_rows(Layout layout, uint begin_row, uint end_row, int parity, __global const uint* starts,
                        __global uint* keys, __global uint* sign_bits) {
    const uint row = begin_row + get_global_id(0);
    if (row >= end_row) return;
    __global uint* bits = sign_bits + (size_t)row * layout.sign_words;
    const uint begin = starts[row], count = starts[row + 1] - begin;
    __global uint* own = keys + begin;
    sort_keys(own, count);
    uint next = 0;
    int winding = 0;
    for (int word = 0; word < layout.sign_words; ++word) {
        // Runs of samples between crossings; a word without any is written at once.
        uint value = 0;
        uint from = 0;  // bit of the word from which `winding` holds
        while (next < count && (own[next] >> 1) < (uint)(word + 1) * 32) {
            const uint at = (own[next] >> 1) - (uint)word * 32;
            const bool inside = parity ? (winding & 1) : winding != 0;
            if (inside && at > from) value |= (at - from == 32 ? 0xFFFFFFFFu : ((1u << (at - from)) - 1u)) << from;
            from = at;
            winding += (own[next] & 1u) ? 1 : -1;
            ++next;
        }
        const bool inside = parity ? (winding & 1) : winding != 0;
        if (inside && from < 32) value |= 0xFFFFFFFFu << from;
        bits[word] = value;
    }
}
