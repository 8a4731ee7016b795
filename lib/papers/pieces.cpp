#include "papers/pieces.hpp"

#include "papers/convex_polyhedron.hpp"

#include <algorithm>
#include <cmath>

namespace clsdf::papers {

namespace {

/// The grid and a sample of room on each side, in samples from `origin`.
Box box_of(const Layout& grid, const std::array<std::int32_t, 3>& origin) {
    Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double first = static_cast<double>(grid.first[axis]) - origin[axis];
        box.lower[axis] = first - 1;
        box.upper[axis] = first + grid.size[axis];
    }
    return box;
}

double largest_coordinate(const Box& box) {
    double largest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        largest = std::max({largest, std::abs(box.lower[axis]), std::abs(box.upper[axis])});
    return largest;
}

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

void ConvexPieces::append(const ConvexPieces& other) {
    const auto shift = static_cast<std::uint32_t>(planes.size());
    for (Piece piece : other.pieces) {
        piece.plane_begin += shift;
        pieces.push_back(piece);
    }
    planes.insert(planes.end(), other.planes.begin(), other.planes.end());
    costs.insert(costs.end(), other.costs.begin(), other.costs.end());
}

void PieceCollector::add(const std::array<std::int32_t, 3>& origin, std::uint32_t polyhedron,
                         std::span<const PiecePlane> planes, std::uint32_t site) {
    const Box box = box_of(grid_, origin);
    // Cutting rounds with the size of the box: beyond a million samples more than the slack allows for.
    constexpr double rounding = 1e-12;
    const double slack = 2 * CLSDF_PIECE_SLACK + rounding * largest_coordinate(box);
    std::array<HalfSpace, CLSDF_MOST_PLANES> half_spaces;
    for (std::size_t i = 0; i < planes.size(); ++i)
        half_spaces[i] = {{planes[i].normal[0], planes[i].normal[1], planes[i].normal[2]}, planes[i].offset + slack};
    const ConvexPolyhedron solid = clip(box, std::span(half_spaces).first(planes.size()));
    if (solid.is_empty()) return;

    engine::Vector low = solid.vertices.front();
    engine::Vector high = low;
    for (const engine::Vector& vertex : solid.vertices) {
        low = low.cwiseMin(vertex);
        high = high.cwiseMax(vertex);
    }
    const auto first_slice = static_cast<std::int64_t>(std::ceil(low.z())) + origin[2];
    const auto last_slice = static_cast<std::int64_t>(std::floor(high.z())) + origin[2];
    const auto begin = std::max<std::int64_t>(first_slice, grid_.first[2]);
    const auto end = std::min<std::int64_t>(last_slice + 1, std::int64_t{grid_.first[2]} + grid_.size[2]);
    if (begin >= end) return;

    Piece piece{};
    piece.plane_begin = static_cast<std::uint32_t>(kept_.planes.size());
    piece.plane_count = static_cast<std::uint32_t>(planes.size());
    piece.polyhedron = polyhedron;
    piece.site = site;
    piece.slice_begin = static_cast<std::int32_t>(begin);
    piece.slice_end = static_cast<std::int32_t>(end);
    std::copy(origin.begin(), origin.end(), piece.origin);
    kept_.pieces.push_back(piece);
    kept_.planes.insert(kept_.planes.end(), planes.begin(), planes.end());
    const double height = std::max(high.z() - low.z(), 1.0);
    kept_.costs.push_back({static_cast<float>(high.y() - low.y() + 1), static_cast<float>(solid.volume() / height)});
}

ConvexPieces leaned_pieces(std::span<const Polyhedron> polyhedra, double half_width, double slack, const Layout& grid) {
    return collect_pieces(polyhedra.size(), grid, [&](std::size_t i, PieceCollector& collector) {
        add_pieces(polyhedra[i], static_cast<std::uint32_t>(i), half_width, slack, collector);
    });
}

}  // namespace clsdf::papers
