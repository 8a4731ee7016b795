#pragma once

#include <clsdf/picture.hpp>

#include <array>
#include <span>

namespace clsdf::picture {

/// The directions to the picture's right, to its upper side and to the viewer: a right-handed frame of unit vectors.
struct ViewFrame {
    Vec3 right;
    Vec3 up;
    Vec3 back;
};

/// Throws Error(invalid_argument) if an angle is out of range.
ViewFrame frame_of(const View& view);

/// From pixels to rays. Points are in the mesh's units, from any origin.
class Camera {
public:
    /// A camera that sees all points, with `around` and a margin on each side, in a picture of `width` x `height`
    /// pixels. If the height is 0, the width is the length of the longer side, and the other one is chosen. There must
    /// be at least one point.
    Camera(const View& view, std::span<const Vec3> points, double around, int width, int height);

    int width() const { return width_; }
    int height() const { return height_; }
    const ViewFrame& frame() const { return frame_; }

    struct Ray {
        Vec3 origin;
        Vec3 direction;  ///< not of unit length; the same function of x and y everywhere: linear
    };
    /// Through (x, y) pixels right of and below the picture's upper left corner.
    Ray ray(double x, double y) const;

    /// A pixel's side, seen at a point.
    double pixel_at(const Vec3& point) const;

private:
    ViewFrame frame_;
    bool is_parallel_;
    Vec3 eye_{};  // of a parallel projection: a point before everything
    int width_ = 0;
    int height_ = 0;
    double pixel_ = 0;                // in the plane of projection, which is at distance 1 from the eye
    std::array<double, 2> centre_{};  // of the picture in it, right and up
};

/// The axis of a solid that probably points upwards: y, as in most scanned and modelled meshes, or z, as in most
/// machine parts and terrains. It is the axis along which the solid stands firmly: the centre of mass lies well within
/// the convex hull of the lowest twentieth, seen from above. The answer is z if the solid stands firmly on it and y is
/// not clearly firmer, else y.
///
/// The solid is given by the ends of its rows of samples along x, two points a row, at least one row; gaps within a row
/// count as solid. `spacing`: of the samples.
Axis upright_axis(std::span<const Vec3> row_ends, const Vec3& spacing);

}  // namespace clsdf::picture
