#include "cutting/piece_sites.hpp"

#include "core/parallel.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

namespace clsdf::cutting {

namespace {

constexpr std::uint8_t first_edge = 3, in_face = CLSDF_SITE_OF_FACE;

std::uint32_t next(std::uint32_t k) {
    return (k + 1) % 3;
}

/// The sites of its face on which the corners of a piece lie.
using Places = std::array<std::uint8_t, 3>;

std::uint8_t place_of(const CutPoints& points, std::uint32_t point, std::uint32_t face, const View& view,
                      CutPoints::Cache& cache) {
    const Triangle& corners = points.triangles()[face];
    for (std::uint32_t k = 0; k < 3; ++k)
        if (corners[k] == point) return static_cast<std::uint8_t>(k);
    for (std::uint32_t k = 0; k < 3; ++k)
        if (points.orientation(corners[k], corners[next(k)], point, view.axis, cache) == 0)
            return static_cast<std::uint8_t>(first_edge + k);
    return in_face;
}

/// Whether a corner at this place lies on edge k of the face.
bool is_on_edge(std::uint8_t place, std::uint32_t k) {
    return place == k || place == next(k) || place == first_edge + k;
}

std::uint8_t edge_of(std::uint8_t from, std::uint8_t to) {
    for (std::uint32_t k = 0; k < 3; ++k)
        if (is_on_edge(from, k) && is_on_edge(to, k)) return static_cast<std::uint8_t>(first_edge + k);
    return in_face;
}

/// The vertices of an edge of a face, the lower first.
std::pair<std::uint32_t, std::uint32_t> ends_of(const Triangle& corners, std::uint8_t edge) {
    return std::minmax(corners[edge - first_edge], corners[next(edge - first_edge)]);
}

/// A site between pieces, which are added in their order.
class SharedSite {
public:
    void add(const Triangle& corners, std::uint32_t face, std::uint8_t place) {
        if (is_new_) {
            is_new_ = false;
            corners_ = &corners;
            face_ = face;
            place_ = place;
        }
        is_of_one_ = is_of_one_ && face == face_;
        is_on_one_edge_ = is_on_one_edge_ && is_edge(place_) && is_edge(place) &&
                          ends_of(corners, place) == ends_of(*corners_, place_);
    }

    std::uint8_t told_vertex() const {
        if (place_ < first_edge || is_of_one_ || is_on_one_edge_) return place_;
        return CLSDF_SITE_OF_CUT;
    }
    std::uint8_t told_edge() const {
        if (is_edge(place_) || is_of_one_) return place_;
        return CLSDF_SITE_OF_CUT;
    }

private:
    static bool is_edge(std::uint8_t place) { return place >= first_edge && place < in_face; }

    bool is_new_ = true, is_of_one_ = true, is_on_one_edge_ = true;
    const Triangle* corners_ = nullptr;
    std::uint32_t face_ = 0;
    std::uint8_t place_ = 0;  // in the lowest face
};

void tell_vertices(const CutPoints& points, std::span<const Piece> pieces, std::span<const Places> places,
                   std::span<FacePiece> told) {
    std::vector<SharedSite> sites(points.size());
    for (std::size_t i = 0; i < pieces.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k)
            sites[pieces[i].corners[k]].add(points.triangles()[pieces[i].face], pieces[i].face, places[i][k]);
    for (std::size_t i = 0; i < pieces.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) told[i].site[k] = sites[pieces[i].corners[k]].told_vertex();
}

void tell_edges(const CutPoints& points, std::span<const Piece> pieces, std::span<const Places> places,
                std::span<FacePiece> told) {
    struct Edge {
        std::uint32_t from, to;  ///< from < to
        std::uint32_t piece, k;
    };
    std::vector<Edge> edges;
    edges.reserve(3 * pieces.size());
    for (std::uint32_t i = 0; i < pieces.size(); ++i)
        for (std::uint32_t k = 0; k < 3; ++k) {
            const auto [from, to] = std::minmax(pieces[i].corners[k], pieces[i].corners[next(k)]);
            edges.push_back({from, to, i, k});
        }
    std::ranges::sort(edges, {}, [](const Edge& edge) { return std::tuple(edge.from, edge.to, edge.piece, edge.k); });
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        SharedSite site;
        for (; end < edges.size() && edges[end].from == edges[begin].from && edges[end].to == edges[begin].to; ++end) {
            const auto [from, to, i, k] = edges[end];
            site.add(points.triangles()[pieces[i].face], pieces[i].face, edge_of(places[i][k], places[i][next(k)]));
        }
        for (std::size_t n = begin; n < end; ++n) told[edges[n].piece].site[first_edge + edges[n].k] = site.told_edge();
    }
}

}  // namespace

engine::GivenFaces given_faces(const CutPoints& points, std::span<const View> views, std::span<const Piece> pieces,
                               const Cancellation& cancellation) {
    engine::GivenFaces faces;
    faces.pieces.resize(pieces.size());
    faces.numbers.reserve(pieces.size());
    for (const Piece& piece : pieces) faces.numbers.push_back(piece.face);
    std::vector<Places> places(pieces.size());
    for_each_range(pieces.size(), [&](std::size_t begin, std::size_t end) {
        CutPoints::Cache cache;
        for (std::size_t i = begin; i < end; ++i) {
            cancellation.check();
            const auto& [corners, face] = pieces[i];
            FacePiece& told = faces.pieces[i];
            told.face = face;
            told.site[in_face] = in_face;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint8_t place = places[i][k] = place_of(points, corners[k], face, views[face], cache);
                std::array<double, 2> weights{};
                if (place >= first_edge)
                    weights = points.weights(corners[k], face, views[face].axis, cache);
                else if (place > 0)
                    weights[place - 1U] = 1;
                std::ranges::copy(weights, told.weights + 2 * k);
            }
        }
    });
    tell_vertices(points, pieces, places, faces.pieces);
    tell_edges(points, pieces, places, faces.pieces);
    return faces;
}

}  // namespace clsdf::cutting
