#pragma once

#include <clsdf/clsdf.hpp>

#include <cstdint>
#include <span>

/// cuBQL's search for the nearest triangle of a point, on the host, so that its work can be counted.
namespace clsdf::test {

/// The work of all points. A box has 32 bytes with its node, a face 40 with its number.
struct CubqlWork {
    std::uint64_t boxes = 0, faces = 0;
};

inline constexpr double bytes_of_cubql_box = 32, bytes_of_cubql_face = 40;

/// closestPointOnAnyTriangle in the tree that cuBQL makes by default: leaves of one triangle, divided at the middle.
CubqlWork search_by_cubql(const Mesh& mesh, std::span<const Vec3> points);

}  // namespace clsdf::test
