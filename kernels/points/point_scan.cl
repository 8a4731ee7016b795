// The nearest triangles of many points: a scan of groups of points (point_groups.h), on processors.
//
// From superblocks to vectors, a group's list of polyhedra goes to its 16 children at once, a child a lane: a
// polyhedron stays if it overlaps the child's box within the child's upper bound of the distance. The distances of a
// vector's points to the triangles of its list are taken in float. Each triangle that may be the nearest, given the
// error of floats, is evaluated again in double (scan_decisions.h), and so are the faces that share its site. So a
// point's result is the pair (squared distance, triangle) that points.cl finds.
//
// Compile-time options: LANES (simd.h), 16 or 8.

#include "edge_offsets.h"
#include "frame.h"
#include "point_groups.h"
#include "scan_decisions.h"
#include "simd.h"

// Slack of the overlap test, in units: what polyhedra need (frusta.hpp) and the rounding of floats, with room.
#define SLACK 4.0e-3f
#define SLACK_RATE 4.0e-5f    // per distance
#define SLACK_EXTENT 2.0e-6f  // per extent of the group
// Bound of the error of distances in float, relative to the lengths that they follow from (frame.h).
#define SCAN_DISTANCE_ERROR 2.0e-6f

typedef struct Children {
    floatL centre[3][PARTS], half_side[3][PARTS];
    floatL bound[PARTS];  // upper bound of the distance of each one's points
    floatL slack[PARTS];
    uint present;  // bit for each
} Children;

INLINE void load_children(__global const PointGroup* group, __private Children* children) {
    for (int part = 0; part < PARTS; ++part)
        for (int axis = 0; axis < 3; ++axis) {
            children->centre[axis][part] = load_lanes(part, group->centre[axis]);
            children->half_side[axis][part] = load_lanes(part, group->half_side[axis]);
        }
    children->present = (1u << group->children) - 1u;
}

// The nearest foot to each child's centre.
typedef struct NearestFeet {
    floatL squared[PARTS];
    uintL record[PARTS];
} NearestFeet;

// Takes the foot of a record if it is nearer.
INLINE void look_at_foot(__global const ScanRecord* p, uint record, int3 origin, const __private Children* children,
                         __private NearestFeet* feet) {
    const float x = (float)(p->origin_x - origin.x) + p->foot[0], y = (float)(p->origin_y - origin.y) + p->foot[1],
                z = (float)(p->origin_z - origin.z) + p->foot[2];
    for (int part = 0; part < PARTS; ++part) {
        const floatL dx = children->centre[0][part] - x, dy = children->centre[1][part] - y,
                     dz = children->centre[2][part] - z;
        const floatL squared = dx * dx + (dy * dy + dz * dz);
        const intL is_nearer = squared < feet->squared[part];
        feet->squared[part] = is_nearer ? squared : feet->squared[part];
        feet->record[part] = is_nearer ? (uintL)record : feet->record[part];
    }
}

INLINE void clear_feet(__private NearestFeet* feet) {
    for (int part = 0; part < PARTS; ++part) {
        feet->squared[part] = (floatL)INFINITY;
        feet->record[part] = (uintL)0u;
    }
}

// Sets the bounds and slacks from upper bounds of the distances of the centres, squared. most: an upper bound of all.
INLINE void set_bounds(__private Children* children, const __private floatL* squares, float most) {
    for (int part = 0; part < PARTS; ++part) {
        const floatL x = children->half_side[0][part], y = children->half_side[1][part],
                     z = children->half_side[2][part];
        const floatL radius = sqrt(x * x + (y * y + z * z));
        const floatL extent = fabs(children->centre[0][part]) + fabs(children->centre[1][part]) +
                              fabs(children->centre[2][part]) + radius;
        const floatL bound = (sqrt(squares[part]) + radius) * (1.0f + 1.0e-5f) + (SLACK + SLACK_EXTENT * extent);
        children->bound[part] = LESSER(bound, (floatL)most);
        children->slack[part] = SLACK + SLACK_RATE * children->bound[part] + SLACK_EXTENT * extent;
    }
}

INLINE int3 origin_of(__global const PointGroup* group) {
    return vload3(0, group->origin);
}

// A polyhedron's frame at an integer origin (X, Y, Z, -), and how it changes along the lattice's axes.
typedef struct Frame {
    float4 at, x, y, z;
    float4 normal;  // along right, left, across right, left
    float2 base;
} Frame;

INLINE Frame frame_from(ScanMesh mesh, uint record, int3 origin) {
    __global const ScanRecord* p = mesh.records + record;
    Frame f;
    f.x = vload4(0, p->gradient_x);
    f.y = vload4(0, p->gradient_y);
    f.z = vload4(0, p->gradient_z);
    if (p->flags & CLSDF_POLYHEDRON_NEAR) {
        const float i = (float)(origin.x - p->origin_x), j = (float)(origin.y - p->origin_y),
                    k = (float)(origin.z - p->origin_z);
        f.at = f.x * i + (f.y * j + (f.z * k + vload4(0, p->constant_at_origin)));
    } else {
        f.at = convert_float4(frame_at(mesh.polyhedra + record, origin.x, origin.y, origin.z));
    }
    f.normal = vload4(0, p->normal_along);
    f.base = vload2(0, p->base);
    return f;
}

// Bits of the children whose boxes the polyhedron overlaps (see polyhedron.h), with slack.
INLINE uint overlapped_children(__global const ScanRecord* p, Frame f, const __private Children* children) {
    const float along_right = f.normal.x, along_left = f.normal.y, across_right = f.normal.z, across_left = f.normal.w;
    const float right_x = along_right * f.x.x + across_right * f.x.y, left_x = across_left * f.x.y - along_left * f.x.x,
                right_y = along_right * f.y.x + across_right * f.y.y, left_y = across_left * f.y.y - along_left * f.y.x,
                right_z = along_right * f.z.x + across_right * f.z.y, left_z = across_left * f.z.y - along_left * f.z.x;
    const float right_at = along_right * (f.at.x - f.base.x) + across_right * f.at.y,
                left_at = across_left * f.at.y - along_left * (f.at.x + f.base.y);
    const bool is_compact = (p->flags & CLSDF_POLYHEDRON_COMPACT) != 0;
    uint bits = 0;
    for (int part = 0; part < PARTS; ++part) {
        const floatL cx = children->centre[0][part], cy = children->centre[1][part], cz = children->centre[2][part];
        const floatL hx = children->half_side[0][part], hy = children->half_side[1][part],
                     hz = children->half_side[2][part];
        const floatL slack = children->slack[part], bound = children->bound[part];
#define AT(at, x, y, z) (cx * (x) + (cy * (y) + (cz * (z) + (at))))
#define EXTENT(x, y, z) (hx * fabs(x) + (hy * fabs(y) + (hz * fabs(z) + slack)))
        const floatL height = AT(f.at.z, f.x.z, f.y.z, f.z.z), extent = EXTENT(f.x.z, f.y.z, f.z.z);
        const floatL above = extent + height, below = extent - height;
#define WIDTH(edge) GREATER(p->slope_above[edge] * above, p->slope_below[edge] * below)
        floatL base = WIDTH(CLSDF_EDGE_BASE), right = WIDTH(CLSDF_EDGE_RIGHT), left = WIDTH(CLSDF_EDGE_LEFT);
#undef WIDTH
        intL in = fabs(height) <= extent + bound;
        if (!is_compact) {
            base = LESSER(base, bound);
            right = LESSER(right, bound);
            left = LESSER(left, bound);
            const floatL x = AT(f.at.x, f.x.x, f.y.x, f.z.x), widened = EXTENT(f.x.x, f.y.x, f.z.x) + bound;
            in &= (x - f.base.x <= widened) & (-x - f.base.y <= widened);
        }
        in &= (AT(-f.at.y, -f.x.y, -f.y.y, -f.z.y) <= base + EXTENT(f.x.y, f.y.y, f.z.y)) &
              (AT(right_at, right_x, right_y, right_z) <= right + EXTENT(right_x, right_y, right_z)) &
              (AT(left_at, left_x, left_y, left_z) <= left + EXTENT(left_x, left_y, left_z));
#undef EXTENT
#undef AT
        bits |= lanes_to_bits(in) << part * LANES;
    }
    return bits & children->present;
}

// Prefetches a record of a list that comes later.
INLINE void request_later(__global const uint* list, uint i, uint count, __global const ScanRecord* records) {
    __global const ScanRecord* later = records + list[LESSER(i + 8u, count - 1u)];
    prefetch_line_to_l1(later);
    prefetch_line_to_l1(&later->slope_above[1]);
}

// Writes records, a work-item each, from polyhedra, of which those of point sites begin at first_site.
__kernel void pack_records(__global const Polyhedron* polyhedra, ScanCounts counts, uint first_site,
                           __global ScanRecord* records) {
    const uint i = get_global_id(0);
    if (i >= counts.records) return;
    __global const Polyhedron* p = polyhedra + (i < counts.faces ? i : i - counts.faces + first_site);
    vstore16(vload16(0, (__global const float*)p), 0, (__global float*)(records + i));
    vstore16(vload16(1, (__global const float*)p), 1, (__global float*)(records + i));
    records[i].altitude = (float)p->exact_altitude;
}

// Squares of upper bounds of the distances of the centres of superblocks' children, a work-item a superblock. Looks at
// every `stride`-th polyhedron.
__kernel void bound_blocks(__global const PointGroup* superblocks, uint first, uint stride, ScanCounts counts,
                           __global const ScanRecord* records, __global float* squares) {
    const uint number = first + (uint)get_global_id(0);
    Children children;
    load_children(superblocks + number, &children);
    NearestFeet feet;
    clear_feet(&feet);
    for (uint i = 0; i < counts.faces; i += stride)
        look_at_foot(records + i, i, origin_of(superblocks + number), &children, &feet);
    for (int part = 0; part < PARTS; ++part)
        store_lanes(feet.squared[part], part, squares + number * CLSDF_GROUP_WIDTH);
}

// Sets, for each polyhedron of a range and each superblock, the bits of the children that it overlaps. A work-item
// takes `run` polyhedra of one superblock.
__kernel void mark_blocks(__global const PointGroup* superblocks, uint first, uint run, ScanCounts counts,
                          __global const ScanRecord* records, __global const Polyhedron* polyhedra, float most,
                          __global const float* squares, __global ushort* marks) {
    const uint count = counts.records, runs = (count + run - 1) / run;
    const uint item = first + (uint)get_global_id(0), number = item / runs, begin = item % runs * run;
    const uint end = min(count, begin + run);
    Children children;
    load_children(superblocks + number, &children);
    floatL least[PARTS];
    for (int part = 0; part < PARTS; ++part) least[part] = load_lanes(part, squares + number * CLSDF_GROUP_WIDTH);
    set_bounds(&children, least, most);
    const int3 origin = origin_of(superblocks + number);
    ScanMesh mesh;
    mesh.records = records;
    mesh.polyhedra = polyhedra;
    for (uint i = begin; i < end; ++i)
        marks[(size_t)number * count + i] =
            (ushort)overlapped_children(records + i, frame_from(mesh, i, origin), &children);
}

// A distance from its square, rounded up.
INLINE float limit_of(double squared) {
    return (float)sqrt(squared) * (1.0f + 1.0e-6f);
}

// Finds the bounds of a group's children from its list, and the records whose feet give them.
INLINE void find_bounds(__global const PointGroup* group, __global const ScanRecord* records, uint count,
                        __global const uint* list, float most, __private Children* children,
                        __private NearestFeet* feet) {
    load_children(group, children);
    clear_feet(feet);
    const uint stride = count > 64 ? 4 : 1;
    for (uint i = 0; i < count; i += stride) {
        request_later(list, i + 3 * stride, count, records);
        look_at_foot(records + list[i], list[i], origin_of(group), children, feet);
    }
    set_bounds(children, feet->squared, most);
}

// The greatest error of distances in float, for points within `bound` of the surface, and of squared distances.
INLINE float distance_error(ScanCounts counts, float bound, float extent) {
    return SCAN_DISTANCE_ERROR * (bound + 2.0f * counts.longest + extent + 2.0f);
}
INLINE float square_error(float error, float bound) {
    return 2.0f * error * (bound + error);
}

DEFINE_EDGE_OFFSETS(RecordEdgeOffsets, record_edge_offsets, floatL, intL)
DEFINE_SQUARED_FROM_EDGE(squared_from_edge, floatL)

// Squared distances of points displaced by (x, y, z) from the origin of a frame: see distance.h.
INLINE floatL squared_from(Frame f, float altitude, floatL i, floatL j, floatL k) {
    const floatL x = i * f.x.x + (j * f.y.x + (k * f.z.x + f.at.x));
    const floatL y = i * f.x.y + (j * f.y.y + (k * f.z.y + f.at.y));
    const floatL z = i * f.x.z + (j * f.y.z + (k * f.z.z + f.at.z));
    const RecordEdgeOffsets offsets =
        record_edge_offsets(x, y, f.base.x, f.base.y, f.normal.x, f.normal.y, f.normal.z, f.normal.w, altitude);
    return squared_from_edge(EDGE_THAT_COUNTS(offsets, ), z);
}

// Squared distances of a vector's points to a record's triangle or point.
INLINE floatL squared_of_vector(Frame frame, float altitude, uint vector, int part, __global const PointBrick* brick) {
    const uint at = OF_VECTOR(part);
    return squared_from(frame, altitude, load_lanes(0, brick->from_origin[0] + at),
                        load_lanes(0, brick->from_origin[1] + at), load_lanes(0, brick->from_origin[2] + at));
}

// Bounds distances by the records whose feet are nearest.
INLINE void bound_by_feet(ScanMesh mesh, const __private NearestFeet* feet, int3 origin, const __private float* margins,
                          __global PointBrick* brick) {
    uint records[CLSDF_GROUP_WIDTH];
    for (int part = 0; part < PARTS; ++part) store_lanes(feet->record[part], part, records);
    for (uint vector = 0; vector < CLSDF_GROUP_WIDTH; ++vector) {
        const Frame frame = frame_from(mesh, records[vector], origin);
        const float altitude = mesh.records[records[vector]].altitude;
        for (int part = 0; part < PARTS; ++part) {
            const floatL squared = squared_of_vector(frame, altitude, vector, part, brick) + margins[vector];
            const floatL bound = load_lanes(0, brick->bound + OF_VECTOR(part));
            store_lanes(LESSER(squared, bound), 0, brick->bound + OF_VECTOR(part));
        }
    }
}

// Loads a brick's points. Returns the greatest distance of one from the origin, rounded up.
static float load_points(__global const double* points, uint begin, uint end, int3 origin, double most,
                         __global PointBrick* brick) {
    float farthest = 0.0f;
    for (uint i = 0; i < CLSDF_POINTS_OF_BRICK; ++i) {
        const double3 p = vload3(min(begin + i, end - 1), points);
        const float x = (float)(p.x - origin.x), y = (float)(p.y - origin.y), z = (float)(p.z - origin.z);
        brick->at[0][i] = p.x;
        brick->at[1][i] = p.y;
        brick->at[2][i] = p.z;
        brick->from_origin[0][i] = x;
        brick->from_origin[1][i] = y;
        brick->from_origin[2][i] = z;
        brick->squared[i] = most;
        brick->triangle[i] = 0xFFFFFFFFu;
        brick->face[i] = CLSDF_NO_FACE;
        brick->vertex[i] = 0xFFFFFFFFu;
        const float extent = fabs(x) + fabs(y) + fabs(z);
        farthest = GREATER(farthest, extent);
    }
    return farthest;
}

// The nearest faces of a brick's points. list: polyhedra, of which there are `count`.
static void scan_brick(ScanMesh mesh, __global const PointGroup* group, __global const double* points, uint begin,
                       uint end, uint count, __global const uint* list, double most, __global PointBrick* brick) {
    const int3 origin = origin_of(group);
    const float extent = load_points(points, begin, end, origin, most, brick);
    Children vectors;
    NearestFeet feet;
    find_bounds(group, mesh.records, count, list, limit_of(most), &vectors, &feet);
    float bounds[CLSDF_GROUP_WIDTH], errors[CLSDF_GROUP_WIDTH], margins[CLSDF_GROUP_WIDTH];
    for (int part = 0; part < PARTS; ++part) store_lanes(vectors.bound[part], part, bounds);
    for (uint vector = 0; vector < CLSDF_GROUP_WIDTH; ++vector) {
        const float bound = bounds[vector];
        errors[vector] = distance_error(mesh.counts, bound, extent);
        margins[vector] = square_error(errors[vector], bound);
        for (int part = 0; part < PARTS; ++part)
            store_lanes((floatL)(bound * bound * (1.0f + 1.0e-5f)), 0, brick->bound + OF_VECTOR(part));
    }
    if (count > 0) bound_by_feet(mesh, &feet, origin, margins, brick);
    uint candidates = 0;
    for (uint n = 0; n < count; ++n) {
        request_later(list, n, count, mesh.records);
        const Frame frame = frame_from(mesh, list[n], origin);
        uint overlapped = overlapped_children(mesh.records + list[n], frame, &vectors);
        const float altitude = mesh.records[list[n]].altitude;
        for (; overlapped; overlapped &= overlapped - 1) {
            const uint vector = lowest_bit(overlapped);
            const float margin = margins[vector];
            uint is_near = 0;
            floatL least[PARTS];
            for (int part = 0; part < PARTS; ++part) {
                const uint at = OF_VECTOR(part);
                const floatL squared = squared_of_vector(frame, altitude, vector, part, brick);
                const floatL bound = load_lanes(0, brick->bound + at);
                least[part] = squared - margin;
                const uint bits = lanes_to_bits(least[part] <= bound);
                is_near |= bits;
                if (bits) store_lanes(LESSER(squared + margin, bound), 0, brick->bound + at);
            }
            if (!is_near) continue;
            for (int part = 0; part < PARTS; ++part) store_lanes(least[part], part, brick->candidate[candidates]);
            brick->record[candidates] = list[n];
            brick->vector[candidates] = vector;
            if (++candidates == CLSDF_CANDIDATES) {
                decide_candidates(mesh, candidates, errors, brick);
                candidates = 0;
            }
        }
    }
    decide_candidates(mesh, candidates, errors, brick);
}

// Appends the records of a list, or all if it is null, whose mark has a bit. Returns how many.
static uint choose_marked(uint count, __global const uint* list, __global const ushort* marks, uint bit,
                          __global uint* chosen) {
    uint length = 0, i = 0;
    for (; i + 16 <= count; i += 16) {
        const ulong4 four = as_ulong4(vload16(0, marks + i)) & (ulong4)(0x0001000100010001ul << bit);
        const ulong2 two = four.lo | four.hi;
        if ((two.x | two.y) == 0) continue;
        for (uint k = i; k < i + 16; ++k) {
            chosen[length] = list ? list[k] : k;
            length += marks[k] >> bit & 1u;
        }
    }
    for (; i < count; ++i) {
        chosen[length] = list ? list[i] : i;
        length += marks[i] >> bit & 1u;
    }
    return length;
}

// Work-items take blocks begin + next_block[0]++ until `end`. lists: room for two lists of all polyhedra and one more
// number for each work-item; marks: for one.
__kernel void nearest_by_groups(uint begin, uint end, __global uint* next_block, __global const PointGroup* blocks,
                                __global const PointGroup* bricks, __global const double* points, uint point_count,
                                double most, ScanCounts counts, __global const ScanRecord* records,
                                __global const Polyhedron* polyhedra, __global const PointFace* all_faces,
                                __global const FaceNeighbours* neighbours, __global const uint* ring_starts,
                                __global const uint* ring_faces, __global const uint* site_vertices,
                                __global const ushort* marks_of_blocks, __global uint* all_lists,
                                __global ushort* all_marks, __global PointBrick* all_bricks, __global uint* faces,
                                __global double* squared) {
    const ScanMesh mesh = {counts, records, polyhedra, all_faces, neighbours, ring_starts, ring_faces, site_vertices};
    const uint all = counts.records;
    __global uint* list = all_lists + get_global_id(0) * 2 * (size_t)(all + 1);
    __global uint* brick_list = list + (all + 1);
    __global ushort* marks = all_marks + get_global_id(0) * (size_t)all;
    __global PointBrick* brick = all_bricks + get_global_id(0);
    for (;;) {
        const uint block = begin + atomic_inc(next_block);
        if (block >= end) break;
        const uint count = choose_marked(all, 0, marks_of_blocks + (size_t)(block / CLSDF_GROUP_WIDTH) * all,
                                         block % CLSDF_GROUP_WIDTH, list);
        Children children;
        NearestFeet feet;
        find_bounds(blocks + block, records, count, list, limit_of(most), &children, &feet);
        const int3 origin = origin_of(blocks + block);
        for (uint i = 0; i < count; ++i) {
            request_later(list, i, count, records);
            marks[i] = (ushort)overlapped_children(records + list[i], frame_from(mesh, list[i], origin), &children);
        }
        for (uint b = 0; b < blocks[block].children; ++b) {
            const uint first = block * CLSDF_POINTS_OF_BLOCK + b * CLSDF_POINTS_OF_BRICK;
            const uint chosen = choose_marked(count, list, marks, b, brick_list);
            scan_brick(mesh, bricks + block * CLSDF_GROUP_WIDTH + b, points, first, point_count, chosen, brick_list,
                       most, brick);
            for (uint i = 0; i < CLSDF_POINTS_OF_BRICK && first + i < point_count; ++i) {
                faces[first + i] = lowest_face(all_faces, brick->face[i]);
                squared[first + i] = brick->squared[i];
            }
        }
    }
}
