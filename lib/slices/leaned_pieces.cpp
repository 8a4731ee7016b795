#include "slices/leaned_pieces.hpp"

#include "polyhedra/vector.hpp"

#include <cmath>

namespace clsdf::slices {

namespace {

using polyhedra::Vector;

/// A length in units, affine in the sample's offset from the record's origin.
struct Affine {
    Vector gradient;
    double constant;
};

Affine operator*(double factor, const Affine& a) {
    return {factor * a.gradient, factor * a.constant};
}
Affine operator+(const Affine& a, const Affine& b) {
    return {a.gradient + b.gradient, a.constant + b.constant};
}
Affine operator-(const Affine& a, double constant) {
    return {a.gradient, a.constant - constant};
}

/// A record's frame and outward distances from its edges.
class Record {
public:
    explicit Record(const Polyhedron& p) : p_(p) {
        const auto coordinate = [&](std::size_t i) {
            return Affine{{p.exact_gradient_x[i], p.exact_gradient_y[i], p.exact_gradient_z[i]},
                          p.exact_constant_at_origin[i]};
        };
        x_ = coordinate(0);
        z_ = coordinate(2);
        const Affine y = coordinate(1);
        outward_[CLSDF_EDGE_BASE] = -1 * y;
        outward_[CLSDF_EDGE_RIGHT] =
            slanted(CLSDF_HALF_RIGHT) * (x_ - base(CLSDF_HALF_RIGHT)) + across(CLSDF_HALF_RIGHT) * y;
        outward_[CLSDF_EDGE_LEFT] =
            slanted(CLSDF_HALF_LEFT) * (-1 * x_ - base(CLSDF_HALF_LEFT)) + across(CLSDF_HALF_LEFT) * y;
    }

    const Affine& along() const { return x_; }
    const Affine& height() const { return z_; }
    const Affine& outward(std::size_t edge) const { return outward_[edge]; }
    double base(std::size_t half) const { return p_.exact_base[half]; }
    bool is_compact() const { return (p_.flags & CLSDF_POLYHEDRON_COMPACT) != 0; }

private:
    double slanted(std::size_t half) const { return p_.exact_normal_along[half]; }
    double across(std::size_t half) const { return p_.exact_normal_across[half]; }

    const Polyhedron& p_;
    Affine x_;
    Affine z_;
    std::array<Affine, 3> outward_;
};

/// Half-spaces of one piece.
class Planes {
public:
    /// value <= 0, where the value's gradient has the length `steepness` in the metric frame.
    void add(const Affine& value, double steepness = 1) {
        const Vector normal = value.gradient / steepness;
        planes_[count_++] = {{normal.x(), normal.y(), normal.z()}, -value.constant / steepness};
    }
    std::span<const PiecePlane> span() const { return std::span(planes_).first(count_); }

private:
    std::array<PiecePlane, CLSDF_MOST_PLANES> planes_;
    std::size_t count_ = 0;
};

/// The bounds of the outward distance from an edge on the side where `height` > 0.
void add_lateral_planes(const Affine& outward, const Affine& height, double slope, double cap, double slack,
                        Planes& planes) {
    const double at_face = slack * (1 + slope);
    const double widest = cap + slack;
    const bool leans = at_face < widest;
    if (leans) planes.add(outward + -slope * height - at_face, std::sqrt(1 + slope * slope));
    if (!leans || slope * widest + at_face > widest) planes.add(outward - widest);
}

void add_pieces(const Polyhedron& polyhedron, std::uint32_t index, double cap, double slack,
                PieceCollector& collector) {
    const Record record(polyhedron);
    const std::array<std::int32_t, 3> origin{polyhedron.origin_x, polyhedron.origin_y, polyhedron.origin_z};
    const auto are_all = [&](auto&& condition) {
        return std::all_of(polyhedron.slope_above, polyhedron.slope_above + 3, condition) &&
               std::all_of(polyhedron.slope_below, polyhedron.slope_below + 3, condition);
    };
    // A box, or a prism: convex as a whole.
    const bool is_open = are_all([&](float slope) { return slack * static_cast<double>(slope) >= cap; });
    const bool is_prism = are_all([](float slope) { return slope == 0; });
    const double widest = cap + slack;
    for (const double side : {1.0, -1.0}) {
        const bool is_whole = is_open || is_prism;
        if (is_whole && side < 0) continue;
        const float* own = side > 0 ? polyhedron.slope_above : polyhedron.slope_below;
        const Affine height = side * record.height();
        Planes planes;
        for (std::size_t edge = 0; edge < 3; ++edge)
            add_lateral_planes(record.outward(edge), height, static_cast<double>(own[edge]), cap, slack, planes);
        planes.add(height - widest);
        planes.add(-1 * height - (is_whole ? widest : slack));
        if (!record.is_compact()) {
            planes.add(record.along() - (record.base(CLSDF_HALF_RIGHT) + widest));
            planes.add(-1 * record.along() - (record.base(CLSDF_HALF_LEFT) + widest));
        }
        collector.add(origin, index, planes.span());
    }
}

}  // namespace

ConvexPieces leaned_pieces(std::span<const Polyhedron> polyhedra, double half_width, double slack, const Layout& grid) {
    return collect_pieces(polyhedra.size(), grid, [&](std::size_t i, PieceCollector& collector) {
        add_pieces(polyhedra[i], static_cast<std::uint32_t>(i), half_width, slack, collector);
    });
}

}  // namespace clsdf::slices
