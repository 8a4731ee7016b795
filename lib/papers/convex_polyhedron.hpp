#pragma once

#include "frusta/frames.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// Bounding polyhedra as solids: what half-spaces leave of a box.
namespace clsdf::papers {

using engine::Vector;

/// The points y with normal . y <= offset. The normal need not be a unit vector; an infinite offset leaves everything.
struct HalfSpace {
    Vector normal;
    double offset = 0;
};

/// Closed, of the topology of a sphere, with volume; or empty.
struct ConvexPolyhedron {
    static constexpr std::size_t start_box = SIZE_MAX;

    struct Face {
        std::size_t half_space;  ///< index of the one whose plane it lies in, or start_box
        std::uint32_t first;     ///< in `corners`
        std::uint32_t size;      ///< number of vertices, 3 or more
    };

    std::vector<Vector> vertices;
    std::vector<Face> faces;
    std::vector<std::uint32_t> corners;  ///< of all faces: indices of vertices, counter-clockwise from outside

    bool is_empty() const { return faces.empty(); }
    std::span<const std::uint32_t> polygon(const Face& face) const {
        return std::span(corners).subspan(face.first, face.size);
    }
    double volume() const;
};

/// The part of `start` (finite) that lies in all half-spaces, in time proportional to their number times the size of
/// what they leave. Vertices are off the planes by no more than 2e-13 of the largest coordinate of `start`: within
/// that, a plane through a vertex, along an edge or in a face makes nothing new, what is thinner is empty, and the
/// order of the half-spaces changes nothing but which of several with one plane is named by its face.
ConvexPolyhedron clip(const Box& start, std::span<const HalfSpace> half_spaces);

}  // namespace clsdf::papers
