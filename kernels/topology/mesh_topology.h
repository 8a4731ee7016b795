// One definition for the host and the kernels: the results of a GPU that looks at a mesh (mesh_topology.cl).
#ifndef CLSDF_MESH_TOPOLOGY_H
#define CLSDF_MESH_TOPOLOGY_H

#include "polyhedron.h"

// Work-groups that measure the box of a mesh, at most; corners of a work-group that numbers vertices.
#define CLSDF_BOX_GROUPS 256
#define CLSDF_CORNER_TILE 2048
// Faces whose volumes are summed one after the other.
#define CLSDF_VOLUME_LEAF 64
// Slots of the hash table that a vertex tries, and faces around the end of an edge that has fewer: with more the
// kernels would take too long.
#define CLSDF_MOST_PROBES 4096
#define CLSDF_MOST_RING 4096

// A bit of the first equal vertex of each one: that one is in use.
#define CLSDF_IN_USE 0x80000000u

#ifndef __OPENCL_VERSION__
namespace clsdf {
#endif

// The results that the host reads. They begin as zeros.
typedef struct TopologyResults {
    double box[6];                    // of the vertices in use: lower corner, upper corner
    double volume[2];                 // sum, and sum of magnitudes: LocalFrame::add_volume()
    clsdf_uint32 is_refused;          // 1: beyond the limits above, or no mesh; all other results are undefined
    clsdf_uint32 used_vertices;       // of the caller's
    clsdf_uint32 different_vertices;  // the same, but those of equal coordinates count once
    clsdf_uint32 vertex_count;        // of the mesh in its order
    clsdf_uint32 joined_vertices;     // vertex_count minus the number of parts that share no vertex
    clsdf_uint32 marked_edges;        // edges of faces that have a mark
    clsdf_uint32 irregular_faces;     // faces that have an edge with another mark than CLSDF_MARK_OPEN
    clsdf_uint32 unused;
} TopologyResults;

// The sizes of a mesh, and where its parts of an array of words begin, all of which begin as zeros.
typedef struct TopologySizes {
    clsdf_uint32 vertices;  // the caller's
    clsdf_uint32 faces;
    clsdf_uint32 slots;          // of the hash table, a power of two
    clsdf_uint32 cells;          // on an axis, of the Morton order
    clsdf_uint32 table;          // the hash table: complements of vertices
    clsdf_uint32 used;           // a bit for each vertex: in use
    clsdf_uint32 classes;        // a bit for each vertex: a vertex in use equals it, and none before it does
    clsdf_uint32 first_corners;  // of each vertex: the complement of the first corner there
    clsdf_uint32 above;          // of each vertex: 1 + a lower one of its part, or 0
} TopologySizes;

// Where the numbers of an array lie, in words of 32 bits: that of item 0, and from an item to the next one, from a
// number to the next one.
typedef struct GivenTriples {
    clsdf_uint64 first;
    clsdf_int64 triple;
    clsdf_int64 number;
    clsdf_uint32 is_long;  // numbers have 64 bits
    clsdf_uint32 unused;
} GivenTriples;

#ifndef __OPENCL_VERSION__
static_assert(sizeof(GivenTriples) == 32);
static_assert(sizeof(TopologyResults) == 96);
static_assert(sizeof(TopologySizes) == 36);
}  // namespace clsdf
#endif

#endif
