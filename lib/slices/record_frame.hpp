#pragma once

#include "polyhedra/vector.hpp"
#include "slices/convex_pieces.hpp"

#include <array>
#include <cstdint>
#include <span>

namespace clsdf::slices {

/// A length in units, affine in a sample's offset from an integer origin.
struct Affine {
    polyhedra::Vector gradient;
    double constant = 0;

    friend Affine operator*(double factor, const Affine& a) { return {factor * a.gradient, factor * a.constant}; }
    friend Affine operator+(const Affine& a, const Affine& b) {
        return {a.gradient + b.gradient, a.constant + b.constant};
    }
    friend Affine operator-(const Affine& a, double constant) { return {a.gradient, a.constant - constant}; }
};

/// The frame of a record (kernels/polyhedron.h), and the lengths that follow from it, in double precision.
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
        const polyhedra::Vector normal = value.gradient / steepness;
        planes_[count_++] = {{normal.x(), normal.y(), normal.z()}, -value.constant / steepness};
    }
    std::span<const PiecePlane> span() const { return std::span(planes_).first(count_); }
    std::size_t size() const { return count_; }

private:
    std::array<PiecePlane, CLSDF_MOST_PLANES> planes_{};
    std::size_t count_ = 0;
};

}  // namespace clsdf::slices
