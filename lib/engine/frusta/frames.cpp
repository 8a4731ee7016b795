#include "frusta/frames.hpp"

#include "frusta/one_lane.hpp"
#include "topology/topology.hpp"

#include <cmath>
#include <limits>
#include <new>

namespace clsdf::engine {

namespace {

constexpr double sliver = 1e-8;
constexpr double vanishing = 1e-100;  // units; squares of shorter lengths leave the range of double
constexpr double infinite = std::numeric_limits<double>::infinity();

/// Sets the axes of a face without altitude, and the normals of its slanted edges.
void set_flat(one_lane::FaceFrames& face, const Vector& along, const Vector& across, double normal_along,
              double normal_across) {
    face.along = vectors_of(along);
    face.across = vectors_of(across);
    face.normal = vectors_of(along.cross(across));
    face.altitude = 0;
    face.along_right = face.along_left = normal_along;
    face.across_right = face.across_left = normal_across;
}

/// All lengths become zero; the edges have the directions of an equilateral triangle's.
void set_point(one_lane::FaceFrames& face, const Vector& along, const Vector& across) {
    set_flat(face, along, across, std::sqrt(0.75), 0.5);
    face.right = face.left = 0;
}

/// Sets what follows from the face.
void set_directions(TriangleFrame& frame) {
    frame.normal = to_vector(frame.face.normal);
    frame.base_edge = frame.face.base_edges.is_first ? 0 : frame.face.base_edges.is_second ? 1 : 2;
    frame.inwards[frame.base_edge] = to_vector(frame.face.across);
    frame.inwards[next_of_three(frame.base_edge)] = to_vector(inward_from_right(&frame.face));
    frame.inwards[previous_of_three(frame.base_edge)] = to_vector(inward_from_left(&frame.face));
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
    TriangleFrame frame;
    // Constructed in its place rather than copied there.
    new (&frame.face) one_lane::FaceFrames(frames_of_faces(face_lattice(lattice), vectors_of(to_vector(a)),
                                                           vectors_of(to_vector(b)), vectors_of(to_vector(c))));
    one_lane::FaceFrames& face = frame.face;
    frame.is_box = !(face.length > vanishing) || !(face.height > sliver * face.length);
    if (!(face.length > vanishing)) {
        set_point(face, Vector::UnitX(), any_perpendicular(Vector::UnitX()));
    } else {
        const Vector along = to_vector(face.along), across = to_vector(face.across);
        if (!(face.height > 0) || !(across.squaredNorm() > 0.5) || !(std::abs(across.dot(along)) < 1e-12))
            set_flat(face, along, any_perpendicular(along), 0, 1);
    }
    frame.turn = !frame.is_box && face.altitude > 0 ? turn_of(&face) : infinite;
    set_directions(frame);
    return frame;
}

TriangleFrame point_frame(const Vector& position, const Vector& normal) {
    TriangleFrame frame;
    frame.face = {};
    frame.face.base_edges.is_first = 1;
    frame.face.foot = vectors_of(position);
    const Vector along = any_perpendicular(normal);
    set_point(frame.face, along, normal.cross(along));
    frame.face.normal = vectors_of(normal);
    frame.turn = 0;
    frame.is_box = false;
    set_directions(frame);
    return frame;
}

}  // namespace clsdf::engine
