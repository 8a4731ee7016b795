#pragma once

#include <clsdf/mesh.hpp>

#include "core/uninitialized_vector.hpp"
#include "polyhedra/lattice_view.hpp"
#include "polyhedron.h"

#include <cstddef>
#include <functional>
#include <span>

namespace clsdf::polyhedra {

struct LeanedCounts {
    std::size_t records = 0;          ///< polyhedra of triangles and of point sites
    std::size_t saddle_vertices = 0;  ///< with convex and concave edges, by exact predicates
    std::size_t point_sites = 0;
    std::size_t boxes = 0;  ///< faces so degenerate that their polyhedron is a box
};

struct LeanedFrusta : LeanedCounts {
    /// A polyhedron a triangle, in Morton order, then the point sites by vertex. Together they are exact: every point y
    /// within `half_width` of the mesh lies in the polyhedron of a triangle at the distance dist(y, mesh).
    UninitializedVector<Polyhedron> polyhedra;
};

/// What the tests switch off to see that it is needed.
struct LeanedFrustaOptions {
    bool lean = true;         ///< obtuse corners lean their neighbours' planes outward
    bool point_sites = true;  ///< gaps at saddle vertices get a polyhedron of their own
};

/// The exact bounding polyhedra (docs/method.md, 'Leaned frusta') for a band of `half_width` units (finite), widened by
/// `slack` units, which must exceed the rounding of every test made with them: slack >= 1e-3 + 2e-5 half_width.
LeanedFrusta leaned_frusta(const Mesh& mesh, const LatticeView& lattice, double half_width, double slack,
                           const LeanedFrustaOptions& options = {});

/// The same polyhedra, written to `memory(count)`, memory for as many records or more than there are. It is called once
/// more where there are unusually many point sites: then for all of them, and with what was written before. What is
/// needed on the way may come from `scratch`.
LeanedCounts leaned_frusta(const Mesh& mesh, const LatticeView& lattice, double half_width, double slack,
                           const std::function<std::span<Polyhedron>(std::size_t)>& memory, ScratchMemory* scratch,
                           const LeanedFrustaOptions& options = {});

}  // namespace clsdf::polyhedra
