#pragma once

#include "outputs.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::engine {

/// The faces as given of a mesh whose triangles are pieces of them, or have other numbers.
struct GivenFaces {
    std::vector<FacePiece> pieces;       ///< by triangle; empty if the triangles are whole faces
    std::vector<std::uint32_t> numbers;  ///< by triangle: that of its face

    std::size_t host_bytes() const { return pieces.size() * sizeof(pieces[0]) + numbers.size() * sizeof(numbers[0]); }

    /// The same of some of the triangles.
    GivenFaces of(std::span<const std::uint32_t> triangles) const {
        GivenFaces part;
        part.pieces.reserve(triangles.size());
        part.numbers.reserve(triangles.size());
        for (const std::uint32_t triangle : triangles) {
            part.pieces.push_back(pieces[triangle]);
            part.numbers.push_back(numbers[triangle]);
        }
        return part;
    }
};

}  // namespace clsdf::engine
