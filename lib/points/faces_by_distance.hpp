#pragma once

#include "points/few_points.hpp"

#include <cstdint>
#include <vector>

namespace clsdf::points {

/// The faces of a mesh in the order of their distances from a point, without those that have the point in front, beyond
/// rounding. At equal distances the lowest number, in the caller's order, comes first.
class FacesByDistance {
public:
    struct Face {
        std::uint32_t face;  ///< as the tree numbers it, or CLSDF_NO_FACE: there is none any more
        double squared;      ///< of the distance, in units
    };

    /// inputs: of bring_to_host(). most: a squared distance in units, beyond which faces are left out. rounding: of the
    /// point, in units. For callers that have made a DefaultFloatingPoint.
    FacesByDistance(const PointInputs& inputs, const Vec3& in_units, double most, double rounding);

    Face next();

private:
    /// A face, or a node of the tree with a lower bound.
    struct Entry {
        double squared;
        bool is_face;
        std::uint32_t level, number;  ///< of the node; 0 and the face
        std::uint32_t triangle;       ///< of the face, in the caller's order
    };
    void open(std::uint32_t level, std::uint32_t number);
    void add_faces(std::uint32_t leaf);
    void add(const Entry& entry);

    const PointInputs& inputs_;
    Vec3 point_;
    double most_, most_in_front_;
    std::vector<Entry> heap_;
};

}  // namespace clsdf::points
