// Finishing of a brick's samples in vectors, for processors: by the formulas of finish.h, one or two rows at a time.
//
// A slice of up to four bricks is put together in a work-item's own memory, and its rows go to the field as whole
// lines.
#ifndef CLSDF_FINISH_ROWS_H
#define CLSDF_FINISH_ROWS_H

#include "distance.h"
#include "field_lines.h"
#include "finish.h"
#include "lane_offsets.h"
#include "simd.h"
#include "subblocks.h"

DEFINE_FROM_SITE(from_sites, LaneEdgeOffsets, lane_edge_offsets, doubleL, longL)
DEFINE_FRAME_WEIGHTS(weights_of_rows, doubleL, longL)
DEFINE_WITHOUT_ROUNDING(without_rounding_of_rows, doubleL)

// A vector of samples of a slice of a brick, a lane each: one or two rows.
typedef struct Rows {
    int3 first;       // sample, of the lattice
    uint found;       // a bit a lane: the sample has a polyhedron and is in the band; other lanes' results are not used
    uint inside;      // a bit a lane
    doubleL x, y, z;  // from the closest points, along the mesh's axes, in units
    doubleL squared;
    doubleL frame_site;
    doubleL weights[2];     // of frame_weights(), for barycentric coordinates
    uint polyhedra[LANES];  // the nearest; of lanes that are not found, any
} Rows;

#define ALONG_ROW (double8)(0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0)

// Joins the eight lanes of each row into one vector.
#if ROWS_PER_VECTOR == 1
#define OF_ROWS(row_of) row_of(0)
#else
#define OF_ROWS(row_of) ((doubleL)(row_of(0), row_of(1)))
#endif

// The offset of a lane's sample from the first one in a slice.
#define OFFSET_OF_LANE(lane) ((lane) / CLSDF_BRICK * CLSDF_COARSE + (lane) % CLSDF_BRICK)

INLINE int3 sample_of(__private const Rows* rows, uint lane) {
    return rows->first + (int3)((int)(lane % CLSDF_BRICK), (int)(lane / CLSDF_BRICK), 0);
}

// Finds the closest points of the samples.
INLINE void find_rows(__private const Finishing* finishing, __private Rows* rows) {
    double8 numbers[ROWS_PER_VECTOR][EXACT_NUMBERS];
    FromOrigins from[ROWS_PER_VECTOR];
#pragma unroll
    for (int r = 0; r < ROWS_PER_VECTOR; ++r) {
        __private const uint* polyhedra = rows->polyhedra + r * CLSDF_BRICK;
        from[r] = from_origins(finishing->polyhedra, polyhedra, (double)rows->first.x + ALONG_ROW,
                               (double8)(double)(rows->first.y + r), (double8)(double)rows->first.z);
        load_exact(finishing->polyhedra, polyhedra, numbers[r]);
    }
    doubleL exact[EXACT_NUMBERS];
#define NUMBER_OF(r) numbers[r][n]
#define FROM_x(r) from[r].x
#define FROM_y(r) from[r].y
#define FROM_z(r) from[r].z
#pragma unroll
    for (uint n = 0; n < EXACT_NUMBERS; ++n) exact[n] = OF_ROWS(NUMBER_OF);
    const doubleL from_x = OF_ROWS(FROM_x), from_y = OF_ROWS(FROM_y), from_z = OF_ROWS(FROM_z);
#undef NUMBER_OF
#undef FROM_x
#undef FROM_y
#undef FROM_z
    const doubleL x = FRAME_AT(exact, 0, from_x, from_y, from_z), y = FRAME_AT(exact, 1, from_x, from_y, from_z),
                  z = FRAME_AT(exact, 2, from_x, from_y, from_z);
    doubleL in_x, in_y;
    from_sites(exact + NUMBER_BASE, x, y, z, &in_x, &in_y, &rows->frame_site);
#define ALONG_AXIS(n) ((exact[3 * n] * in_x + (exact[3 * n + 1] * in_y + exact[3 * n + 2] * z)) * per_spacing[n])
    __private const double* per_spacing = finishing->how.per_spacing;
    rows->x = ALONG_AXIS(0);
    rows->y = ALONG_AXIS(1);
    rows->z = ALONG_AXIS(2);
#undef ALONG_AXIS
    rows->squared = without_rounding_of_rows(exact + NUMBER_BASE, x, y, z, in_x * in_x + (in_y * in_y + z * z));
    if (IS_WANTED(finishing, barycentric))
        weights_of_rows(exact + NUMBER_BASE, x - in_x, y - in_y, rows->frame_site, rows->weights, rows->weights + 1);
}

INLINE int8 lanes_of(uint bits) {
    return ((int8)(int)bits & (int8)(1, 2, 4, 8, 16, 32, 64, 128)) != 0;
}

// Stores a vector of each lane of a row. Lanes that are not found get every bit.
#define DEFINE_STORE_VECTORS(name, Real, Vector, as_bits, as_vector, Bits, convert_lanes, Order, store) \
    INLINE void name(Vector x, Vector y, Vector z, uint found, __global Real* to) {                     \
        const Bits missing = ~(Bits)convert_lanes(lanes_of(found));                                     \
        x = as_vector(as_bits(x) | missing);                                                            \
        y = as_vector(as_bits(y) | missing);                                                            \
        z = as_vector(as_bits(z) | missing);                                                            \
        const Vector low = EIGHT_OF(x, y, Order, 0, 8, 1, 9, 2, 10, 3, 11);                             \
        const Vector middle = EIGHT_OF(x, y, Order, 3, 11, 4, 12, 5, 13, 6, 14);                        \
        const Vector high = EIGHT_OF(x, y, Order, 4, 12, 5, 13, 6, 14, 7, 15);                          \
        store(EIGHT_OF(low, z, Order, 0, 1, 8, 2, 3, 9, 4, 5), 0, to);                                  \
        store(EIGHT_OF(middle, z, Order, 10, 0, 1, 11, 2, 3, 12, 4), 1, to);                            \
        store(EIGHT_OF(high, z, Order, 3, 13, 4, 5, 14, 6, 7, 15), 2, to);                              \
    }
DEFINE_STORE_VECTORS(store_float_vectors, float, float8, as_int8, as_float8, int8, , uint8, store_eight_floats)
DEFINE_STORE_VECTORS(store_double_vectors, double, double8, as_long8, as_double8, long8, convert_long8, ulong8,
                     store_eight_doubles)
#undef DEFINE_STORE_VECTORS

// The same of rows of a slice. to: output of the first sample.
INLINE void store_vectors(doubleL x, doubleL y, doubleL z, uint found, __global uchar* to, bool in_double) {
#pragma unroll
    for (int r = 0; r < ROWS_PER_VECTOR; ++r) {
        const double8 row_x = ROW_OF_VECTOR(x, r), row_y = ROW_OF_VECTOR(y, r), row_z = ROW_OF_VECTOR(z, r);
        const size_t at = 3 * r * CLSDF_COARSE;
        const uint lanes = found >> (r * CLSDF_BRICK) & 0xFFu;
        if (in_double)
            store_double_vectors(row_x, row_y, row_z, lanes, (__global double*)to + at);
        else
            store_float_vectors(convert_float8(row_x), convert_float8(row_y), convert_float8(row_z), lanes,
                                (__global float*)to + at);
    }
}

// Stores distances in double.
INLINE void store_distance(__private const Finishing* finishing, __private const Rows* rows, size_t at) {
    const Finish how = finishing->how;
    const longL inside = TO_LONGS(bits_to_lanes(rows->inside)), found = TO_LONGS(bits_to_lanes(rows->found));
    const doubleL fill = select((doubleL)how.outside_fill, (doubleL)how.inside_fill, inside), most = fabs(fill);
    const doubleL root = sqrt(rows->squared) * how.unit, length = LESSER(root, most);
    const doubleL least = (double)how.least_inside;
    const doubleL in_band = select(length, 0.0 - GREATER(length, least), inside);  // 0 - 0 is +0
    const doubleL distances = select(fill, in_band, found);
#pragma unroll
    for (int r = 0; r < ROWS_PER_VECTOR; ++r)
        store_eight_doubles(ROW_OF_VECTOR(distances, r), 0, finishing->of_distance + at + r * CLSDF_COARSE);
}

INLINE void store_closest(__private const Finishing* finishing, __private const Rows* rows, size_t at) {
    const double unit = finishing->how.unit;
    __private const double* origin = finishing->how.origin;
    __private const double* spacing = finishing->how.spacing;
#define X_OF(r) (origin[0] + ((double)rows->first.x + ALONG_ROW) * spacing[0])
#define Y_OF(r) (double8)(origin[1] + (double)(rows->first.y + r) * spacing[1])
    const doubleL x = OF_ROWS(X_OF) - rows->x * unit, y = OF_ROWS(Y_OF) - rows->y * unit,
                  z = (origin[2] + (double)rows->first.z * spacing[2]) - rows->z * unit;
#undef X_OF
#undef Y_OF
    store_vectors(x, y, z, rows->found, finishing->of_closest + 3 * at * sizeof(double), true);
}

INLINE void store_offset(__private const Finishing* finishing, __private const Rows* rows, size_t at) {
    const bool in_double = IS_DOUBLE(finishing, offset);
    const double unit = finishing->how.unit;
    store_vectors(-(rows->x * unit), -(rows->y * unit), -(rows->z * unit), rows->found,
                  finishing->of_offset + 3 * at * (in_double ? sizeof(double) : sizeof(float)), in_double);
}

INLINE void store_gradient(__private const Finishing* finishing, __private const Rows* rows, size_t at) {
    const bool in_double = IS_DOUBLE(finishing, gradient);
    const intL inside = bits_to_lanes(rows->inside);
    const doubleL scale = select((doubleL)1.0, (doubleL)-1.0, TO_LONGS(inside)) / sqrt(rows->squared);
    store_vectors(rows->x * scale, rows->y * scale, rows->z * scale, rows->found,
                  finishing->of_gradient + 3 * at * (in_double ? sizeof(double) : sizeof(float)), in_double);
    for (uint lanes = rows->found & lanes_to_bits(TO_INTS(rows->squared <= SQUARE_OF_NO_DISTANCE)); lanes;
         lanes &= lanes - 1) {
        const uint lane = lowest_bit(lanes);
        Nearest nearest;
        find_nearest_at(finishing, convert_double3(sample_of(rows, lane)), rows->polyhedra[lane],
                        rows->inside >> lane & 1u, &nearest);
        STORE_real(finished_gradient(finishing, &nearest), 3, at + OFFSET_OF_LANE(lane), finishing->of_gradient,
                   in_double);
    }
}

// Stores the outputs that take the names of sites, lane by lane.
INLINE void store_by_name(__private const Finishing* finishing, __private const Rows* rows, size_t at) {
    __private const double* frame_site = (__private const double*)&rows->frame_site;
    __private const double* weights = (__private const double*)rows->weights;
    for (uint lane = 0; lane < LANES; ++lane) {
        const bool found = (rows->found >> lane & 1u) != 0;
        __global const Polyhedron* p = finishing->polyhedra + rows->polyhedra[lane];
        NamedSite named = UNNAMED_SITE;
        if (found) named = name_site(finishing, p, (uint)frame_site[lane]);
        const size_t to = at + OFFSET_OF_LANE(lane);
        if (IS_WANTED(finishing, triangle))
            ((__global uint*)finishing->of_triangle)[to] = told_triangle(finishing, named);
        if (IS_WANTED(finishing, site)) finishing->of_site[to] = (uchar)told_site(finishing, named);
        if (!IS_WANTED(finishing, barycentric)) continue;
        if (found) {
            STORE_real(told_weights(finishing, p, named, weights[lane], weights[LANES + lane]), 2, to,
                       finishing->of_barycentric, IS_DOUBLE(finishing, barycentric));
        } else {
            LEAVE_real(2, to, finishing->of_barycentric, IS_DOUBLE(finishing, barycentric));
        }
    }
}

INLINE void store_body(__private const Finishing* finishing, __private const Rows* rows, size_t at) {
    for (uint lane = 0; lane < LANES; ++lane)
        ((__global uint*)finishing->of_body)[at + OFFSET_OF_LANE(lane)] =
            rows->found >> lane & 1u ? 0u : CLSDF_NO_TRIANGLE;
}

// The outputs that have functions for rows. All others are finished sample by sample.
#define FINISHED_BY_ROWS                                                                         \
    (1u << CLSDF_OUTPUT_distance | 1u << CLSDF_OUTPUT_triangle | 1u << CLSDF_OUTPUT_site |       \
     1u << CLSDF_OUTPUT_closest | 1u << CLSDF_OUTPUT_gradient | 1u << CLSDF_OUTPUT_barycentric | \
     1u << CLSDF_OUTPUT_offset | 1u << CLSDF_OUTPUT_body)
#define OUTPUT_BIT(name, content, element, components, number) | 1u << number
#define FINISHED_BY_SAMPLE ((0u CLSDF_OUTPUTS(OUTPUT_BIT)) & ~FINISHED_BY_ROWS)

INLINE void store_by_sample(__private const Finishing* finishing, __private const Rows* rows, size_t at) {
    Finishing others = *finishing;
    others.how.wanted &= FINISHED_BY_SAMPLE;
    for (uint lane = 0; lane < LANES; ++lane) {
        const size_t to = at + OFFSET_OF_LANE(lane);
        if (!(rows->found >> lane & 1u)) {
            leave_sample(&others, to);
            continue;
        }
        Nearest nearest;
        find_nearest_at(&others, convert_double3(sample_of(rows, lane)), rows->polyhedra[lane],
                        rows->inside >> lane & 1u, &nearest);
        store_outputs(&others, &nearest, to);
    }
}

// Stores what finishing makes of samples into a slice. at: the first one's index there.
static inline void finish_rows(__private const Finishing* finishing, __private const Rows* rows, size_t at) {
    if (IS_DOUBLE(finishing, distance)) store_distance(finishing, rows, at);
    if ((finishing->how.wanted & CLSDF_OUTPUTS_BY_NAME) != 0) store_by_name(finishing, rows, at);
    if (IS_WANTED(finishing, closest)) store_closest(finishing, rows, at);
    if (IS_WANTED(finishing, offset)) store_offset(finishing, rows, at);
    if (IS_WANTED(finishing, gradient)) store_gradient(finishing, rows, at);
    if (IS_WANTED(finishing, body)) store_body(finishing, rows, at);
    if ((finishing->how.wanted & FINISHED_BY_SAMPLE) != 0) store_by_sample(finishing, rows, at);
}

// A slice of rows of up to four bricks, in memory of its own: each row begins CLSDF_COARSE samples after the one before
// it. All rows are found before any is finished: each is a chain of dependent steps, and several rows hide its latency.
// The rows of a slice are stored while the next slice's are found: stores past the caches go on beside arithmetic.
typedef struct Slice {
    Rows rows[CLSDF_BRICK / ROWS_PER_VECTOR][CLSDF_BRICKS_PER_COARSE];
    Finishing finishing;  // into the slice
    // Samples [begin, end) of each row, x and y, are still to be stored; none if begin equals end.
    int2 begin, end;
    size_t at, row;  // the index of the slice's first sample among the results, and how far rows lie apart
} Slice;

#define SLICE_SAMPLES (CLSDF_BRICK * CLSDF_COARSE)
#define OUTPUT_COMPONENTS(name, content, element, components, number) +components
#define SLICE_BYTES (SLICE_SAMPLES * sizeof(double) * (1 CLSDF_OUTPUTS(OUTPUT_COMPONENTS)))

INLINE void set_slice(__private const Finishing* finishing, __global uchar* room, __private Slice* slice) {
    slice->finishing = *finishing;
    slice->begin = slice->end = (int2)(0);
    slice->finishing.of_distance = (__global double*)room;
    room += SLICE_SAMPLES * sizeof(double);
#define SET_OF_SLICE(name, content, element, components, number) \
    slice->finishing.of_##name = room;                           \
    room += SLICE_SAMPLES * sizeof(double) * components;
    CLSDF_OUTPUTS(SET_OF_SLICE)
#undef SET_OF_SLICE
}

// Stores row y, if it is not stored yet.
INLINE void store_slice_row(__private const Finishing* finishing, __private const Slice* slice, int y) {
    if (y < slice->begin.y || y >= slice->end.y) return;
    const int begin = slice->begin.x, end = slice->end.x;
    const size_t at = slice->at + y * slice->row + begin;
#define WIDTH_uint32(is_double) sizeof(uint)
#define WIDTH_uint8(is_double) sizeof(uchar)
#define WIDTH_real(is_double) ((is_double) ? sizeof(double) : sizeof(float))
#define WIDTH_float32 WIDTH_real
#define WIDTH_float64(is_double) sizeof(double)
    if (IS_DOUBLE(finishing, distance))
        store_values((__global const uint*)(slice->finishing.of_distance + y * CLSDF_COARSE + begin),
                     (__global uint*)(finishing->of_distance + at),
                     (__global uint*)(finishing->of_distance + at + (end - begin)));
#define STORE_ROW(name, content, element, components, number)                                               \
    if (IS_WANTED(finishing, name)) {                                                                       \
        const size_t bytes = WIDTH_##element(IS_DOUBLE(finishing, name)) * components;                      \
        store_bytes(slice->finishing.of_##name + (y * CLSDF_COARSE + begin) * bytes,                        \
                    finishing->of_##name + at * bytes, finishing->of_##name + (at + (end - begin)) * bytes, \
                    bytes % sizeof(uint) == 0);                                                             \
    }
    CLSDF_OUTPUTS(STORE_ROW)
#undef STORE_ROW
}

// Stores the rows that are not stored yet.
static inline void store_slice(__private const Finishing* finishing, __private Slice* slice) {
    for (int y = 0; y < CLSDF_BRICK; ++y) store_slice_row(finishing, slice, y);
    slice->end = slice->begin;
}

// Finishes the rows of the next slice of `bricks` bricks, and stores those of the one before. Its samples [begin, end)
// will be stored, with `at` and `row` as in Slice.
OUT_OF_LINE void finish_slice(__private const Finishing* finishing, __private Slice* slice, int bricks, int3 begin,
                              int3 end, size_t at, size_t row) {
    for (int y = 0; y < CLSDF_BRICK; y += ROWS_PER_VECTOR) {
        const bool is_part = y + ROWS_PER_VECTOR > begin.y && y < end.y;
        for (int r = 0; r < ROWS_PER_VECTOR; ++r) {
            store_slice_row(finishing, slice, y + r);
            for (int n = r; is_part && n < bricks; n += ROWS_PER_VECTOR) {
                __private Rows* rows = &slice->rows[y / ROWS_PER_VECTOR][n];
                if (rows->found != 0) find_rows(finishing, rows);
            }
        }
    }
    for (int y = first_of_vector(begin.y); y < end.y; y += ROWS_PER_VECTOR)
        for (int n = 0; n < bricks; ++n)
            finish_rows(&slice->finishing, &slice->rows[y / ROWS_PER_VECTOR][n], y * CLSDF_COARSE + n * CLSDF_BRICK);
    slice->begin = begin.xy;
    slice->end = end.xy;
    slice->at = at;
    slice->row = row;
}

#endif
