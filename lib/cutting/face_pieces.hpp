#pragma once

#include <clsdf/mesh.hpp>

#include "cutting/meetings.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace clsdf::cutting {

/// Segments in one face: where they cross and touch each other and the face's edges.
class FaceCuts {
public:
    FaceCuts(const CutPoints& points, std::uint32_t face, const View& view, std::span<const FaceSegment> segments);

    /// Points at which two segments cross that are not ends. To be numbered; then numbers are given to pieces().
    std::span<const CutPoints::Found> crossings() const { return crossings_; }

    /// Triangles of points that cover the face, oriented as it is. No segment runs through one, no point lies within
    /// one or on its edges.
    std::vector<Triangle> pieces(const CutPoints& points, std::span<const std::uint32_t> crossings) const;

private:
    struct Crossing {
        std::uint32_t first, second;  ///< segments
    };
    void look_at(const CutPoints& points, std::uint32_t first, std::uint32_t second, CutPoints::Cache& cache);

    std::uint32_t face_;
    View view_;
    std::vector<FaceSegment> segments_;             // the face's edges first
    std::vector<std::vector<std::uint32_t>> ends_;  // of others, that lie within each segment
    std::vector<CutPoints::Found> crossings_;
    std::vector<Crossing> crossed_;  // by each of them
};

}  // namespace clsdf::cutting
