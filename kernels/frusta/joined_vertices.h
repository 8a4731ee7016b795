// Sets of vertices that many work-items join at once. above: of each vertex, 1 + a lower one of its set, or 0.
#ifndef CLSDF_JOINED_VERTICES_H
#define CLSDF_JOINED_VERTICES_H

#include "mesh_groups.h"

// The lowest vertex that this one is known to be joined with. All that is read may be old: it is above all the same.
// So plain reads do. All work-items read the word of the lowest vertex, where atomic functions would wait for one
// another.
static inline uint root_of(Atomic above, uint vertex) {
    for (;;) {
        const uint parent = above[vertex];
        if (parent == 0) return vertex;
        const uint next = above[parent - 1];
        if (next == 0) return parent - 1;
        atomic_cmpxchg(above + vertex, parent, next);
        vertex = next - 1;
    }
}

// Joins two sets of vertices; returns 1 if they were different. How many calls return 1 does not depend on their order.
static inline uint join(Atomic above, uint a, uint b) {
    for (;;) {
        a = root_of(above, a);
        b = root_of(above, b);
        if (a == b) return 0;
        const uint high = max(a, b), low = min(a, b), found = atomic_cmpxchg(above + high, 0u, low + 1);
        if (found == 0) return 1;
        a = found - 1;  // which a plain read need not show
        b = low;
    }
}

#endif
