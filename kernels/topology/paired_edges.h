// The other face at an edge of a face.
#ifndef CLSDF_PAIRED_EDGES_H
#define CLSDF_PAIRED_EDGES_H

#include "face_edges.h"
#include "mesh_topology.h"

static inline uint next_of(uint k) {
    return k == 2 ? 0 : k + 1;
}
static inline uint previous_of(uint k) {
    return k == 0 ? 2 : k - 1;
}

// The data of an edge that begins at a corner.
typedef struct PairedEdge {
    uint mark;
    uint across;  // packed
    bool is_too_long;
} PairedEdge;

// An edge has two faces, unless a third one is found, around the end that has fewer faces.
static inline PairedEdge paired_edge(uint face, uint k, __global const uint* triangles, __global const uint* starts,
                                     __global const uint* corners) {
    PairedEdge edge = {0u, 0u, false};
    const uint own = face << 2 | k, v = triangles[3 * (size_t)face + k], w = triangles[3 * (size_t)face + next_of(k)];
    if (v == w) {
        edge.mark = CLSDF_MARK_AT_BOX;
        return edge;
    }
    const bool is_at_v = starts[v + 1] - starts[v] <= starts[w + 1] - starts[w];
    const uint at = is_at_v ? v : w, end = is_at_v ? w : v, begin = starts[at], last = starts[at + 1];
    if (last - begin > CLSDF_MOST_RING) {
        edge.is_too_long = true;
        return edge;
    }
    uint count = 0, other = own;
    for (uint i = begin; i < last && count <= 2; ++i) {
        const uint around = corners[i] >> 2, j = corners[i] & 3;
        __global const uint* const t = triangles + 3 * (size_t)around;
        const uint leaving = around << 2 | j, arriving = around << 2 | previous_of(j);
        if (t[next_of(j)] == end) {
            ++count;
            other = leaving != own ? leaving : other;
        }
        if (t[previous_of(j)] == end) {
            ++count;
            other = arriving != own ? arriving : other;
        }
    }
    if (count > 2 || (count == 2 && other >> 2 == face)) {
        edge.mark = CLSDF_MARK_NON_MANIFOLD;
    } else if (count == 1) {
        edge.mark = CLSDF_MARK_OPEN;
    } else {
        edge.across = other;
        edge.mark = triangles[3 * (size_t)(other >> 2) + (other & 3)] == v ? CLSDF_MARK_UNORIENTED : 0u;
    }
    return edge;
}

#endif
