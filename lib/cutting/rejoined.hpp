#pragma once

#include "cutting/patches.hpp"

#include <span>
#include <vector>

namespace clsdf::cutting {

/// The pieces that are kept, their normals outwards, face after face, and fewer of them. Edges between two pieces of
/// one face are gone if no third piece has them, and so are points within a straight edge whose faces are the same
/// before and after; what remains of such a face is triangulated anew. pieces: face after face.
std::vector<Piece> rejoined(const CutPoints& points, std::span<const View> views, std::span<const Piece> pieces,
                            std::span<const Fate> fates, const Cancellation& cancellation);

}  // namespace clsdf::cutting
