#include "polyhedra/frames.hpp"

#include "polyhedra/topology.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clsdf::polyhedra {

namespace {

constexpr double sliver = 1e-8;
constexpr double vanishing = 1e-100;  // units; squares of shorter lengths leave the range of double
constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr std::size_t right = CLSDF_HALF_RIGHT;
constexpr std::size_t left = CLSDF_HALF_LEFT;

/// Differences of positions in units. They are taken before positions are brought to units: a small triangle far from
/// the lattice's origin keeps its shape to the last bit of the coordinates given.
class InUnits {
public:
    explicit InUnits(double unit) : unit_(unit), per_unit_(1 / unit) {}

    Vector difference(const Vec3& to, const Vec3& from) const {
        const Vector difference{to[0] - from[0], to[1] - from[1], to[2] - from[2]};
        return per_unit_ < std::numeric_limits<double>::infinity() ? Vector(per_unit_ * difference)
                                                                   : Vector(difference / unit_);
    }

private:
    double unit_;
    double per_unit_;
};

/// The edges of a triangle in units, and the longest of them, the base. Edge k runs from the vertex k to the next.
/// Without branches: they could not be predicted.
struct TriangleEdges {
    std::array<Vector, 3> vectors;
    std::array<double, 3> squared;  ///< lengths
    std::uint32_t base;

    TriangleEdges(const std::array<Vec3, 3>& corners, const InUnits& in_units)
        : vectors{in_units.difference(corners[1], corners[0]), in_units.difference(corners[2], corners[1]),
                  in_units.difference(corners[0], corners[2])},
          squared{dot(vectors[0], vectors[0]), dot(vectors[1], vectors[1]), dot(vectors[2], vectors[2])},
          base(squared[0] >= squared[1] ? 0 : 1) {
        const std::uint32_t is_last = squared[2] > squared[base] ? 1 : 0;
        base += is_last * (2 - base);
    }

    /// Everything at the apex is measured from the nearer end of the base: on needles the other end is too far away.
    /// CLSDF_HALF_RIGHT or _LEFT.
    std::uint32_t nearer_half() const {
        return squared[next_of_three(base)] <= squared[previous_of_three(base)] ? CLSDF_HALF_RIGHT : CLSDF_HALF_LEFT;
    }
    std::uint32_t near_end() const { return (base + 1 - nearer_half()) % 3; }
    Vector apex() const {
        const std::uint32_t half = nearer_half();
        return side_of(half) * vectors[(base + 1 + half) % 3];
    }
    /// 1 for the right half, -1 for the left one.
    static double side_of(std::uint32_t half) { return 1 - 2 * static_cast<double>(half); }
};

/// The foot of the altitude, from the end of the base that is nearer to the apex.
inline Vector foot_of(const TriangleFrame& frame, const Vec3& near_end, std::uint32_t nearer_half,
                      const LatticeView& lattice, const InUnits& in_units) {
    return in_units.difference(near_end, lattice.origin) -
           TriangleEdges::side_of(nearer_half) * frame.base[nearer_half] * frame.along;
}

/// Returns the slanted edge's length.
double set_slanted_edge(TriangleFrame& frame, std::size_t half, double altitude) {
    const double length = std::sqrt(frame.base[half] * frame.base[half] + altitude * altitude);
    frame.normal_along[half] = length > 0 ? altitude / length : 0;
    frame.normal_across[half] = length > 0 ? frame.base[half] / length : 1;
    return length;
}

void set_inwards(TriangleFrame& frame, const Vector& across) {
    frame.inwards[frame.base_edge] = across;
    frame.inwards[next_of_three(frame.base_edge)] =
        -frame.normal_along[right] * frame.along - frame.normal_across[right] * across;
    frame.inwards[previous_of_three(frame.base_edge)] =
        frame.normal_along[left] * frame.along - frame.normal_across[left] * across;
}

void set_equilateral_normals(TriangleFrame& frame) {
    frame.normal_along = {std::sqrt(0.75), std::sqrt(0.75)};
    frame.normal_across = {0.5, 0.5};
}

}  // namespace

// frames_of_faces() in kernels/face_frames.h does the same, operation by operation.
TriangleFrame triangle_frame(const std::array<Vec3, 3>& corners, const LatticeView& lattice) {
    const InUnits in_units(lattice.unit);
    const TriangleEdges triangle(corners, in_units);
    const std::uint32_t base = triangle.base;
    const std::uint32_t to_apex = next_of_three(base);
    const std::uint32_t from_apex = previous_of_three(base);

    TriangleFrame frame;
    frame.base_edge = base;
    double length = std::sqrt(triangle.squared[base]);
    if (!(length > vanishing)) length = 0;
    frame.along = length > 0 ? Vector(triangle.vectors[base] / length) : Vector::UnitX();

    frame.base[right] = std::max(0.0, -dot(triangle.vectors[to_apex], frame.along));
    frame.base[left] = std::max(0.0, -dot(triangle.vectors[from_apex], frame.along));
    const Vector apex = triangle.apex();
    Vector altitude = apex - dot(apex, frame.along) * frame.along;
    altitude -= dot(altitude, frame.along) * frame.along;
    double height = std::sqrt(dot(altitude, altitude));
    frame.is_box = !(height > sliver * length);
    Vector across = Vector::Zero();
    if (height > 0) {
        across = altitude / height;
        across = (across - dot(across, frame.along) * frame.along).normalized();
    }
    if (!(height > 0) || !(across.squaredNorm() > 0.5) || !(std::abs(across.dot(frame.along)) < 1e-12)) {
        height = 0;
        across = any_perpendicular(frame.along);
    }
    frame.normal = frame.along.cross(across);

    frame.altitude = set_slanted_edge(frame, right, height) * frame.normal_along[right];
    set_slanted_edge(frame, left, height);
    frame.turn =
        !frame.is_box && frame.altitude > 0 ? frame_roundings * frame.base_length() / frame.altitude : infinite;
    if (!(length > 0)) set_equilateral_normals(frame);
    set_inwards(frame, across);

    frame.foot = foot_of(frame, corners[triangle.near_end()], triangle.nearer_half(), lattice, in_units);
    return frame;
}

TriangleFrame point_frame(const Vector& position, const Vector& normal) {
    TriangleFrame frame;
    frame.normal = normal;
    frame.along = any_perpendicular(normal);
    frame.foot = position;
    frame.base = {0, 0};
    frame.altitude = 0;
    frame.turn = 0;
    set_equilateral_normals(frame);
    frame.base_edge = 0;
    frame.is_box = false;
    set_inwards(frame, normal.cross(frame.along));
    return frame;
}

}  // namespace clsdf::polyhedra
