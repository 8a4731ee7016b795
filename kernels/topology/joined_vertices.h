// Sets of vertices that many work-items join at once. above: of each vertex, 1 + a lower one of its set, or 0.
#ifndef CLSDF_JOINED_VERTICES_H
#define CLSDF_JOINED_VERTICES_H

#include "mesh_groups.h"

// The lowest vertex that this one is known to be joined with. All that is read may be old: it is above all the same.
// Vertex 0 has none below: its word is not read, for which all work-items would wait in most meshes.
static inline uint root_of(Atomic above, uint vertex) {
    while (vertex != 0) {
        const uint parent = atomic_or(above + vertex, 0u);
        if (parent == 0) return vertex;
        if (parent == 1) return 0;
        const uint next = atomic_or(above + parent - 1, 0u);
        if (next == 0) return parent - 1;
        atomic_cmpxchg(above + vertex, parent, next);
        vertex = next - 1;
    }
    return 0;
}

// Joins two sets of vertices; returns 1 if they were different. How many calls return 1 does not depend on their order.
static inline uint join(Atomic above, uint a, uint b) {
    for (;;) {
        a = root_of(above, a);
        b = root_of(above, b);
        if (a == b) return 0;
        if (atomic_cmpxchg(above + max(a, b), 0u, min(a, b) + 1) == 0) return 1;
    }
}

#endif
