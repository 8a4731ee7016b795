#include "slices/leaned_pieces.hpp"

#include "slices/record_frame.hpp"

#include <cmath>

namespace clsdf::slices {

namespace {

/// The bounds of the outward distance from an edge on the side where `height` > 0.
void add_lateral_planes(const Affine& outward, const Affine& height, double slope, double cap, double slack,
                        PieceBounds& planes) {
    const double at_face = slack * (1 + slope);
    const double widest = cap + slack;
    const bool leans = at_face < widest;
    if (leans) planes.add(outward + -slope * height - at_face, std::sqrt(1 + slope * slope));
    if (!leans || slope * widest + at_face > widest) planes.add(outward - widest);
}

void add_pieces(const Polyhedron& polyhedron, std::uint32_t index, double cap, double slack,
                PieceCollector& collector) {
    const RecordFrame record(polyhedron);
    const auto are_all = [&](auto&& condition) {
        return std::all_of(polyhedron.slope_above, polyhedron.slope_above + 3, condition) &&
               std::all_of(polyhedron.slope_below, polyhedron.slope_below + 3, condition);
    };
    // A box, or a prism: convex as a whole.
    const bool is_open = are_all([&](float slope) { return slack * static_cast<double>(slope) >= cap; });
    const bool is_prism = are_all([](float slope) { return slope == 0; });
    const double widest = cap + slack;
    for (const double side : {1.0, -1.0}) {
        const bool is_whole = is_open || is_prism;
        if (is_whole && side < 0) continue;
        const float* own = side > 0 ? polyhedron.slope_above : polyhedron.slope_below;
        const Affine height = side * record.height();
        PieceBounds planes;
        for (std::size_t edge = 0; edge < 3; ++edge)
            add_lateral_planes(record.outward(edge), height, static_cast<double>(own[edge]), cap, slack, planes);
        planes.add(height - widest);
        planes.add(-1 * height - (is_whole ? widest : slack));
        if (!record.is_compact()) {
            planes.add(record.along() - (record.base(CLSDF_HALF_RIGHT) + widest));
            planes.add(-1 * record.along() - (record.base(CLSDF_HALF_LEFT) + widest));
        }
        collector.add(record.origin(), index, planes.span());
    }
}

}  // namespace

ConvexPieces leaned_pieces(std::span<const Polyhedron> polyhedra, double half_width, double slack, const Layout& grid) {
    return collect_pieces(polyhedra.size(), grid, [&](std::size_t i, PieceCollector& collector) {
        add_pieces(polyhedra[i], static_cast<std::uint32_t>(i), half_width, slack, collector);
    });
}

}  // namespace clsdf::slices
