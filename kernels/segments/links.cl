// The links of a lattice whose sample is outside and whose other end is inside, and the first wall on each: the rules
// and the rows of the host (lib/segments/links.cpp).
//
// The sides of the samples tell the links, word by word of 32 samples: count_links counts them, and behind a prefix sum
// fill_links writes sample and direction of each. link_crossings finds the faces that a link crosses: records
// (kernels/sign/row_records.h) whose rows are links and whose keys are faces. solve_links finds the first wall of each
// link. Every decision about what is crossed is exact; where the order of two walls is not certain, the link stays
// open.

#include "exact_rows.h"
#include "face_edges.h"
#include "link_lattice.h"
#include "row_records.h"

#pragma OPENCL FP_CONTRACT OFF

INLINE uint row_of(SampleRows samples, int y, int z) {
    return (uint)y + (uint)samples.size[1] * (uint)z;
}

INLINE bool is_inside(SampleRows samples, __global const uint* sides, int x, int y, int z) {
    return (sides[(size_t)row_of(samples, y, z) * samples.words + (uint)x / 32] >> (x & 31) & 1u) != 0;
}

// The sides of the samples `shift` behind those of word i; beyond the row they are 0. shift: less than 32 in size.
INLINE uint shifted(SampleRows samples, __global const uint* row, int i, int shift) {
    const uint word = row[i];
    if (shift > 0) return word >> shift | (i + 1 < (int)samples.words ? row[i + 1] << (32 - shift) : 0u);
    if (shift < 0) return word << -shift | (i > 0 ? row[i - 1] >> (32 + shift) : 0u);
    return word;
}

// Samples [begin, end) of a row, as far as they are in word i.
INLINE uint bits_between(int begin, int end, int i) {
    const int from = max(begin - 32 * i, 0), to = min(end - 32 * i, 32);
    return from >= to ? 0u : (0xFFFFFFFFu << from) & (0xFFFFFFFFu >> (32 - to));
}

// A word of a row of the grid.
typedef struct GridWord {
    int y, z, word;
    uint outside;  // samples of the grid
} GridWord;

INLINE GridWord grid_word(LinkLattice lattice, __global const uint* sides, uint n) {
    const SampleRows samples = lattice.samples;
    const uint row = n / samples.words, rows = (uint)(samples.size[1] - 2 * lattice.margin[1]);
    GridWord at;
    at.word = (int)(n % samples.words);
    at.y = (int)(row % rows) + lattice.margin[1];
    at.z = (int)(row / rows) + lattice.margin[2];
    at.outside = ~sides[(size_t)row_of(samples, at.y, at.z) * samples.words + (uint)at.word] &
                 bits_between(lattice.margin[0], samples.size[0] - lattice.margin[0], at.word);
    return at;
}

// The samples of a word that have a link of a step.
INLINE uint links_of(LinkLattice lattice, __global const uint* sides, GridWord at, LinkStep step) {
    const uint row = row_of(lattice.samples, at.y + step.step[1], at.z + step.step[2]);
    return at.outside & shifted(lattice.samples, sides + (size_t)row * lattice.samples.words, at.word, step.step[0]);
}

// The number of links of each word of the grid's rows, one per work-item.
__kernel void count_links(LinkLattice lattice, __global const LinkStep* steps, __global const uint* sides,
                          __global uint* counts, uint begin, uint end) {
    const uint n = begin + (uint)get_global_id(0);
    if (n >= end) return;
    const GridWord at = grid_word(lattice, sides, n);
    uint count = 0;
    for (int i = 0; at.outside != 0 && i < lattice.directions; ++i)
        count += popcount(links_of(lattice, sides, at, steps[i]));
    counts[n] = count;
}

// The links of each word, by sample, then by direction; steps: by direction. starts: of each word's links.
__kernel void fill_links(LinkLattice lattice, __global const LinkStep* steps, __global const uint* sides,
                         __global const uint* starts, __global int* link_samples, __global uchar* link_directions,
                         uint begin, uint end) {
    const uint n = begin + (uint)get_global_id(0);
    if (n >= end || starts[n] == starts[n + 1]) return;
    const GridWord at = grid_word(lattice, sides, n);
    uint links[32], any = 0;
    for (int i = 0; i < lattice.directions; ++i) any |= links[i] = links_of(lattice, sides, at, steps[i]);
    size_t to = starts[n];
    for (int bit = 0; bit < 32; ++bit) {
        if ((any >> bit & 1u) == 0) continue;
        for (int i = 0; i < lattice.directions; ++i) {
            if ((links[i] >> bit & 1u) == 0) continue;
            link_samples[3 * to] = (int)(lattice.first[0] + 32 * at.word + bit);
            link_samples[3 * to + 1] = (int)(lattice.first[1] + at.y);
            link_samples[3 * to + 2] = (int)(lattice.first[2] + at.z);
            link_directions[to++] = (uchar)steps[i].number;
        }
    }
}

// What a work-item reads and writes while it looks for links.
typedef struct LinkSearch {
    LinkLattice lattice;
    __global const double* at;
    __global const uint* sides;
    __global const uint* starts;
    __global const int* link_samples;
    __global const uchar* link_directions;
} LinkSearch;

// The number of the link from a sample of the grid, which there is.
INLINE uint number_of_link(__private const LinkSearch* search, int x, int y, int z, uint direction) {
    const SampleRows samples = search->lattice.samples;
    const uint row = (uint)(y - search->lattice.margin[1]) +
                     (uint)(samples.size[1] - 2 * search->lattice.margin[1]) * (uint)(z - search->lattice.margin[2]);
    const uint word = row * samples.words + (uint)x / 32;
    const int wanted = (int)(search->lattice.first[0] + x);
    uint begin = search->starts[word], end = search->starts[word + 1];
    while (end - begin > 1) {
        const uint middle = begin + (end - begin) / 2;
        const int sample = search->link_samples[3 * (size_t)middle];
        const bool is_behind =
            sample > wanted || (sample == wanted && (uint)search->link_directions[middle] > direction);
        if (is_behind)
            end = middle;
        else
            begin = middle;
    }
    return begin;
}

INLINE bool is_in_box(SampleRows samples, int x, int y, int z) {
    return x >= 0 && x < samples.size[0] && y >= 0 && y < samples.size[1] && z >= 0 && z < samples.size[2];
}

INLINE bool is_in_grid(LinkLattice lattice, int x, int y, int z) {
    const int* margin = lattice.margin;
    const SampleRows samples = lattice.samples;
    return x >= margin[0] && x < samples.size[0] - margin[0] && y >= margin[1] && y < samples.size[1] - margin[1] &&
           z >= margin[2] && z < samples.size[2] - margin[2];
}

// Writes a record if the link from `from` along the line is one, and crosses the face.
INLINE void visit_link(__private const LinkSearch* search, LinkLine line, uint face, double3 a, double3 b, double3 c,
                       int x, int y, int z, bool is_sure, __private Writer* writer) {
    const SampleRows samples = search->lattice.samples;
    const int to_x = x + line.step[0], to_y = y + line.step[1], to_z = z + line.step[2];
    if (!is_in_box(samples, x, y, z) || !is_in_box(samples, to_x, to_y, to_z)) return;
    const bool from_inside = is_inside(samples, search->sides, x, y, z);
    if (from_inside == is_inside(samples, search->sides, to_x, to_y, to_z)) return;
    const uint direction = from_inside ? line.backward : line.forward;
    if (direction == CLSDF_NO_DIRECTION) return;
    if (from_inside ? !is_in_grid(search->lattice, to_x, to_y, to_z) : !is_in_grid(search->lattice, x, y, z)) return;
    if (!is_sure && crossing_of(a, b, c,
                                segment_between(sample_at(samples, search->at, x, y, z),
                                                sample_at(samples, search->at, to_x, to_y, to_z)))
                            .looks == 0)
        return;
    write_record(
        writer,
        from_inside ? number_of_link(search, to_x, to_y, to_z, direction) : number_of_link(search, x, y, z, direction),
        face);
}

// A face as the lines along one step see it: LinkRaster of lib/segments.
typedef struct SeenFace {
    double u[3], v[3], k[3];
    int begin_u, end_u, begin_v, end_v;  // of the lines that may cross it, both included
    bool is_seen;
} SeenFace;

INLINE double least_of(__private const double* x) {
    return fmin(x[0], fmin(x[1], x[2]));
}
INLINE double most_of(__private const double* x) {
    return fmax(x[0], fmax(x[1], x[2]));
}

INLINE SeenFace seen_face(SampleRows samples, LinkLine line, __private const double* corners, double margin) {
    SeenFace seen;
    const double stride = line.step[line.along], begin = line.begin, u_slope = line.step[line.first] / stride,
                 v_slope = line.step[line.second] / stride;
    for (int i = 0; i < 3; ++i) {
        const double past = corners[3 * i + line.along] - begin;
        seen.u[i] = corners[3 * i + line.first] - u_slope * past;
        seen.v[i] = corners[3 * i + line.second] - v_slope * past;
        seen.k[i] = past / stride;
    }
    const double far_u = -(double)line.step[line.first] * line.count,
                 far_v = -(double)line.step[line.second] * line.count;
    const double begin_u = fmax(ceil(least_of(seen.u) - margin), fmin(0.0, far_u)),
                 end_u = fmin(floor(most_of(seen.u) + margin), samples.size[line.first] - 1 + fmax(0.0, far_u)),
                 begin_v = fmax(ceil(least_of(seen.v) - margin), fmin(0.0, far_v)),
                 end_v = fmin(floor(most_of(seen.v) + margin), samples.size[line.second] - 1 + fmax(0.0, far_v));
    seen.is_seen = begin_u <= end_u && begin_v <= end_v && most_of(seen.k) >= -margin - 1 &&
                   least_of(seen.k) <= line.count + 1 + margin;
    seen.begin_u = seen.is_seen ? (int)begin_u : 0;
    seen.end_u = seen.is_seen ? (int)end_u : -1;
    seen.begin_v = seen.is_seen ? (int)begin_v : 0;
    seen.end_v = seen.is_seen ? (int)end_v : -1;
    return seen;
}

// The links of one line.
INLINE void visit_line(__private const LinkSearch* search, LinkLine line, __private const SeenFace* seen, uint face,
                       double3 a, double3 b, double3 c, int x, int y, double margin, double tolerance,
                       __private Writer* writer) {
    double w[3];
    for (int i = 0; i < 3; ++i) {
        const int one = (i + 1) % 3, other = (i + 2) % 3;
        w[i] =
            (seen->u[other] - seen->u[one]) * (y - seen->v[one]) - (seen->v[other] - seen->v[one]) * (x - seen->u[one]);
    }
    const double least = least_of(w), most = most_of(w);
    if (least < -tolerance && most > tolerance) return;
    const bool is_within = least > tolerance || most < -tolerance;
    const double area = w[0] + w[1] + w[2], low_k = least_of(seen->k), high_k = most_of(seen->k);
    double low = low_k - 2 * margin, high = high_k + 2 * margin;
    if (fabs(area) > 8 * tolerance) {
        const double per_area = 1 / area;
        const double place = (w[0] * seen->k[0] + w[1] * seen->k[1] + w[2] * seen->k[2]) * per_area;
        const double error = 4 * tolerance * (high_k - low_k) * fabs(per_area) + 2 * margin;
        low = place - error;
        high = place + error;
    }
    if (high < 0 || low >= line.count + 1) return;
    const int begin = low < 0 ? -1 : (int)low, end = high > line.count + 1 ? line.count + 1 : (int)high;
    for (int n = begin; n <= end; ++n) {
        int sample[3];
        sample[line.along] = line.begin + line.step[line.along] * n;
        sample[line.first] = x + line.step[line.first] * n;
        sample[line.second] = y + line.step[line.second] * n;
        visit_link(search, line, face, a, b, c, sample[0], sample[1], sample[2], is_within && begin == end, writer);
    }
}

// The lines of row v of a face that is wide: between its edges.
INLINE void narrow_row(__private const SeenFace* seen, int row, double margin, __private int* begin,
                       __private int* end) {
    double least = most_of(seen->u), most = least_of(seen->u);
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        const double low = fmin(seen->v[i], seen->v[j]), high = fmax(seen->v[i], seen->v[j]);
        if (low > row + margin || high < row - margin) continue;
        double from = seen->u[i], to = seen->u[j];
        if (high - low > 4 * margin) {
            const double slope = (seen->u[j] - seen->u[i]) / (seen->v[j] - seen->v[i]);
            from = seen->u[i] + slope * (clamp(row - margin, low, high) - seen->v[i]);
            to = seen->u[i] + slope * (clamp(row + margin, low, high) - seen->v[i]);
        }
        least = fmin(least, fmin(from, to));
        most = fmax(most, fmax(from, to));
    }
    // Twice: of the corners and of the row.
    const double first = *begin, last = *end;
    *begin = (int)clamp(ceil(least - 2 * margin), first, last + 1);
    *end = (int)clamp(floor(most + 2 * margin), first - 1, last);
}

INLINE void cross_links(__private const LinkSearch* search, __global const LinkLine* lines,
                        __global const uint* triangles, __global const double* positions, uint t, uint strip,
                        uint strips, __global uint* large, __private Writer* writer) {
    const LinkLattice lattice = search->lattice;
    const SampleRows samples = lattice.samples;
    const double3 a = corner_of(samples, triangles, positions, t, 0),
                  b = corner_of(samples, triangles, positions, t, 1),
                  c = corner_of(samples, triangles, positions, t, 2);
    double corners[9] = {a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z};  // in samples from the first one
    double most = lattice.far, span = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        double low = INFINITY, high = -INFINITY;
        for (int i = 0; i < 3; ++i) {
            const double x =
                (corners[3 * i + axis] - lattice.origin[axis]) * lattice.per_unit[axis] - (double)lattice.first[axis];
            corners[3 * i + axis] = x;
            most = fmax(most, fabs(x));
            low = fmin(low, x);
            high = fmax(high, x);
        }
        if (high < -1.0 || low > samples.size[axis]) return;
        span = fmax(span, high - low);
    }
    const double margin = 8 * lattice.slope * (0x1p-50 * most + lattice.rounding * (1.0 + span));
    ulong number = 0, rows = 0;
    for (int i = 0; i < lattice.lines; ++i) {
        const SeenFace seen = seen_face(samples, lines[i], corners, margin);
        rows += (ulong)(seen.end_v - seen.begin_v + 1);
        number += (ulong)(seen.end_v - seen.begin_v + 1) * (ulong)(seen.end_u - seen.begin_u + 1);
    }
    if (number == 0) return;
    if (strips == 0 && number > CLSDF_LARGE_LINES) {
        leave_large(t, number, large, writer->totals);
        return;
    }
    // Of the rows of all lines together.
    const ulong begin_row = strips == 0 ? 0 : rows * strip / strips,
                end_row = strips == 0 ? rows : rows * (strip + 1) / strips;
    ulong before = 0;
    for (int i = 0; i < lattice.lines; ++i) {
        const LinkLine line = lines[i];
        const SeenFace seen = seen_face(samples, line, corners, margin);
        const ulong own = (ulong)(seen.end_v - seen.begin_v + 1);
        const ulong first = max(begin_row, before), last = min(end_row, before + own);
        const double tolerance =
            4 * margin * (most_of(seen.u) - least_of(seen.u) + most_of(seen.v) - least_of(seen.v) + margin);
        for (ulong row = first; row < last; ++row) {
            const int y = seen.begin_v + (int)(row - before);
            int begin = seen.begin_u, end = seen.end_u;
            if (end - begin > 4) narrow_row(&seen, y, margin, &begin, &end);
            for (int x = begin; x <= end; ++x)
                visit_line(search, line, &seen, t, a, b, c, x, y, margin, tolerance, writer);
        }
        before += own;
    }
}

// The faces that links cross. Otherwise as sign_crossings of sign_sweep.cl.
__kernel void link_crossings(LinkLattice lattice, __global const LinkLine* lines, __global const uint* triangles,
                             __global const double* positions, __global const double* at, __global const uint* sides,
                             __global const uint* starts, __global const int* link_samples,
                             __global const uchar* link_directions, uint begin, uint end, __global uint* row_counts,
                             uint capacity, uint block, __global SweepRecord* records, __global SweepTotals* totals,
                             __global uint* large, int has_chosen, __global const uint* chosen, uint strips) {
    const uint part = get_global_id(0), parts = get_global_size(0), count = (end - begin) * max(strips, 1u);
    const uint own_end = share_of(count, part + 1, parts);
    Writer writer = {row_counts, records, capacity, block, totals, 0, 0};
    const LinkSearch search = {lattice, at, sides, starts, link_samples, link_directions};
    for (uint i = share_of(count, part, parts); i < own_end; ++i) {
        const uint n = begin + (strips > 0 ? i / strips : i), strip = strips > 0 ? i % strips : 0;
        cross_links(&search, lines, triangles, positions, has_chosen ? chosen[n] : n, strip, strips, large, &writer);
    }
    leave_records(writer);
}

typedef struct Corners {
    double3 of[3];
} Corners;

INLINE Corners corners_of(SampleRows samples, __global const uint* triangles, __global const double* positions,
                          uint face) {
    Corners corners;
    for (uint i = 0; i < 3; ++i) corners.of[i] = corner_of(samples, triangles, positions, face, i);
    return corners;
}

INLINE bool are_equal(double3 a, double3 b) {
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

// Bit i: the segment's line meets the edge from corner i, or, from bit 3 on, corner i.
OUT_OF_LINE uint met_edges(__private const Corners* face, Segment segment) {
    uint met = 0;
    for (uint i = 0; i < 3; ++i)
        if (sign_of_determinant(segment.along, exact_difference(face->of[i], segment.from),
                                exact_difference(face->of[(i + 1) % 3], segment.from)) == 0)
            met |= 1u << i;
    // No edge of a face that is crossed is parallel to the segment.
    for (uint i = 0; i < 3; ++i)
        if ((met >> i & 1u) != 0 && (met >> (i + 2) % 3 & 1u) != 0) met |= 8u << i;
    return met;
}

INLINE bool is_in_plane(__private const Corners* face, double3 p) {
    return orientation_in_space(face->of[0], face->of[1], face->of[2], p) == 0;
}

// Whether a segment that crosses both faces surely meets them at one place: they lie in one plane, the segment begins
// or ends in both planes, or it meets an edge or a vertex that they share.
OUT_OF_LINE bool meet_at_one_place(__private const Corners* a, __private const Corners* b, Segment segment) {
    if (is_in_plane(a, segment.from) && is_in_plane(b, segment.from)) return true;
    if (is_in_plane(a, segment.to) && is_in_plane(b, segment.to)) return true;
    if (is_in_plane(a, b->of[0]) && is_in_plane(a, b->of[1]) && is_in_plane(a, b->of[2])) return true;
    const uint of_a = met_edges(a, segment), of_b = met_edges(b, segment);
    for (uint i = 0; i < 3; ++i)
        for (uint j = 0; j < 3; ++j) {
            const bool is_shared = are_equal(a->of[i], b->of[j]);
            if ((of_a >> (3 + i) & 1u) != 0 && (of_b >> (3 + j) & 1u) != 0 && is_shared) return true;
            if ((of_a >> i & 1u) == 0 || (of_b >> j & 1u) == 0) continue;
            const double3 end_of_a = a->of[(i + 1) % 3], end_of_b = b->of[(j + 1) % 3];
            if (is_shared ? are_equal(end_of_a, end_of_b)
                          : are_equal(a->of[i], end_of_b) && are_equal(end_of_a, b->of[j]))
                return true;
        }
    return false;
}

// The float of a part, as as_float_part() of clsdf/segments.hpp; its bits, since a device may flush small floats.
INLINE uint float_part(double q) {
    if (q < 0x1p-126) {
        const uint small = (uint)rint(q * 0x1p149);
        return q > 0.0 && small == 0 ? 1u : small;
    }
    const uint bits = as_uint(convert_float_rte(q));
    return q < 1.0 && bits == 0x3F800000u ? 0x3F7FFFFFu : bits;
}

// A face that a link crosses.
typedef struct CrossedFace {
    double place;
    uint face, triangle;
    uint looks;
    int change;
} CrossedFace;

// The first wall and the number of walls.
typedef struct MetWalls {
    double place;
    uint triangle, count;
} MetWalls;

// Walks through faces that are sorted by place. False if the order of two is not certain.
INLINE bool walk(SampleRows samples, __global const uint* triangles, __global const double* positions, Segment segment,
                 __private const CrossedFace* crossed, uint count, int is_parity, __private LookWindings* windings,
                 __private MetWalls* met) {
    bool is_inside_now = are_inside(windings, is_parity);
    for (uint begin = 0; begin < count;) {
        // Each place is within 0.51 ulp.
        uint end = begin + 1;
        while (end < count && crossed[end].place - crossed[end - 1].place <= 0x1p-51 * crossed[end].place) ++end;
        // They must be one place: each is surely at the place of one of those before.
        uint reached = 1;
        for (uint round = 1; round < end - begin; ++round)
            for (uint i = begin; i < end; ++i)
                for (uint j = begin; j < end; ++j) {
                    if ((reached >> (i - begin) & 1u) == 0 || (reached >> (j - begin) & 1u) != 0) continue;
                    const Corners one = corners_of(samples, triangles, positions, crossed[i].face),
                                  other = corners_of(samples, triangles, positions, crossed[j].face);
                    if (meet_at_one_place(&one, &other, segment)) reached |= 1u << (j - begin);
                }
        if (reached != (1u << (end - begin)) - 1u) return false;
        uint lowest = begin;
        for (uint i = begin; i < end; ++i) {
            add_to_looks(windings, crossed[i].looks, crossed[i].change);
            if (crossed[i].triangle < crossed[lowest].triangle) lowest = i;
        }
        if (are_inside(windings, is_parity) != is_inside_now) {
            is_inside_now = !is_inside_now;
            if (met->count++ == 0) {
                met->place = crossed[lowest].place;
                met->triangle = crossed[lowest].triangle;
            }
        }
        begin = end;
    }
    return true;
}

// The rows of links [begin, end), one per work-item. side_starts, side_keys: the crossings of the rows of samples.
// face_starts, faces: the faces that each link crosses. names: of faces (face_edges.h).
__kernel void solve_links(LinkLattice lattice, __global const int4* steps, __global const uint* triangles,
                          __global const double* positions, __global const uint* names, __global const double* at,
                          __global const uint* side_starts, __global const uint* side_keys,
                          __global const uint* face_starts, __global const uint* faces,
                          __global const int* link_samples, __global const uchar* link_directions, __global double* q,
                          __global uint* q_floats, __global uint* link_triangles, __global uint* counts,
                          __global uchar* flags, __global LinkResults* results, uint begin, uint end) {
    const uint n = begin + (uint)get_global_id(0);
    if (n >= end) return;
    const SampleRows samples = lattice.samples;
    const int x = (int)(link_samples[3 * (size_t)n] - lattice.first[0]),
              y = (int)(link_samples[3 * (size_t)n + 1] - lattice.first[1]),
              z = (int)(link_samples[3 * (size_t)n + 2] - lattice.first[2]);
    const int4 step = steps[link_directions[n]];
    const Segment segment =
        segment_between(sample_at(samples, at, x, y, z), sample_at(samples, at, x + step.x, y + step.y, z + step.z));
    __global const uint* own = faces + face_starts[n];
    const uint own_count = face_starts[n + 1] - face_starts[n];
    MetWalls met = {0.0, 0u, 0u};
    if (own_count == 1) {
        // One face is crossed, so it is the wall.
        const Corners face = corners_of(samples, triangles, positions, own[0]);
        met.place = place_of(face.of[0], face.of[1], face.of[2], segment);
        met.triangle = names[own[0]] & ~CLSDF_NAME_NON_MANIFOLD;
        met.count = 1;
    } else if (own_count <= CLSDF_MOST_LINK_FACES) {
        CrossedFace crossed[CLSDF_MOST_LINK_FACES];
        uint count = 0;
        for (uint i = 0; i < own_count; ++i) {
            const Corners face = corners_of(samples, triangles, positions, own[i]);
            const FaceCrossing crossing = crossing_of(face.of[0], face.of[1], face.of[2], segment);
            if (crossing.looks == 0) continue;
            CrossedFace found;
            found.place = place_of(face.of[0], face.of[1], face.of[2], segment);
            found.face = own[i];
            found.triangle = names[own[i]] & ~CLSDF_NAME_NON_MANIFOLD;
            found.looks = crossing.looks;
            found.change = crossing.side;
            uint to = count++;
            for (; to > 0 && crossed[to - 1].place > found.place; --to) crossed[to] = crossed[to - 1];
            crossed[to] = found;
        }
        LookWindings windings = {{0}};
        const uint row = row_of(samples, y, z);
        for (uint i = side_starts[row]; i < side_starts[row + 1] && CLSDF_SAMPLE_OF_CROSSING(side_keys[i]) <= (uint)x;
             ++i)
            add_crossing(&windings, side_keys[i]);
        if (!walk(samples, triangles, positions, segment, crossed, count, lattice.is_parity, &windings, &met)) {
            atomic_inc(&results->open);
            return;
        }
    } else {
        atomic_inc(&results->open);
        return;
    }
    if ((met.count & 1u) == 0) {
        atomic_inc(&results->wrong);
        atomic_min(&results->first_wrong, n);
    }
    q[n] = met.place;
    q_floats[n] = float_part(met.place);
    link_triangles[n] = met.triangle;
    counts[n] = met.count;
    flags[n] = 0;
}

// The sides of samples [begin, end) of the grid, x fastest: a byte each, one per work-item, or, if are_packed, a bit
// each, the lowest one first, 32 per work-item.
__kernel void store_sides(LinkLattice lattice, __global const uint* sides, ulong count, int are_packed,
                          __global uchar* bytes, uint begin, uint end) {
    const uint item = begin + (uint)get_global_id(0);
    if (item >= end) return;
    const SampleRows samples = lattice.samples;
    const uint size_x = (uint)(samples.size[0] - 2 * lattice.margin[0]),
               size_y = (uint)(samples.size[1] - 2 * lattice.margin[1]);
    const ulong first = are_packed ? 32 * (ulong)item : item;
    uint x = (uint)(first % size_x), y = (uint)(first / size_x % size_y), z = (uint)(first / size_x / size_y);
    uint bits = 0;
    for (uint bit = 0; bit < (are_packed ? 32u : 1u) && first + bit < count; ++bit) {
        bits |= (is_inside(samples, sides, (int)x + lattice.margin[0], (int)y + lattice.margin[1],
                           (int)z + lattice.margin[2])
                     ? 1u
                     : 0u)
                << bit;
        if (++x < size_x) continue;
        x = 0;
        if (++y < size_y) continue;
        y = 0;
        ++z;
    }
    if (are_packed)
        ((__global uint*)bytes)[item] = bits;
    else
        bytes[item] = (uchar)bits;
}
