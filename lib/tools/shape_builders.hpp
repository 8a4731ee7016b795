#pragma once

#include "mesh/mesh_arrays.hpp"

namespace clsdf::shapes {

/// An octahedron inscribed in the unit sphere, each triangle split into four `level` times, new vertices moved onto
/// the sphere: 4^(level + 1) + 2 vertices.
MeshArrays subdivided_octahedron(int level);

/// The tube of radius 1/3 around the unit circle, 100 x 30 vertices, every ring turned against the one before it.
MeshArrays torus();

/// A tube around the (2, 3) torus knot, 240 x 6 vertices.
MeshArrays knot();

/// A spiral tube that widens, 83 x 11 vertices, and a vertex in the middle of either end.
MeshArrays seashell();

/// A subdivided icosahedron of 20,480 triangles whose vertices are moved along their radius by up to 0.6 of an edge.
MeshArrays noisy_sphere();

/// Three concentric spheres of radius 1, 0.7 and 0.4, of which the middle one looks inwards.
MeshArrays nested_spheres();

/// A solid flight of 24 steps.
MeshArrays stairs();

/// A box of 1 x 0.75 x thickness, of 12 x 9 cells, tilted against all axes.
MeshArrays plate(double thickness);

/// A spike of length 1 and width 1e-6, tilted against all axes.
MeshArrays needle();

MeshArrays cube();
MeshArrays tetrahedron();

/// A floor with a step of one thousandth of its depth: the nearest face lies beyond the bisector plane of its own edge.
MeshArrays step();

/// A floor with a thin flap that all but lies on it.
MeshArrays flap();

}  // namespace clsdf::shapes
