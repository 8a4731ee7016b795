#pragma once

#include <clsdf/mesh.hpp>

#include <array>

/// Signs of determinants of coordinates, exact for the doubles as given: -1, 0 or 1.
namespace clsdf {

/// 1: d is on the side of a, b, c from which they run counterclockwise; 0: the four lie in a plane.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// The same in a plane. 1: a, b, c run counterclockwise; 0: they lie on a line.
int orientation(const std::array<double, 2>& a, const std::array<double, 2>& b, const std::array<double, 2>& c);

bool are_collinear(const Vec3& a, const Vec3& b, const Vec3& c);

/// Which of two faces' planes a line from `from` along `to` - `origin`, both exact, meets first: -1 the first one's, 1
/// the second one's, 0: at the same place. It is parallel to neither.
int compare_places(const std::array<Vec3, 3>& first, const std::array<Vec3, 3>& second, const Vec3& from,
                   const Vec3& to, const Vec3& origin);

}  // namespace clsdf
