// The decisions of the scan of points (point_scan.cl): a triangle that may be the nearest is evaluated in double, and
// so are the faces that share its site.
#ifndef CLSDF_SCAN_DECISIONS_H
#define CLSDF_SCAN_DECISIONS_H

#include "point_distance.h"
#include "point_groups.h"
#include "simd.h"

#define PARTS (CLSDF_GROUP_WIDTH / LANES)
// The index of a vector's first point of a part.
#define OF_VECTOR(part) (vector * CLSDF_GROUP_WIDTH + (part)*LANES)

// If squared distances differ by less than this, faces that share a site are evaluated, too.
#define TIE_RATE 1.0e-9
#define TIE_SLACK 1.0e-15

// All that a scan reads of the mesh.
typedef struct ScanMesh {
    ScanCounts counts;
    __global const ScanRecord* records;
    __global const Polyhedron* polyhedra;  // of the faces
    __global const PointFace* faces;
    __global const FaceNeighbours* neighbours;
    __global const uint* ring_starts;  // of each vertex in ring_faces, and the end
    __global const uint* ring_faces;
    __global const uint* site_vertices;  // of the point sites
} ScanMesh;

// Takes a face for the points of a vector that it is nearest to so far. Returns the squared distances, in part `part`.
INLINE FaceDistance take_face(ScanMesh mesh, uint face, uint vector, int part, __global PointBrick* brick) {
    const uint at = OF_VECTOR(part);
    const FaceDistance d = face_distance(mesh.polyhedra + face, mesh.faces + face, load_lanes(0, brick->at[0] + at),
                                         load_lanes(0, brick->at[1] + at), load_lanes(0, brick->at[2] + at));
    const doubleL squared = load_lanes(0, brick->squared + at);
    const uintL triangle = load_lanes(0, brick->triangle + at);
    const uint own = mesh.faces[face].triangle;
    const intL is_less = convert_intL(d.squared < squared), is_equal = convert_intL(d.squared == squared);
    const intL takes = is_less | (is_equal & (own < triangle));
    if (lanes_to_bits(takes)) {
        const uintL before = load_lanes(0, brick->face + at);
        store_doubles(LESSER(d.squared, squared), brick->squared + at);
        store_lanes(takes ? (uintL)own : triangle, 0, brick->triangle + at);
        store_lanes(takes ? (uintL)face : before, 0, brick->face + at);
    }
    return d;
}

#define BITS_OF(mask) lanes_to_bits(convert_intL(mask))

// Takes all faces at a vertex that may be the nearest site of points of the part. The vertices that were taken last are
// known, the latest first: a vertex may have thousands of faces, each of which asks for it.
static void take_vertex(ScanMesh mesh, uint vertex, uint vector, int part, __global PointBrick* brick) {
    __global uint* latest = brick->vertex + OF_VECTOR(part);
    const uint known = BITS_OF(load_lanes(0, latest) == (uintL)vertex);
    for (uint i = known ? lowest_bit(known) : LANES - 1; i > 0; --i) latest[i] = latest[i - 1];
    latest[0] = vertex;
    if (known) return;
    for (uint i = mesh.ring_starts[vertex]; i < mesh.ring_starts[vertex + 1]; ++i)
        take_face(mesh, mesh.ring_faces[i], vector, part, brick);
}

// Takes the faces that share a face's edge with points whose nearest site it may be.
INLINE void take_across(ScanMesh mesh, __global const FaceNeighbours* neighbours, uint edge, uint vector, int part,
                        uint lanes, __global PointBrick* brick) {
    const uint across = neighbours->across[edge];
    if (lanes == 0 || across == CLSDF_NONE_ACROSS) return;
    if (across == CLSDF_MANY_ACROSS)
        take_vertex(mesh, neighbours->vertex[edge], vector, part, brick);
    else
        take_face(mesh, across, vector, part, brick);
}

INLINE uint three_after(uint first, uint steps) {
    return (first + steps) % 3u;
}

// Decides a candidate in double. If the nearest point lies on an edge or a vertex, other faces share it. They may be
// missing from the list, and rounding decides between them, too. reach: how near, in units, an edge counts.
static void decide(ScanMesh mesh, uint record, uint vector, int part, uint lanes, float reach,
                   __global PointBrick* brick) {
    if (record >= mesh.counts.faces) {
        take_vertex(mesh, mesh.site_vertices[record - mesh.counts.faces], vector, part, brick);
        return;
    }
    __global const FaceNeighbours* neighbours = mesh.neighbours + record;
    const FaceDistance d = take_face(mesh, record, vector, part, brick);
    const doubleL squared = load_lanes(0, brick->squared + OF_VECTOR(part));
    lanes &= BITS_OF(d.squared <= squared + TIE_RATE * squared + TIE_SLACK);
    // In a face of less altitude than `reach`, a point may lie on all three edges: all faces at its vertices count.
    if (mesh.polyhedra[record].exact_altitude <= (double)reach) {
        for (uint k = 0; k < 3 && lanes; ++k) take_vertex(mesh, neighbours->vertex[k], vector, part, brick);
        return;
    }
    const uint left = BITS_OF(d.offsets.left) & lanes, right = lanes & ~left;
    const double near = -(double)reach;
    const uint slanted = BITS_OF(d.offsets.outward >= near) & lanes;
    const uint base = BITS_OF(d.offsets.y <= (double)reach) & lanes;
    if ((slanted | base) == 0) return;
    const uint end = ((base & BITS_OF(d.offsets.beyond >= near)) | (slanted & BITS_OF(d.offsets.before >= near)));
    const uint apex = slanted & BITS_OF(d.offsets.past >= near);
    const uint first = mesh.records[record].flags >> CLSDF_POLYHEDRON_VERTEX_SHIFT & 3u;
    if (end & left) take_vertex(mesh, neighbours->vertex[first], vector, part, brick);
    if (end & right) take_vertex(mesh, neighbours->vertex[three_after(first, 1)], vector, part, brick);
    if (apex) take_vertex(mesh, neighbours->vertex[three_after(first, 2)], vector, part, brick);
    const uint edges = ~(end | apex);
    take_across(mesh, neighbours, first, vector, part, base & edges, brick);
    take_across(mesh, neighbours, three_after(first, 1), vector, part, slanted & right & edges, brick);
    take_across(mesh, neighbours, three_after(first, 2), vector, part, slanted & left & edges, brick);
}

static void decide_candidates(ScanMesh mesh, uint count, const __private float* errors, __global PointBrick* brick) {
    for (uint i = 0; i < count; ++i) {
        const uint vector = brick->vector[i];
        for (int part = 0; part < PARTS; ++part) {
            const floatL bound = load_lanes(0, brick->bound + OF_VECTOR(part));
            const uint lanes = lanes_to_bits(load_lanes(part, brick->candidate[i]) <= bound);
            if (lanes) decide(mesh, brick->record[i], vector, part, lanes, errors[vector], brick);
        }
    }
}

#endif
