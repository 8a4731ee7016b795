#pragma once

#include "core/parallel.hpp"
#include "frusta/frames.hpp"
#include "frusta/records.hpp"
#include "papers/convex_polyhedron.hpp"

#include "piece.h"

#include <clsdf/mesh.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// Bounding polyhedra of any kind as convex pieces, for the scan by slices.
namespace clsdf::papers {

/// The difference position - sample, in units.
inline engine::Vector from_sample(const engine::LatticeView& lattice, const Vec3& position,
                                  const std::array<std::int32_t, 3>& sample) {
    return {lattice.from_sample(0, position[0], sample[0]), lattice.from_sample(1, position[1], sample[1]),
            lattice.from_sample(2, position[2], sample[2])};
}

/// The mean cost of a piece in each of its slices.
struct PieceCost {
    float rows = 0;
    float samples = 0;
};

struct ConvexPieces {
    std::vector<Piece> pieces;
    std::vector<PiecePlane> planes;
    std::vector<PieceCost> costs;  ///< of each piece

    void append(const ConvexPieces& other);
};

/// Keeps the pieces that cut a slice of a grid within the grid, each with its slices.
class PieceCollector {
public:
    PieceCollector(const Layout& grid, ConvexPieces& kept) : grid_(grid), kept_(kept) {}

    /// A piece of `planes` (unit normals in the metric frame, CLSDF_MOST_PLANES at most; the slack not yet added) for
    /// the polyhedron's record, and the site of it that gives the distance.
    void add(const std::array<std::int32_t, 3>& origin, std::uint32_t polyhedron, std::span<const PiecePlane> planes,
             std::uint32_t site = CLSDF_SITE_NEAREST);

private:
    const Layout& grid_;
    ConvexPieces& kept_;
};

/// Calls make_pieces(source, collector) for each source, on all cores; the pieces are in the order of the sources.
template <typename MakePieces>
ConvexPieces collect_pieces(std::size_t source_count, const Layout& grid, const MakePieces& make_pieces) {
    constexpr std::size_t batch = 1024;
    std::vector<ConvexPieces> batches(chunk_count(source_count, batch));
    for_each_chunk(source_count, batch, [&](std::size_t b, std::size_t begin, std::size_t end) {
        PieceCollector collector(grid, batches[b]);
        for (std::size_t source = begin; source < end; ++source) make_pieces(source, collector);
    });
    ConvexPieces all;
    for (ConvexPieces& part : batches) {
        all.append(part);
        part = {};
    }
    return all;
}

/// A length in units, affine in a sample's offset from an integer origin.
struct Affine {
    engine::Vector gradient;
    double constant = 0;

    friend Affine operator*(double factor, const Affine& a) { return {factor * a.gradient, factor * a.constant}; }
    friend Affine operator+(const Affine& a, const Affine& b) {
        return {a.gradient + b.gradient, a.constant + b.constant};
    }
    friend Affine operator-(const Affine& a, double length) { return {a.gradient, a.constant - length}; }
};

/// The frame of a record (kernels/common/polyhedron.h), and the lengths that follow from it, in double precision.
class RecordFrame {
public:
    explicit RecordFrame(const Polyhedron& p) : p_(p) {
        const auto coordinate = [&](std::size_t i) {
            return Affine{{p.exact_gradient_x[i], p.exact_gradient_y[i], p.exact_gradient_z[i]},
                          p.exact_constant_at_origin[i]};
        };
        x_ = coordinate(0);
        y_ = coordinate(1);
        z_ = coordinate(2);
    }

    std::array<std::int32_t, 3> origin() const { return {p_.origin_x, p_.origin_y, p_.origin_z}; }

    const Affine& along() const { return x_; }
    const Affine& height() const { return z_; }

    /// From an edge, in the face's plane, away from the face.
    Affine outward(std::size_t edge) const {
        if (edge == CLSDF_EDGE_BASE) return -1 * y_;
        const Half h = half_of(edge);
        return h.along * (h.away - h.base) + h.across * y_;
    }
    /// How far before an edge's beginning, and past its end, in its direction; the slanted edges begin at the base.
    Affine before(std::size_t edge) const {
        if (edge == CLSDF_EDGE_BASE) return -1 * x_ - base(CLSDF_HALF_LEFT);
        const Half h = half_of(edge);
        return h.across * (h.away - h.base) + -h.along * y_;
    }
    Affine past(std::size_t edge) const {
        if (edge == CLSDF_EDGE_BASE) return x_ - base(CLSDF_HALF_RIGHT);
        const Half h = half_of(edge);
        return h.along * (y_ - p_.exact_altitude) + -h.across * h.away;
    }

    double base(std::size_t half) const { return p_.exact_base[half]; }
    bool is_compact() const { return (p_.flags & CLSDF_POLYHEDRON_COMPACT) != 0; }

private:
    struct Half {
        Affine away;  ///< from the altitude
        double base = 0, along = 0, across = 0;
    };

    Half half_of(std::size_t edge) const {
        const std::size_t half = edge == CLSDF_EDGE_RIGHT ? CLSDF_HALF_RIGHT : CLSDF_HALF_LEFT;
        return {half == CLSDF_HALF_RIGHT ? x_ : -1 * x_, base(half), p_.exact_normal_along[half],
                p_.exact_normal_across[half]};
    }

    const Polyhedron& p_;
    Affine x_;
    Affine y_;
    Affine z_;
};

/// Half-spaces of one piece.
class PieceBounds {
public:
    /// value <= 0, where the value's gradient has the length `steepness` in the metric frame.
    void add(const Affine& value, double steepness = 1) {
        const engine::Vector normal = value.gradient / steepness;
        planes_[count_++] = {{normal.x(), normal.y(), normal.z()}, -value.constant / steepness};
    }
    std::span<const PiecePlane> span() const { return std::span(planes_).first(count_); }
    std::size_t size() const { return count_; }

private:
    std::array<PiecePlane, CLSDF_MOST_PLANES> planes_{};
    std::size_t count_ = 0;
};

/// The pieces of leaned frusta: of each the part above its face and that below, both convex, widened by `slack` units
/// and cut at `half_width`. They are the sides that the record's test takes together (kernels/common/polyhedron.h), but
/// for what that mixes of both within the slack about the face; each by itself holds what docs/method.md, 'Why nothing
/// is lost', asks of it.
ConvexPieces leaned_pieces(std::span<const Polyhedron> polyhedra, double half_width, double slack, const Layout& grid);

/// The bounding polyhedra as Peikert & Sigg published them. They are not exact (docs/method.md, 'Why the published
/// polyhedra are not exact'): they are here to be compared with.
/// The slab of the half width about a triangle, cut by the bisector planes of the dihedral angles at its edges.
struct BisectorPolyhedron {
    std::uint32_t triangle = 0;  ///< index in the mesh
    engine::Vector normal;
    double half_width = 0;
    // By edge; edge k runs from the triangle's vertex k to the next:
    std::array<engine::Vector, 3> corners;   ///< where the edge begins
    std::array<engine::Vector, 3> bisector;  ///< unit normal of its lateral plane, pointing outward
    std::array<double, 3> shift{};           ///< how far gap closing moved the plane outward

    bool contains(const engine::Vector& point) const;
};

/// The remedy for a gap: the lateral planes at a vertex moved outward until every polyhedron there has `vertex + point`
/// and `vertex - point` within its two.
struct GapClosing {
    std::uint32_t vertex = 0;
    engine::Vector point;
};

struct BisectorPolyhedra {
    std::vector<BisectorPolyhedron> polyhedra;  ///< of each triangle with three different vertices, in the mesh's order
    std::vector<GapClosing> closings;           ///< of the vertices at which the published test fails
};

/// If an edge does not have exactly one other face, or one that is folded onto the triangle, the lateral plane is
/// perpendicular to the triangle. `half_width` > 0 in the mesh's units.
BisectorPolyhedra peikert_sigg_polyhedra(const Mesh& mesh, double half_width, bool close_gaps = true);

struct PeikertSiggPieces {
    UninitializedVector<Polyhedron> polyhedra;  ///< for the distances alone: without slopes
    ConvexPieces pieces;                        ///< one a polyhedron
    std::size_t closed_gaps = 0;                ///< vertices at which the published test fails
};

/// The polyhedra that Peikert & Sigg published, for a band of `half_width` units. They are not
/// widened: CLSDF_PIECE_SLACK repairs none of their errors.
PeikertSiggPieces peikert_sigg_pieces(const Mesh& mesh, const engine::LatticeView& lattice, double half_width,
                                      bool close_gaps, const Layout& grid);

struct MauchPieces {
    UninitializedVector<Polyhedron> polyhedra;  ///< of the triangles, for the distances alone: no slopes
    ConvexPieces pieces;
    std::size_t towers = 0;
    std::size_t wedges = 0;
    std::size_t cones = 0;
    std::size_t boxes = 0;  ///< of degenerate triangles

    std::size_t count() const { return towers + wedges + cones + boxes; }
};

/// Mauch's polyhedra (S. Mauch, Efficient Algorithms for Solving Static Hamilton-Jacobi Equations, 2003), for a band of
/// `half_width` units: a tower on both sides of each face, a wedge at each edge, a cone at each vertex, each with the
/// distance to its own site. They are the sites' normal cones (docs/method.md, 'What an exact polyhedron must
/// contain'), and therefore exact for every set of triangles, not only for closed surfaces: at an edge the one sector,
/// at a vertex the one cone whose directions lead away from all faces there. An edge whose faces are in one plane has
/// none, nor has a vertex whose neighbours surround it.
///
/// A face too degenerate for its walls to be known within CLSDF_PIECE_SLACK gets a box with the distance to the nearest
/// of its seven sites instead, which does for its edges and vertices too.
MauchPieces mauch_pieces(const Mesh& mesh, const engine::LatticeView& lattice, double half_width, const Layout& grid);

}  // namespace clsdf::papers
