// One definition for the host and the kernels: names of faces, the vertices opposite to their edges, marks of edges.
#ifndef CLSDF_FACE_EDGES_H
#define CLSDF_FACE_EDGES_H

// A face's name is its triangle's index in the caller's order, with this bit if three faces or more meet at an edge.
#define CLSDF_NAME_NON_MANIFOLD 0x80000000u
// The vertex opposite to an edge: of the other face there, whose edge with this number it is, from this bit on.
#define CLSDF_OPPOSITE_EDGE 30
#define CLSDF_OPPOSITE_VERTEX 0x3FFFFFFFu
// In its place: no plane cuts there, as at open edges; or the host decides. No edge has the number 3.
#define CLSDF_NO_VERTEX 0xFFFFFFFFu
#define CLSDF_UNPAIRED_EDGE 0xFFFFFFFEu
#define CLSDF_FIRST_NO_VERTEX 0xC0000000u
// EdgeMark of lib/engine/topology/topology.hpp. Kernels of the topology set open, non-manifold, unoriented and at a
// box.
#define CLSDF_MARK_CONVEX 1u
#define CLSDF_MARK_CONCAVE 2u
#define CLSDF_MARK_OPEN 4u
#define CLSDF_MARK_NON_MANIFOLD 8u
#define CLSDF_MARK_UNORIENTED 16u
#define CLSDF_MARK_AT_BOX 32u
#define CLSDF_MARK_FOLDED 64u

#endif
