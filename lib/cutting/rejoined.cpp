#include "cutting/rejoined.hpp"

#include "core/parallel.hpp"
#include "cutting/triangulation.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <unordered_map>

namespace clsdf::cutting {

namespace {

constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

using Edge = std::array<std::uint32_t, 2>;  // points

struct EdgeHash {
    std::size_t operator()(const Edge& edge) const { return edge[0] * 0x9E3779B97F4A7C15ULL ^ edge[1]; }
};

/// A face, and whether its pieces keep their direction.
struct Side {
    std::uint32_t face;
    Fate fate;
    auto operator<=>(const Side&) const = default;
};

/// A piece that is kept, as its face runs.
struct KeptPiece {
    Side side;
    Triangle corners;
};

/// A point, and the edges there that divide pieces.
struct Place {
    std::array<std::uint32_t, 2> others{none, none};  ///< the first two edges' other ends
    std::uint32_t edges = 0;
    std::uint32_t face = none;     ///< of which a piece is here,
    bool has_other_faces = false;  ///< and whether one of another face is
    bool is_removed = false;       ///< its two edges are one
};

/// The edges of kept pieces but for those between two pieces of one face, wherever a face is cut.
class Outlines {
public:
    Outlines(const CutPoints& points, std::span<const View> views, std::span<const KeptPiece> pieces)
        : points_(points), pieces_(pieces), places_(points.size()), is_changed_(points.triangles().size()) {
        find_edges();
        find_removed(views);
    }

    /// Whether an edge or a point of the face is gone.
    bool is_changed(std::uint32_t face) const { return is_changed_[face]; }

    /// The edges around pieces of one face, and along others' edges within it, as the pieces run.
    std::vector<Edge> edges_of(std::span<const KeptPiece> pieces) const {
        std::vector<Edge> edges;
        for (const KeptPiece& piece : pieces)
            for (std::size_t k = 0; k < 3; ++k) {
                std::uint32_t from = piece.corners[k], to = piece.corners[(k + 1) % 3];
                if (places_[from].is_removed || !is_edge(from, to)) continue;
                const std::uint32_t first = from;
                while (places_[to].is_removed) {
                    const auto& [one, other] = places_[to].others;
                    const std::uint32_t next = one == from ? other : one;
                    from = to;
                    to = next;
                }
                edges.push_back({first, to});
            }
        return edges;
    }
    /// Whether a point of a face stays although no edge may end there.
    bool is_needed(std::uint32_t point) const { return places_[point].has_other_faces && !places_[point].is_removed; }

private:
    static Edge sorted(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }
    bool is_edge(std::uint32_t a, std::uint32_t b) const { return sides_.contains(sorted(a, b)); }

    void find_edges() {
        std::vector<bool> is_cut(points_.size());
        for (const KeptPiece& piece : pieces_)
            if (piece.corners != points_.triangles()[piece.side.face])
                for (const std::uint32_t v : piece.corners) is_cut[v] = true;
        for (const KeptPiece& piece : pieces_)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t from = piece.corners[k], to = piece.corners[(k + 1) % 3];
                if (is_cut[from] && is_cut[to]) sides_[sorted(from, to)].push_back(piece.side);
                Place& place = places_[from];
                if (place.face == none) place.face = piece.side.face;
                place.has_other_faces = place.has_other_faces || place.face != piece.side.face;
            }
        for (auto entry = sides_.begin(); entry != sides_.end();) {
            auto& [edge, sides] = *entry;
            if (sides.size() == 2 && sides[0] == sides[1]) {
                is_changed_[sides[0].face] = true;
                entry = sides_.erase(entry);
                continue;
            }
            std::ranges::sort(sides);
            for (const std::size_t end : {0U, 1U}) {
                Place& place = places_[edge[end]];
                if (place.edges < 2) place.others[place.edges] = edge[1 - end];
                ++place.edges;
            }
            ++entry;
        }
    }

    void find_removed(std::span<const View> views) {
        CutPoints::Cache cache;
        for (std::uint32_t point = 0; point < places_.size(); ++point) {
            Place& place = places_[point];
            if (place.edges != 2) continue;
            const auto& [one, other] = place.others;
            const std::vector<Side>& sides = sides_.at(sorted(point, one));
            if (sides != sides_.at(sorted(point, other))) continue;
            const auto is_corner = [&](const Side& side) {
                const Triangle& corners = points_.triangles()[side.face];
                return std::ranges::find(corners, point) != corners.end();
            };
            if (std::ranges::any_of(sides, is_corner) ||
                points_.orientation(one, point, other, views[sides[0].face].axis, cache) != 0)
                continue;
            place.is_removed = true;
            for (const Side& side : sides) is_changed_[side.face] = true;
        }
    }

    const CutPoints& points_;
    std::span<const KeptPiece> pieces_;
    std::unordered_map<Edge, std::vector<Side>, EdgeHash> sides_;  // of the pieces at each edge
    std::vector<Place> places_;
    std::vector<bool> is_changed_;
};

/// Those of the triangles that lie on the left of edges around them.
std::vector<Triangle> within(std::vector<Triangle> triangles, std::span<const Edge> edges) {
    std::unordered_map<Edge, std::uint32_t, EdgeHash> triangle_at;  // by its directed edges
    for (std::uint32_t i = 0; i < triangles.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) triangle_at[{triangles[i][k], triangles[i][(k + 1) % 3]}] = i;
    std::vector<bool> is_within(triangles.size());
    std::vector<std::uint32_t> next;
    const auto add = [&](const Edge& edge) {
        const auto found = triangle_at.find(edge);
        if (found == triangle_at.end() || is_within[found->second]) return;
        is_within[found->second] = true;
        next.push_back(found->second);
    };
    std::unordered_map<Edge, bool, EdgeHash> is_border;
    for (const Edge& edge : edges) is_border[edge] = true;
    for (const Edge& edge : edges) add(edge);
    while (!next.empty()) {
        const Triangle triangle = triangles[next.back()];
        next.pop_back();
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t from = triangle[k], to = triangle[(k + 1) % 3];
            if (!is_border.contains({from, to})) add({to, from});
        }
    }
    std::size_t i = 0;
    std::erase_if(triangles, [&](const Triangle&) { return !is_within[i++]; });
    return triangles;
}

}  // namespace

std::vector<Piece> rejoined(const CutPoints& points, std::span<const View> views, std::span<const Piece> pieces,
                            std::span<const Fate> fates, const Cancellation& cancellation) {
    std::vector<KeptPiece> kept;
    for (std::size_t i = 0; i < pieces.size(); ++i)
        if (fates[i] != Fate::dropped) kept.push_back({{pieces[i].face, fates[i]}, pieces[i].corners});
    std::ranges::stable_sort(kept, {}, &KeptPiece::side);
    const Outlines outlines(points, views, kept);
    std::vector<std::size_t> begins;  // of the pieces of each side
    for (std::size_t i = 0; i < kept.size(); ++i)
        if (i == 0 || kept[i].side != kept[i - 1].side) begins.push_back(i);
    std::vector<std::vector<Triangle>> by_side(begins.size());
    begins.push_back(kept.size());
    for_each_index(
        by_side.size(),
        [&](std::size_t i) {
            const auto own = std::span<const KeptPiece>(kept).subspan(begins[i], begins[i + 1] - begins[i]);
            const std::uint32_t face = own.front().side.face;
            if (!outlines.is_changed(face)) {
                for (const KeptPiece& piece : own) by_side[i].push_back(piece.corners);
                return;
            }
            cancellation.check();
            const std::vector<Edge> edges = outlines.edges_of(own);
            std::vector<std::uint32_t> all;
            for (const Edge& edge : edges) all.insert(all.end(), edge.begin(), edge.end());
            for (const KeptPiece& piece : own)
                for (const std::uint32_t point : piece.corners)
                    if (outlines.is_needed(point)) all.push_back(point);
            std::ranges::sort(all);
            all.erase(std::ranges::unique(all).begin(), all.end());
            FaceTriangulation triangulation(points, points.triangles()[face], views[face]);
            for (const std::uint32_t point : all) triangulation.add_point(point);
            for (const auto& [from, to] : edges) triangulation.add_segment(from, to);
            by_side[i] = within(triangulation.triangles(), edges);
        },
        4);
    std::vector<Piece> result;
    result.reserve(kept.size());
    for (std::size_t i = 0; i < by_side.size(); ++i)
        for (Triangle corners : by_side[i]) {
            const auto [face, fate] = kept[begins[i]].side;
            if (fate == Fate::flipped) std::swap(corners[1], corners[2]);
            result.push_back({corners, face});
        }
    return result;
}

}  // namespace clsdf::cutting
