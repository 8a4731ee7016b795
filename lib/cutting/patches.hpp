#pragma once

#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include "cutting/cancellation.hpp"
#include "cutting/meetings.hpp"
#include "surface/sign_surface.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::cutting {

/// A part of a face: a triangle of points.
struct Piece {
    Triangle corners;
    std::uint32_t face;
};

/// What becomes of a piece.
enum class Fate : std::int8_t {
    flipped = -1,  ///< kept, with its normal reversed
    dropped = 0,
    kept = 1,
};

/// Keeps the pieces that have nothing of the inside in front and something behind, or the other way round; of pieces
/// that lie in each other, those of the patch with the lowest face. One exact winding number decides about a patch:
/// pieces that are joined over edges of exactly two. rule: nonzero or parity.
std::vector<Fate> fates_of(const CutPoints& points, std::span<const View> views, const FaceBoxes& boxes,
                           std::span<const Piece> pieces, const PlanePatches& planes, const SignSurface& surface,
                           SignRule rule, const Cancellation& cancellation);

}  // namespace clsdf::cutting
