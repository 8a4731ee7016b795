#include "polyhedra/frames.hpp"

#include "polyhedra/one_lane.hpp"
#include "polyhedra/topology.hpp"

#include <cmath>
#include <limits>

namespace clsdf::polyhedra {

namespace {

constexpr double sliver = 1e-8;
constexpr double vanishing = 1e-100;  // units; squares of shorter lengths leave the range of double
constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr std::size_t right = CLSDF_HALF_RIGHT;
constexpr std::size_t left = CLSDF_HALF_LEFT;

void set_inwards(TriangleFrame& frame, const Vector& across) {
    frame.inwards[frame.base_edge] = across;
    frame.inwards[next_of_three(frame.base_edge)] =
        -frame.normal_along[right] * frame.along - frame.normal_across[right] * across;
    frame.inwards[previous_of_three(frame.base_edge)] =
        frame.normal_along[left] * frame.along - frame.normal_across[left] * across;
}

/// All lengths become zero; the edges have the directions of an equilateral triangle's.
void set_point(TriangleFrame& frame, const Vector& along, const Vector& across) {
    frame.along = along;
    frame.normal = along.cross(across);
    frame.base = {0, 0};
    frame.altitude = 0;
    frame.normal_along = {std::sqrt(0.75), std::sqrt(0.75)};
    frame.normal_across = {0.5, 0.5};
    set_inwards(frame, across);
}

/// The frame of a triangle for a unit whose reciprocal may be infinite.
TriangleFrame frame_of_tiny(const std::array<Vec3, 3>& corners, const LatticeView& lattice) {
    const auto enlarged = [](const Vec3& v) { return Vec3{v[0] * 0x1p200, v[1] * 0x1p200, v[2] * 0x1p200}; };
    const auto& [a, b, c] = corners;
    return triangle_frame({enlarged(a), enlarged(b), enlarged(c)},
                          {enlarged(lattice.origin), lattice.unit * 0x1p200, lattice.spacing_in_units});
}

}  // namespace

TriangleFrame triangle_frame(const std::array<Vec3, 3>& corners, const LatticeView& lattice) {
    if (lattice.unit < std::numeric_limits<double>::min()) return frame_of_tiny(corners, lattice);
    const auto& [a, b, c] = corners;
    const one_lane::FaceFrames f = one_lane::frames_of_faces(face_lattice(lattice), vectors_of(to_vector(a)),
                                                             vectors_of(to_vector(b)), vectors_of(to_vector(c)));
    TriangleFrame frame;
    frame.base_edge = f.base_edges.is_first ? 0 : f.base_edges.is_second ? 1 : 2;
    frame.foot = to_vector(f.foot);
    if (!(f.length > vanishing)) {
        set_point(frame, Vector::UnitX(), any_perpendicular(Vector::UnitX()));
        frame.turn = infinite;
        frame.is_box = true;
        return frame;
    }
    Vector across = to_vector(f.across);
    frame.along = to_vector(f.along);
    frame.normal = to_vector(f.normal);
    frame.base = {f.right, f.left};
    frame.altitude = f.altitude;
    frame.normal_along = {f.along_right, f.along_left};
    frame.normal_across = {f.across_right, f.across_left};
    frame.is_box = !(f.height > sliver * f.length);
    if (!(f.height > 0) || !(across.squaredNorm() > 0.5) || !(std::abs(across.dot(frame.along)) < 1e-12)) {
        across = any_perpendicular(frame.along);
        frame.normal = frame.along.cross(across);
        frame.altitude = 0;
        frame.normal_along = {0, 0};
        frame.normal_across = {1, 1};
    }
    frame.turn =
        !frame.is_box && frame.altitude > 0 ? frame_roundings * frame.base_length() / frame.altitude : infinite;
    set_inwards(frame, across);
    return frame;
}

TriangleFrame point_frame(const Vector& position, const Vector& normal) {
    TriangleFrame frame;
    frame.base_edge = 0;
    frame.foot = position;
    const Vector along = any_perpendicular(normal);
    set_point(frame, along, normal.cross(along));
    frame.normal = normal;
    frame.turn = 0;
    frame.is_box = false;
    return frame;
}

}  // namespace clsdf::polyhedra
