// Finishing of a brick's samples row by row, for processors: by the formulas of finish.h, the eight samples of a row a
// lane each.
//
// A row of up to four bricks is put together in a work-item's own memory, and goes to the field as whole lines.
#ifndef CLSDF_FINISH_ROWS_H
#define CLSDF_FINISH_ROWS_H

#include "bits.h"
#include "field_lines.h"
#include "finish.h"
#include "lane_offsets.h"

DEFINE_FROM_SITE(from_sites, double8, long8)

// The outputs that are computed in vectors, or as vectors tell their sites; the others are finished lane by lane.
#define CLSDF_OUTPUTS_BY_ROW \
    (1u << CLSDF_OUTPUT_triangle | 1u << CLSDF_OUTPUT_site | 1u << CLSDF_OUTPUT_closest | 1u << CLSDF_OUTPUT_gradient)

// Eight samples along x, a lane each.
typedef struct Row {
    int3 first;       // sample, of the lattice
    uint found;       // a bit a lane: it has a polyhedron, and is in the band; of other lanes nothing matters
    uint inside;      // a bit a lane
    double8 x, y, z;  // from the closest points, along the mesh's axes, in units
    double8 squared;
    double8 frame_site;
    uint polyhedra[CLSDF_BRICK];
} Row;

#define ALONG_ROW (double8)(0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0)

INLINE int8 lanes_of(uint bits) {
    return ((int8)(int)bits & (int8)(1, 2, 4, 8, 16, 32, 64, 128)) != 0;
}

// Finds the closest points of a row's samples. polyhedra: the nearest; what is not found may be any number.
INLINE void find_row(__private const Finishing* finishing, uint8 polyhedra, __private Row* row) {
    store_eight(select((uint8)0, polyhedra, lanes_of(row->found)), 0, row->polyhedra);
    double8 exact[EXACT_NUMBERS];
    load_exact(finishing->polyhedra, row->polyhedra, exact);
    const FromOrigins from = from_origins(finishing->polyhedra, row->polyhedra, (double)row->first.x + ALONG_ROW,
                                          (double8)(double)row->first.y, (double8)(double)row->first.z);
    const double8 x = FRAME_AT(exact, 0, from.x, from.y, from.z), y = FRAME_AT(exact, 1, from.x, from.y, from.z),
                  z = FRAME_AT(exact, 2, from.x, from.y, from.z);
    double8 in_x, in_y;
    from_sites(exact + NUMBER_BASE, x, y, z, &in_x, &in_y, &row->frame_site);
#define ALONG_AXIS(n) ((exact[3 * n] * in_x + (exact[3 * n + 1] * in_y + exact[3 * n + 2] * z)) * per_spacing[n])
    __private const double* per_spacing = finishing->how.per_spacing;
    row->x = ALONG_AXIS(0);
    row->y = ALONG_AXIS(1);
    row->z = ALONG_AXIS(2);
#undef ALONG_AXIS
    row->squared = in_x * in_x + (in_y * in_y + z * z);
}

// Stores a vector of each lane. Lanes that are not found get every bit.
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

INLINE void store_vectors(double8 x, double8 y, double8 z, uint found, __global uchar* to, bool in_double) {
    if (in_double)
        store_double_vectors(x, y, z, found, (__global double*)to);
    else
        store_float_vectors(convert_float8(x), convert_float8(y), convert_float8(z), found, (__global float*)to);
}

INLINE void store_closest(__private const Finishing* finishing, __private const Row* row, size_t at) {
    const bool in_double = IS_DOUBLE(finishing, closest);
    const double unit = finishing->how.unit;
    double8 x = -(row->x * unit), y = -(row->y * unit), z = -(row->z * unit);
    if (in_double) {
        __private const double* origin = finishing->how.origin;
        __private const double* spacing = finishing->how.spacing;
        x = (origin[0] + ((double)row->first.x + ALONG_ROW) * spacing[0]) - row->x * unit;
        y = (origin[1] + (double)row->first.y * spacing[1]) - row->y * unit;
        z = (origin[2] + (double)row->first.z * spacing[2]) - row->z * unit;
    }
    store_vectors(x, y, z, row->found, finishing->of_closest + 3 * at * (in_double ? sizeof(double) : sizeof(float)),
                  in_double);
}

INLINE void store_gradient(__private const Finishing* finishing, __private const Row* row, size_t at) {
    const bool in_double = IS_DOUBLE(finishing, gradient);
    const double8 sign = select((double8)1.0, (double8)-1.0, convert_long8(lanes_of(row->inside)));
    const double8 scale = sign / sqrt(row->squared);
    store_vectors(row->x * scale, row->y * scale, row->z * scale, row->found,
                  finishing->of_gradient + 3 * at * (in_double ? sizeof(double) : sizeof(float)), in_double);
    if (all(row->squared > SQUARE_OF_NO_DISTANCE)) return;
    __private const double* squared = (__private const double*)&row->squared;
    for (uint lanes = row->found; lanes; lanes &= lanes - 1) {
        const uint lane = lowest_bit(lanes);
        if (squared[lane] > SQUARE_OF_NO_DISTANCE) continue;
        Nearest nearest;
        find_nearest_at(finishing, convert_double3(row->first + (int3)((int)lane, 0, 0)), row->polyhedra[lane],
                        row->inside >> lane & 1u, &nearest);
        STORE_real(finished_gradient(finishing, &nearest), 3, at + lane, finishing->of_gradient, in_double);
    }
}

INLINE void store_names(__private const Finishing* finishing, __private const Row* row, size_t at) {
    __private const double* frame_site = (__private const double*)&row->frame_site;
    for (uint lane = 0; lane < CLSDF_BRICK; ++lane) {
        NamedSite named = {CLSDF_NO_TRIANGLE, 0xFFu, false};
        if ((row->found >> lane & 1u) != 0)
            named = name_site(finishing, finishing->polyhedra + row->polyhedra[lane], (uint)frame_site[lane]);
        if (IS_WANTED(finishing, triangle)) ((__global uint*)finishing->of_triangle)[at + lane] = named.triangle;
        if (IS_WANTED(finishing, site)) finishing->of_site[at + lane] = (uchar)named.site;
    }
}

// Stores the outputs of a row's samples other than the distance. at: the first one's index among the results.
static inline void finish_row(__private const Finishing* finishing, __private const Row* row, size_t at) {
    if (IS_WANTED(finishing, triangle) || IS_WANTED(finishing, site)) store_names(finishing, row, at);
    if (IS_WANTED(finishing, closest)) store_closest(finishing, row, at);
    if (IS_WANTED(finishing, gradient)) store_gradient(finishing, row, at);
    if ((finishing->how.wanted & ~CLSDF_OUTPUTS_BY_ROW) == 0) return;
    Finishing others = *finishing;
    others.how.wanted &= ~CLSDF_OUTPUTS_BY_ROW;
    for (uint lane = 0; lane < CLSDF_BRICK; ++lane)
        if ((row->found >> lane & 1u) != 0)
            finish_sample(&others, row->first + (int3)((int)lane, 0, 0), row->polyhedra[lane], row->inside >> lane & 1u,
                          at + lane);
        else
            leave_sample(&others, at + lane);
}

// A slice of rows of up to four bricks, in memory of its own: each row begins CLSDF_COARSE samples after the one before
// it. All rows are found before they are finished: the steps of each of both wait for each other.
typedef struct Slice {
    Row rows[CLSDF_BRICK][CLSDF_BRICKS_PER_COARSE];
    Finishing finishing;  // into the slice
} Slice;

#define SLICE_SAMPLES (CLSDF_BRICK * CLSDF_COARSE)
#define OUTPUT_COMPONENTS(name, content, element, components) +components
#define SLICE_BYTES (SLICE_SAMPLES * sizeof(double) * (0 CLSDF_OUTPUTS(OUTPUT_COMPONENTS)))

INLINE void set_slice(__private const Finishing* finishing, __global uchar* room, __private Slice* slice) {
    slice->finishing = *finishing;
#define SET_OF_SLICE(name, content, element, components) \
    slice->finishing.of_##name = room;                   \
    room += SLICE_SAMPLES * sizeof(double) * components;
    CLSDF_OUTPUTS(SET_OF_SLICE)
#undef SET_OF_SLICE
}

// Finishes the rows [begin, end) of `bricks` bricks.
static inline void finish_slice(__private const Slice* slice, int bricks, int begin, int end) {
    for (int y = begin; y < end; ++y)
        for (int n = 0; n < bricks; ++n)
            finish_row(&slice->finishing, &slice->rows[y][n], y * CLSDF_COARSE + n * CLSDF_BRICK);
}

// Stores samples [begin, end) of row y to place `at` of the results.
INLINE void store_slice_row(__private const Slice* slice, __private const Finishing* finishing, int y, int begin,
                            int end, size_t at) {
#define WIDTH_uint32(is_double) sizeof(uint)
#define WIDTH_uint8(is_double) sizeof(uchar)
#define WIDTH_real(is_double) ((is_double) ? sizeof(double) : sizeof(float))
#define STORE_ROW(name, content, element, components)                                                       \
    if (IS_WANTED(finishing, name)) {                                                                       \
        const size_t bytes = WIDTH_##element(IS_DOUBLE(finishing, name)) * components;                      \
        store_bytes(slice->finishing.of_##name + (y * CLSDF_COARSE + begin) * bytes,                        \
                    finishing->of_##name + at * bytes, finishing->of_##name + (at + (end - begin)) * bytes, \
                    bytes % sizeof(uint) == 0);                                                             \
    }
    CLSDF_OUTPUTS(STORE_ROW)
#undef STORE_ROW
}

#endif
