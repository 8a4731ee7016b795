#pragma once

#include "piece.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// Bounding polyhedra of any kind as convex pieces, for the scan by slices.
namespace clsdf::slices {

/// What a piece costs in each of its slices, on average.
struct PieceCost {
    float rows = 0;
    float samples = 0;
};

struct ConvexPieces {
    std::vector<Piece> pieces;
    std::vector<PiecePlane> planes;
    std::vector<PieceCost> costs;  ///< of each piece

    void append(const ConvexPieces& other);
};

/// Keeps the pieces that cut a slice of a grid within the grid, each with its slices.
class PieceCollector {
public:
    PieceCollector(const Layout& grid, ConvexPieces& kept) : grid_(grid), kept_(kept) {}

    /// A piece of `planes` (unit normals in the metric frame, CLSDF_MOST_PLANES at most; the slack not yet added) for
    /// the polyhedron's record, and the site of it that gives the distance.
    void add(const std::array<std::int32_t, 3>& origin, std::uint32_t polyhedron, std::span<const PiecePlane> planes,
             std::uint32_t site = CLSDF_SITE_NEAREST);

private:
    const Layout& grid_;
    ConvexPieces& kept_;
};

/// Calls make_pieces(source, collector) for each source, on all cores; the pieces are in the order of the sources.
template <typename MakePieces>
ConvexPieces collect_pieces(std::size_t source_count, const Layout& grid, const MakePieces& make_pieces) {
    constexpr std::size_t batch = 1024;
    std::vector<ConvexPieces> batches((source_count + batch - 1) / batch);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, batches.size(), 1), [&](const auto& range) {
        for (std::size_t b = range.begin(); b != range.end(); ++b) {
            PieceCollector collector(grid, batches[b]);
            const std::size_t end = std::min(source_count, (b + 1) * batch);
            for (std::size_t source = b * batch; source < end; ++source) make_pieces(source, collector);
        }
    });
    ConvexPieces all;
    for (ConvexPieces& part : batches) {
        all.append(part);
        part = {};
    }
    return all;
}

}  // namespace clsdf::slices
