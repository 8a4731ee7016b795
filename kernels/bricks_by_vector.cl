// The seven-site distance of every sample near the mesh: one work-item takes coarse bricks from a queue, the costliest
// first, and carries each through all finer levels, so that lists of (polyhedron, brick) pairs never leave the cache.
//
//   coarse brick: an upper bound of the distance for each of its bricks (cap); a mask of touched bricks per polyhedron;
//   brick:        its list; for CHUNK polyhedra at a time, a mask of touched sub-blocks (one vector of samples each);
//   sub-block:    its list; the distance to each triangle of it, the minimum kept in registers.
//
// Compile-time options: LANES (lanes.h); NEAREST keeps the nearest triangle; LONG_BRICKS where spacing is so unequal
// that distances take double (distance.h); COUNT counts work.

#include "blocks.h"
#include "distance.h"
#include "lane_polyhedra.h"

#define SUBBLOCK_X (LANES / 4)
#define SUBBLOCKS_X (CLSDF_BRICK / SUBBLOCK_X)
#define SUBBLOCKS (512 / LANES)
#define CHUNK 128
#define LIST_ROOM (CHUNK + LANES)

#if LANES == 16
typedef ushort LaneMask;
#else
typedef uchar LaneMask;
#endif

#ifdef COUNT
#define COUNT_ADD(counter, n) counters[counter] += (n)
#else
#define COUNT_ADD(counter, n)
#endif

// Sub-blocks are SUBBLOCK_X x 2 x 2 samples; number b of a brick lies at (b % SUBBLOCKS_X, b / SUBBLOCKS_X % 4, ...).
// Offsets of its first sample from the brick's centre:
inline float subblock_x(uint b) {
    return (float)(b % SUBBLOCKS_X * SUBBLOCK_X) - 3.5f;
}
inline float subblock_y(uint b) {
    return (float)(b / SUBBLOCKS_X % 4 * 2) - 3.5f;
}
inline float subblock_z(uint b) {
    return (float)(b / (SUBBLOCKS_X * 4) * 2) - 3.5f;
}

// Writes the lanes of `numbers` whose bit is set, in order; returns how many. There is room for all lanes.
#if LANES == 16 && defined(__AVX512F__)
#define WRITE_CHOSEN                                                                                                  \
    store_lanes(as_uint16(__builtin_ia32_compresssi512_mask(as_int16(numbers), (int16)(0), (ushort)bits)), 0, chosen); \
    return popcount(bits);
#else
#define WRITE_CHOSEN                                    \
    uint each[LANES];                                   \
    store_lanes(numbers, 0, each);                      \
    uint n = 0;                                         \
    for (; bits; bits &= bits - 1)                      \
        chosen[n++] = each[31 - clz(bits & (0 - bits))]; \
    return n;
#endif
INLINE uint write_chosen(uintL numbers, uint bits, __private uint* chosen) {
    WRITE_CHOSEN
}
INLINE uint write_chosen_global(uintL numbers, uint bits, __global uint* chosen) {
    WRITE_CHOSEN
}

// The numbers list[e, e + LANES); beyond the list's end, its last.
INLINE void load_numbers(__global const uint* list, uint e, uint count, __private uint* numbers) {
    if (e + LANES <= count)
        store_lanes(load_lanes(0, list + e), 0, numbers);
    else
        for (uint lane = 0; lane < LANES; ++lane) numbers[lane] = list[min(e + lane, count - 1)];
}

INLINE uint lanes_in_list(uint e, uint count) {
    return e + LANES <= count ? LANE_BITS : (1u << (count - e)) - 1;
}

// Which of a coarse brick's 64 bricks a list's polyhedra e to e + LANES - 1 touch: brick b's mask of lanes goes to
// masks[b * stride]. Returns which bricks any of them touches.
INLINE ulong touched_bricks(const LanePolyhedra* p, __private const float* caps, float slack, uint lanes, bool compact,
                            __global LaneMask* masks, uint stride) {
    Bounds reach = reach_of_lanes(p, 0.5f * (CLSDF_BRICK - 1), 0.5f * (CLSDF_BRICK - 1), 0.5f * (CLSDF_BRICK - 1));
    const Bounds step_x = bounds_product(p->step_x, CLSDF_BRICK), step_y = bounds_product(p->step_y, CLSDF_BRICK),
                 step_z = bounds_product(p->step_z, CLSDF_BRICK);
    Bounds slice = bounds_sum(bounds_sum(p->at, bounds_product(step_x, -1.5f)),
                              bounds_sum(bounds_product(step_y, -1.5f), bounds_product(step_z, -1.5f)));
    slice = without_reach(slice, reach, slack);
    const floatL reach_z = reach.z + slack;
    ulong any = 0;
    uint b = 0;
    for (uint z = 0; z < 4; ++z) {
        Bounds row = slice;
        for (uint y = 0; y < 4; ++y) {
            Bounds at = row;
#pragma unroll
            for (uint x = 0; x < 4; ++x) {
                const floatL above = reach_z + at.z, below = reach_z - at.z;
#define WIDTH(edge) GREATER(p->above[edge] * above, p->below[edge] * below)
                const uint touched =
                    lanes & lanes_to_bits(touches(at, fabs(at.z), WIDTH(CLSDF_EDGE_BASE), WIDTH(CLSDF_EDGE_RIGHT),
                                                  WIDTH(CLSDF_EDGE_LEFT), reach_z, (floatL)caps[b], compact));
#undef WIDTH
                masks[(size_t)b * stride] = (LaneMask)touched;
                any |= (ulong)(touched != 0) << b;
                ++b;
                at = bounds_sum(at, step_x);
            }
            row = bounds_sum(row, step_y);
        }
        slice = bounds_sum(slice, step_z);
    }
    return any;
}

// Appends the numbers first, first + 1, ... of those polyhedra that touch a sub-block to its list. Returns which of
// them touch any.
INLINE uint list_subblocks(const LanePolyhedra* p, __private const float* caps, float slack, uint lanes, bool compact,
                           uint first, __private uint* lists, __private uint* lengths) {
    const float half_x = 0.5f * (SUBBLOCK_X - 1);
    const Bounds reach = reach_of_lanes(p, half_x, 0.5f, 0.5f);
    const Bounds step_x = bounds_product(p->step_x, SUBBLOCK_X), step_y = bounds_product(p->step_y, 2.0f),
                 step_z = bounds_product(p->step_z, 2.0f);
    Bounds slice = bounds_sum(bounds_sum(p->at, bounds_product(p->step_x, half_x - 3.5f)),
                              bounds_sum(bounds_product(p->step_y, -3.0f), bounds_product(p->step_z, -3.0f)));
    slice = without_reach(slice, reach, slack);
    const floatL reach_z = reach.z + slack;
    // Slopes of the side of the face on which all of the brick's samples lie; where they lie on both, or within the
    // slack of the face, the greater ones, which bound both.
    const floatL extent = (fabs(p->step_x.z) + fabs(p->step_y.z) + fabs(p->step_z.z)) * (0.5f * (CLSDF_BRICK - 1));
    const intL is_above = p->at.z - extent > slack, is_below = -p->at.z - extent > slack;
    floatL slopes[3];
#pragma unroll
    for (uint edge = 0; edge < 3; ++edge)
        slopes[edge] = is_above ? p->above[edge] : is_below ? p->below[edge] : GREATER(p->above[edge], p->below[edge]);
    const uintL numbers = LANE_NUMBERS + first;
    uint any = 0, b = 0;
    for (uint z = 0; z < 4; ++z) {
        Bounds row = slice;
        for (uint y = 0; y < 4; ++y) {
            Bounds at = row;
#pragma unroll
            for (uint x = 0; x < SUBBLOCKS_X; ++x) {
                const floatL height = fabs(at.z), wide = height + reach_z;
                const uint touched =
                    lanes & lanes_to_bits(touches(at, height, slopes[CLSDF_EDGE_BASE] * wide,
                                                  slopes[CLSDF_EDGE_RIGHT] * wide, slopes[CLSDF_EDGE_LEFT] * wide,
                                                  reach_z, (floatL)caps[b], compact));
                lengths[b] += write_chosen(numbers, touched, lists + b * LIST_ROOM + lengths[b]);
                any |= touched;
                ++b;
                at = bounds_sum(at, step_x);
            }
            row = bounds_sum(row, step_y);
        }
        slice = bounds_sum(slice, step_z);
    }
    return any;
}

// The state of a brick's samples, a vector per sub-block.
typedef struct Minimum {
    floatL squared[SUBBLOCKS];
#ifdef NEAREST
    uintL triangle[SUBBLOCKS];
#endif
} Minimum;

// A polyhedron at a brick: what its distances take, side by side.
typedef struct Evaluated {
    Offsets offsets;
    Steps steps;
    uint triangle;
    uint number;
} Evaluated;

// The distance from the samples of sub-block b to the triangles of a list, into the minimum.
inline void evaluate(uint b, uint count, __private const uint* chosen, __private const Evaluated* evaluated,
                     __global const Polyhedron* polyhedra, double3 centre, __private Minimum* minimum
#ifdef COUNT
                     ,
                     float half_width, float slack, __private ulong* counters
#endif
) {
    const uintL lane = LANE_NUMBERS;
    const floatL i = convert_floatL(lane & (SUBBLOCK_X - 1)) + subblock_x(b);
    const floatL j = convert_floatL((lane / SUBBLOCK_X) & 1u) + subblock_y(b);
    const floatL k = convert_floatL(lane / (SUBBLOCK_X * 2)) + subblock_z(b);
    floatL least = minimum->squared[b];
#ifdef NEAREST
    uintL nearest = minimum->triangle[b];
#endif
    for (uint n = 0; n < count; ++n) {
        __private const Evaluated* e = evaluated + chosen[n];
#ifdef LONG_BRICKS
        const floatL squared = squared_distance_long_brick(
            polyhedra + e->number, frame_at(polyhedra + e->number, centre.x, centre.y, centre.z), i, j, k);
#else
        const floatL squared = squared_distance(e->steps, e->offsets, i, j, k);
#endif
#ifdef NEAREST
        const uint triangle = e->triangle;
        const intL better = (squared < least) | ((squared == least) & (triangle < nearest));
        nearest = better ? (uintL)triangle : nearest;
        least = better ? squared : least;
#else
        least = squared < least ? squared : least;
#endif
#ifdef COUNT
        counters[CLSDF_COUNT_COVERED] += popcount(
            covered_samples(polyhedra + e->number, e->offsets, i, j, k, half_width, slack) & LANE_BITS);
#endif
    }
    minimum->squared[b] = least;
#ifdef NEAREST
    minimum->triangle[b] = nearest;
#endif
    COUNT_ADD(CLSDF_COUNT_LANES, (ulong)count * LANES);
}

// Row (y, z) of a brick's samples, out of the vectors of its sub-blocks.
INLINE uint8 row_of(__private const uint* vectors, uint y, uint z) {
    __private const uint* part = vectors + (z / 2 * 4 + y / 2) * SUBBLOCKS_X * LANES + (z % 2 * 2 + y % 2) * SUBBLOCK_X;
#if LANES == 16
    return (uint8)(vload4(0, part), vload4(0, part + LANES));
#else
    return (uint8)(vload2(0, part), vload2(0, part + LANES), vload2(0, part + 2 * LANES), vload2(0, part + 3 * LANES));
#endif
}

// Stores values[begin, end) of a row of a brick.
inline void store_row(uint8 values, int begin, int end, __global uint* row) {
    if (end - begin == 8) {
        store_eight(values, 0, row);
        return;
    }
    uint each[8];
    vstore8(values, 0, each);
    for (int x = begin; x < end; ++x) row[x - begin] = each[x];
}

// Writes the samples of a brick that belong to the part: the distance with its sign where it lies in the band, else the
// fill.
inline void write_brick(Layout layout, int3 brick, __private Minimum* minimum, __global const uint* sign_bits,
                        __global float* distance
#ifdef NEAREST
                        ,
                        __global uint* triangle
#endif
#ifdef COUNT
                        ,
                        __private ulong* counters
#endif
) {
    const int3 first = vload3(0, layout.first), size = vload3(0, layout.size);
    const int3 begin = max(brick * CLSDF_BRICK, first) - first,
               end = min((brick + 1) * CLSDF_BRICK, first + size) - first;
    const int3 relative = brick * CLSDF_BRICK - first;  // of the brick's first sample; may be negative
    const int3 relative_brick = brick - vload3(0, layout.brick_first);
    for (int z = begin.z; z < end.z; ++z)
        for (int y = begin.y; y < end.y; ++y) {
            // The rows of sign bits cover whole bricks.
            const size_t bit_row =
                (size_t)(z - relative.z + relative_brick.z * CLSDF_BRICK) * (layout.bricks[1] * CLSDF_BRICK) +
                (y - relative.y + relative_brick.y * CLSDF_BRICK);
            const uint inside =
                (sign_bits[bit_row * layout.sign_words + relative_brick.x / 4] >> (relative_brick.x % 4 * 8)) & 0xFFu;
            const float8 square =
                as_float8(row_of((__private const uint*)minimum->squared, y - relative.y, z - relative.z));
            const int8 negative = (((int8)inside >> (int8)(0, 1, 2, 3, 4, 5, 6, 7)) & 1) != 0;
            const float8 fill = negative ? (float8)layout.inside_fill : (float8)layout.outside_fill;
            const float8 limit = negative ? (float8)layout.inside_squared : (float8)layout.outside_squared;
            const int8 in_band = square <= limit;
            const float8 length = LESSER(sqrt(square) * layout.unit, fabs(fill));
            const float8 value = in_band ? ((negative & (length != 0.0f)) ? -length : length) : fill;
            const size_t at = ((size_t)z * size.y + y) * size.x;
            const int x0 = begin.x - relative.x, x1 = end.x - relative.x;
            store_row(as_uint8(value), x0, x1, (__global uint*)distance + at + begin.x);
#ifdef NEAREST
            const uint8 nearest = row_of((__private const uint*)minimum->triangle, y - relative.y, z - relative.z);
            store_row(in_band ? nearest : (uint8)CLSDF_NO_TRIANGLE, x0, x1, triangle + at + begin.x);
#endif
#ifdef COUNT
            int in[8];
            vstore8(in_band, 0, in);
            for (int x = x0; x < x1; ++x) counters[CLSDF_COUNT_BAND] += in[x] != 0;
#endif
        }
}

// Computes one brick from its list. `cap` bounds the distance of its samples, or is the band's half width.
inline void compute_brick(Layout layout, int3 brick, uint count, __global const uint* list, float brick_cap,
                          __global const Polyhedron* polyhedra, __global const uint* sign_bits, __global float* distance
#ifdef NEAREST
                          ,
                          __global uint* triangle
#endif
#ifdef COUNT
                          ,
                          __private ulong* counters
#endif
) {
    Minimum minimum;
    float caps[SUBBLOCKS];
    for (uint b = 0; b < SUBBLOCKS; ++b) {
        minimum.squared[b] = INFINITY;
#ifdef NEAREST
        minimum.triangle[b] = CLSDF_NO_TRIANGLE;
#endif
        caps[b] = brick_cap;
    }
    // CHUNK polyhedra of the brick's list at a time, and for each sub-block the list of those that touch it.
    uint kept[CHUNK], lists[SUBBLOCKS * LIST_ROOM], lengths[SUBBLOCKS];
    Evaluated evaluated[CHUNK];
    const int3 first = brick * CLSDF_BRICK;
    const float centre = 0.5f * (CLSDF_BRICK - 1);
    const double x = first.x + (double)centre, y = first.y + (double)centre, z = first.z + (double)centre;
    const float slack = brick_cap * layout.slack_rate + layout.brick_slack;
    for (uint begin = 0; begin < count; begin += CHUNK) {
        const uint end = min(begin + CHUNK, count);
        for (uint b = 0; b < SUBBLOCKS; ++b) lengths[b] = 0;
        for (uint e = begin; e < end; e += LANES) {
            const uint n = e - begin;
            load_numbers(list, e, count, kept + n);
            const LanePolyhedra p = lane_polyhedra(polyhedra, kept + n, first, centre);
            const uint lanes = lanes_in_list(e, end);
            uint any = p.all_compact ? list_subblocks(&p, caps, slack, lanes, true, n, lists, lengths)
                                     : list_subblocks(&p, caps, slack, lanes, false, n, lists, lengths);
            for (; any; any &= any - 1) {
                const uint lane = 31 - clz(any & (0 - any));
                __global const Polyhedron* q = polyhedra + kept[n + lane];
                __private Evaluated* to = evaluated + n + lane;
                to->offsets = offsets_at(q, x, y, z);
                to->steps = steps_of(q);
                to->triangle = q->triangle;
                to->number = kept[n + lane];
            }
        }
        for (uint b = 0; b < SUBBLOCKS; ++b) {
            if (lengths[b] == 0) continue;
            evaluate(b, lengths[b], lists + b * LIST_ROOM, evaluated, polyhedra, (double3)(x, y, z), &minimum
#ifdef COUNT
                     ,
                     layout.half_width, layout.half_width * layout.slack_rate + layout.brick_slack, counters
#endif
            );
            if (end < count) {
                const float reached = sqrt(greatest_lane(minimum.squared[b]));
                caps[b] = LESSER(reached, brick_cap);
            }
        }
    }
    COUNT_ADD(CLSDF_COUNT_BRICK_PAIRS, count);
    write_brick(layout, brick, &minimum, sign_bits, distance
#ifdef NEAREST
                ,
                triangle
#endif
#ifdef COUNT
                ,
                counters
#endif
    );
}

// Upper bounds of the distance for the samples of each of a coarse brick's 64 bricks: the distance of the brick's
// centre to the nearest of the surface points it knows (the feet of the altitudes), and the brick's radius.
inline void brick_caps(Layout layout, int3 coarse, uint count, __global const uint* entries,
                       __global const Polyhedron* polyhedra, float coarse_cap, __private float* caps) {
    floatL least[64 / LANES];
    for (uint v = 0; v < 64 / LANES; ++v) least[v] = INFINITY;
    const int3 first = coarse * CLSDF_COARSE;
    // A vector is one or half a slice of 4 x 4 bricks.
    const floatL i = convert_floatL(LANE_NUMBERS & 3u) * (CLSDF_BRICK * layout.spacing[0]);
    const floatL j = convert_floatL(LANE_NUMBERS >> 2) * (CLSDF_BRICK * layout.spacing[1]);
    // Of a long list a part is enough.
    const uint stride = count > 4096 ? 4 : count > 256 ? 2 : 1;
    for (uint e = 0; e < count; e += stride) {
        for (uint ahead = e + 16; ahead < min(count, e + 16 + stride); ++ahead) request(polyhedra + entries[ahead]);
        const float3 from_foot =
            from_foot_to(layout, polyhedra + entries[e], first.x, first.y, first.z, 0.5f * (CLSDF_BRICK - 1));
        const floatL x = i + from_foot.x;
        for (uint v = 0; v < 64 / LANES; ++v) {
            const floatL y = j + (from_foot.y + (float)(v * LANES / 4 % 4) * (CLSDF_BRICK * layout.spacing[1]));
            const float z = from_foot.z + (float)(v * LANES / 16) * (CLSDF_BRICK * layout.spacing[2]);
            const floatL squared = x * x + (y * y + z * z);
            least[v] = LESSER(squared, least[v]);
        }
    }
    for (uint v = 0; v < 64 / LANES; ++v) {
        const floatL bound = sqrt(least[v]) * (1.0f + 1.0e-5f) + (layout.brick_radius + layout.brick_slack);
        store_lanes(LESSER(bound, coarse_cap), v, caps);
    }
}

// Global size: any. Work-items take coarse bricks order[turns[launch]++] until `end`; the turn starts at the launch's
// first.
__kernel void bricks_by_vector(Layout layout, uint launch, uint end, __global uint* turns, __global const uint* order,
                               __global const uint* starts, uint parts, __global const uint* entries,
                               __global const float* coarse_caps, __global const Polyhedron* polyhedra,
                               __global const uint* sign_bits, __global uchar* computed, __global uint* scratch_masks,
                               __global uint* scratch_list, uint scratch_length, __global float* distance
#ifdef NEAREST
                               ,
                               __global uint* triangle
#endif
#ifdef COUNT
                               ,
                               __global ulong* all_counters
#endif
) {
    const size_t item = get_global_id(0);
    const uint stride = scratch_length / LANES;
    __global LaneMask* masks = (__global LaneMask*)scratch_masks + item * 64 * stride;
    __global uint* list = scratch_list + item * scratch_length;
#ifdef COUNT
    ulong counters[CLSDF_COUNTERS] = {0, 0, 0, 0};
#endif
    const int3 first = vload3(0, layout.coarse_first), size = vload3(0, layout.coarse_bricks);
    const int3 brick_first = vload3(0, layout.brick_first), bricks = vload3(0, layout.bricks);
    for (;;) {
        const uint turn = atomic_inc(turns + launch);
        if (turn >= end) break;
        const uint number = order[turn];
        const uint begin = starts[number * parts], count = starts[(number + 1) * parts] - begin;
        const int3 coarse = first + (int3)(number % size.x, number / size.x % size.y, number / (size.x * size.y));
        const float coarse_cap = coarse_caps[coarse_cap_place(layout, coarse.x, coarse.y, coarse.z)];
        float caps[64];
        brick_caps(layout, coarse, count, entries + begin, polyhedra, coarse_cap, caps);
        ulong wanted = 0;
        for (uint b = 0; b < 64; ++b) {
            const int3 relative = coarse * CLSDF_BRICKS_PER_COARSE + (int3)(b & 3, (b >> 2) & 3, b >> 4) - brick_first;
            wanted |= (ulong)(all(relative >= 0) && all(relative < bricks)) << b;
        }
        const float slack = coarse_cap * layout.slack_rate + layout.brick_slack;
        ulong any = 0;
        for (uint e = 0; e < count; e += LANES) {
            uint numbers[LANES];
            load_numbers(entries + begin, e, count, numbers);
            for (uint ahead = e + LANES; ahead < min(count, e + 2 * LANES); ++ahead)
                request(polyhedra + entries[begin + ahead]);
            const LanePolyhedra p =
                lane_polyhedra(polyhedra, numbers, coarse * CLSDF_COARSE, 0.5f * (CLSDF_COARSE - 1));
            const uint lanes = lanes_in_list(e, count);
            any |= p.all_compact ? touched_bricks(&p, caps, slack, lanes, true, masks + e / LANES, stride)
                                 : touched_bricks(&p, caps, slack, lanes, false, masks + e / LANES, stride);
        }
        any &= wanted;
        while (any) {
            const uint b = 63 - (uint)clz(any & (0 - any));
            any &= any - 1;
            uint length = 0;
            for (uint e = 0; e < count; e += LANES) {
                const uint bits = masks[(size_t)b * stride + e / LANES];
                length += write_chosen_global(load_lanes(0, entries + begin + e), bits, list + length);
            }
            const int3 brick = coarse * CLSDF_BRICKS_PER_COARSE + (int3)(b & 3, (b >> 2) & 3, b >> 4);
            const int3 relative = brick - brick_first;
            computed[((size_t)relative.z * bricks.y + relative.y) * bricks.x + relative.x] = 1;
            compute_brick(layout, brick, length, list, caps[b], polyhedra, sign_bits, distance
#ifdef NEAREST
                          ,
                          triangle
#endif
#ifdef COUNT
                          ,
                          counters
#endif
            );
        }
    }
#ifdef COUNT
    for (uint c = 0; c < CLSDF_COUNTERS; ++c) all_counters[item * CLSDF_COUNTERS + c] += counters[c];
#endif
}
