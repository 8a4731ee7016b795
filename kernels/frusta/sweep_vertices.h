// Kernels that make the vertices of the sign's sweep from a mesh's positions.
#ifndef CLSDF_SWEEP_VERTICES_H
#define CLSDF_SWEEP_VERTICES_H

#include "face_frames.h"
#include "sweep.h"

// The vertex of the sign's sweep, as lib/engine/sign/sweep_mesh.cpp snaps it to multiples of 1 / scale samples. It is
// not far from the lattice's sample (0, 0, 0).
INLINE SweepVertex sweep_vertex(FaceLattice lattice, double scale_y, double scale_z, double3 position) {
    const double3 spacing = vload3(0, lattice.spacing) / lattice.per_unit;  // exact: a unit is a power of two
    const double3 samples = (position - vload3(0, lattice.origin)) / spacing;
    const SweepVertex vertex = {(long)rint(samples.y * scale_y), (long)rint(samples.z * scale_z), samples.x};
    return vertex;
}

__kernel void sweep_vertices(FaceLattice lattice, double scale_y, double scale_z, uint begin, uint end,
                             __global const double* positions, __global SweepVertex* vertices) {
    const uint n = begin + get_global_id(0);
    if (n < end) vertices[n] = sweep_vertex(lattice, scale_y, scale_z, vload3(n, positions));
}

// Makes the sweep's vertices and triangles of some clusters' faces: three vertices a face, none shared. A work-item has
// a corner; the mesh's last cluster may have fewer faces.
__kernel void sweep_clusters(FaceLattice lattice, double scale_y, double scale_z, uint begin, uint end,
                             __global const uint* clusters, __global const uint* triangles,
                             __global const double* positions, __global uint* corners, __global SweepVertex* vertices) {
    const uint n = begin + get_global_id(0);
    if (n >= end) return;
    const uint of_cluster = 3 * CLSDF_CLUSTER, corner = clusters[n / of_cluster] * of_cluster + n % of_cluster;
    corners[n] = n;
    vertices[n] = sweep_vertex(lattice, scale_y, scale_z, vload3(triangles[corner], positions));
}

#endif
