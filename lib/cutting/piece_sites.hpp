#pragma once

#include <clsdf/mesh.hpp>

#include "cutting/cancellation.hpp"
#include "cutting/patches.hpp"
#include "finish/given_faces.hpp"

#include <span>

namespace clsdf::cutting {

/// What outputs tell of pieces that form a surface. pieces: ascending by face; corners in any order.
///
/// A vertex or an edge between pieces is told as a site of the lowest face that has it: as the vertex or edge of the
/// face on which it lies; as the face if all its pieces are of this one; else as a cut. A vertex on an edge of the face
/// as given is told as that edge if all its pieces are of faces that have the edge, else as a cut.
engine::GivenFaces given_faces(const CutPoints& points, std::span<const View> views, std::span<const Piece> pieces,
                               const Cancellation& cancellation);

}  // namespace clsdf::cutting
