#include <clsdf/error.hpp>
#include <clsdf/outer.hpp>

#include "core/floating_point.hpp"
#include "core/large_memory.hpp"
#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "core/vectors.hpp"
#include "cutting/closed_gaps.hpp"
#include "cutting/face_pieces.hpp"
#include "cutting/outer_mesh.hpp"
#include "cutting/patches.hpp"
#include "cutting/piece_sites.hpp"
#include "cutting/plane_patches.hpp"
#include "cutting/rejoined.hpp"
#include "mesh/disjoint_sets.hpp"
#include "mesh/equal_vertices.hpp"
#include "mesh/one_rings.hpp"
#include "surface/corners_in_edges.hpp"
#include "surface/parts.hpp"
#include "surface/topology.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace clsdf {

namespace {

using cutting::Cancellation;
using cutting::CutPoints;
using cutting::FaceCuts;
using cutting::Fate;
using cutting::Meetings;
using cutting::Piece;
using cutting::View;

/// The rule in use, and the warning about it.
ResolvedSignRule checked_rule(SignRule asked, const Mesh& mesh, const Topology& topology) {
    const bool is_known = asked == SignRule::automatic || asked == SignRule::nonzero || asked == SignRule::parity;
    const ResolvedSignRule resolved = is_known ? resolve_sign_rule(asked, topology) : ResolvedSignRule{asked, {}};
    if (resolved.rule == SignRule::nonzero || resolved.rule == SignRule::parity) return resolved;
    const std::string why = resolved.warning.empty() ? "" : "; " + resolved.warning;
    if (topology.closed)
        refuse_unsupported("{}: the outer surface needs the sign rule nonzero or parity, not {}; take auto",
                           mesh.name(), name_of(resolved.rule));
    refuse_unsupported(
        "{}: the outer surface needs the sign rule nonzero or parity, so a closed mesh, and this one has "
        "{} open edges; join its seams (weld), "
        "close a terrain by walls and a floor (close_down(), clsdf close), or fill its holes by another "
        "program{}",
        mesh.name(), topology.open_edges, why);
}

/// Whole faces that meet no other face, and the pieces of those that do.
std::vector<Piece> pieces_of(CutPoints& points, std::span<const View> views, const cutting::FaceBoxes& boxes,
                             const cutting::PlanePatches& planes, const Cancellation& cancellation) {
    const std::span<const Triangle> triangles = points.triangles();
    const Meetings meetings(points, views, boxes, planes, cancellation);
    std::vector<std::uint32_t> met;
    for (std::uint32_t face = 0; face < triangles.size(); ++face)
        if (!meetings.of(face).empty()) met.push_back(face);

    std::vector<std::unique_ptr<FaceCuts>> cuts(met.size());
    for_each_index(
        met.size(),
        [&](std::size_t i) {
            cancellation.check();
            cuts[i] = std::make_unique<FaceCuts>(points, met[i], views[met[i]], meetings.of(met[i]));
        },
        4);
    std::vector<std::vector<std::uint32_t>> crossings(met.size());
    for (std::size_t i = 0; i < met.size(); ++i)
        for (const CutPoints::Found& found : cuts[i]->crossings()) crossings[i].push_back(points.number(found));
    std::vector<std::vector<Triangle>> parts(met.size());
    for_each_index(
        met.size(),
        [&](std::size_t i) {
            cancellation.check();
            parts[i] = cuts[i]->pieces(points, crossings[i]);
        },
        4);

    std::vector<Piece> pieces;
    pieces.reserve(triangles.size());
    for (std::uint32_t face = 0, i = 0; face < triangles.size(); ++face) {
        if (views[face].direction == 0) continue;
        if (i < met.size() && met[i] == face) {
            for (const Triangle& part : parts[i]) pieces.push_back({part, face});
            ++i;
        } else {
            pieces.push_back({triangles[face], face});
        }
    }
    return pieces;
}

/// Of the power of two by which the largest coordinate is between 1/2 and 1.
int exponent_of(const Mesh& mesh) {
    double largest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        largest = std::max({largest, std::abs(mesh.box().lower[axis]), std::abs(mesh.box().upper[axis])});
    int exponent = 0;
    static_cast<void>(std::frexp(largest, &exponent));
    return exponent;
}

/// Whether each edge of triangles is used equally often in both directions.
bool are_balanced(std::span<const Triangle> triangles) {
    struct Edge {
        std::uint32_t from, to;  ///< from < to
        int way;
    };
    std::vector<Edge> edges;
    edges.reserve(3 * triangles.size());
    for (const Triangle& triangle : triangles)
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t a = triangle[i], b = triangle[(i + 1) % 3];
            edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1});
        }
    std::ranges::sort(edges, {}, [](const Edge& edge) { return std::pair(edge.from, edge.to); });
    for (std::size_t i = 0; i < edges.size();) {
        const Edge& first = edges[i];
        int sum = 0;
        for (; i < edges.size() && edges[i].from == first.from && edges[i].to == first.to; ++i) sum += edges[i].way;
        if (sum != 0) return false;
    }
    return true;
}

/// In long double: of slivers the products cancel each other.
void measure(OuterSurface& surface) {
    using Vector = std::array<long double, 3>;
    const std::vector<Vec3>& vertices = surface.mesh.vertices();
    const auto way = [](const Vec3& to, const Vec3& from) {
        Vector found;
        for (std::size_t k = 0; k < 3; ++k) found[k] = static_cast<long double>(to[k]) - from[k];
        return found;
    };
    const auto dot_of = [](const Vector& u, const Vector& v) { return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]; };
    long double volume = 0, area = 0;
    for (const auto& [a, b, c] : surface.mesh.triangles()) {
        const Vector u = way(vertices[b], vertices[a]), v = way(vertices[c], vertices[a]);
        const Vector normal{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
        volume += dot_of(way(vertices[a], surface.mesh.box().lower), normal);
        area += std::sqrt(dot_of(normal, normal));
    }
    surface.volume = static_cast<double>(volume / 6);
    surface.area = static_cast<double>(area / 2);
}

/// Whether all faces are joined over edges of two.
bool are_one_piece(std::span<const Triangle> triangles, std::size_t vertex_count) {
    const OneRings rings(triangles, vertex_count);
    DisjointSets sets(triangles.size());
    std::vector<EdgeEntry> entries;
    for (std::uint32_t vertex = 0; vertex < vertex_count; ++vertex) {
        edges_above(triangles, rings, vertex, entries);
        for_each_edge(entries, [&](std::span<const EdgeEntry> faces) {
            if (faces.size() == 2) sets.join(faces[0].edge().face, faces[1].edge().face);
        });
    }
    std::optional<std::uint32_t> first;
    for (std::uint32_t face = 0; face < triangles.size(); ++face) {
        if (has_repeated_vertex(triangles[face])) continue;
        if (!first) first = sets.root(face);
        if (sets.root(face) != *first) return false;
    }
    return true;
}

/// Whether the kept pieces are the faces as given, all of them.
bool are_all_faces(std::span<const Piece> pieces, std::span<const Fate> fates, const SignSurface& surface,
                   std::span<const Triangle> triangles) {
    if (!surface.is_mesh() || pieces.size() != triangles.size()) return false;
    for (std::size_t i = 0; i < pieces.size(); ++i)
        if (fates[i] != Fate::kept || pieces[i].face != i || pieces[i].corners != triangles[i]) return false;
    return true;
}

/// Sentences that a semicolon parts.
std::string warning_of(const ResolvedSignRule& resolved, const OuterSurface& surface, std::size_t all) {
    if (surface.hidden_faces == 0) return resolved.warning;
    const std::string hidden = fmt::format(
        "{} of {} faces {} not on the outer surface: within others, repeated, or with the same on both sides",
        surface.hidden_faces, all, surface.hidden_faces == 1 ? "is" : "are");
    return resolved.warning.empty() ? hidden : resolved.warning + "; " + hidden;
}

/// Sentences that a semicolon parts.
void add_warning(const cutting::ClosedGaps& gaps, ResolvedSignRule& resolved) {
    if (gaps.left == 0) return;
    resolved.warning += fmt::format(
        "{}{} that look at each other are nearer than 1e-9 of the largest coordinate and stay apart: if they are to be "
        "joined, --weld LENGTH (weld()) joins near vertices",
        resolved.warning.empty() ? "" : "; ", gaps.left == 1 ? "2 faces" : fmt::format("{} pairs of faces", gaps.left));
}

/// A mesh that is closed but for corners of faces in edges of others, with the triangles between them.
struct ClosedCorners {
    Mesh mesh;
    std::vector<ClosingTriangle> added;  ///< the last triangles of the mesh
    DescribedMesh described;
};
/// Nothing if there are none, or if the mesh is not closed with them.
std::optional<ClosedCorners> closed_corners(const Mesh& mesh, const SignSurface& surface, SignRule asked) {
    std::vector<Triangle> triangles;
    triangles.reserve(mesh.triangles().size());
    for (std::size_t face = 0; face < mesh.triangles().size(); ++face)
        triangles.push_back(surface.triangle(mesh.triangles()[face], face));
    std::vector<ClosingTriangle> added = corners_in_edges(mesh, triangles);
    if (added.empty()) return std::nullopt;
    triangles = mesh.triangles();
    for (const ClosingTriangle& one : added) triangles.push_back(one.corners);
    Mesh closed(mesh.vertices(), std::move(triangles), mesh.name());
    DescribedMesh described = describe_mesh(closed, asked);
    if (!described.topology.closed) return std::nullopt;
    return ClosedCorners{std::move(closed), std::move(added), std::move(described)};
}

/// A piece of a closing triangle is told as a piece of the edge that this lies in. corners: of the piece; face: that
/// has the edge, in any direction.
void tell_as_edge(const std::array<Vec3, 3>& corners, const Triangle& face, const ClosingTriangle& closing,
                  std::span<const Vec3> vertices, FacePiece& told) {
    const auto has = [&](std::uint32_t vertex) { return vertex == closing.from || vertex == closing.corners[0]; };
    std::uint32_t edge = 0;
    while (edge < 2 && !(has(face[edge]) && has(face[edge + 1]))) ++edge;
    const Vec3 &from = vertices[face[edge]], to = vertices[face[(edge + 1) % 3]];
    const Vec3 way = difference(to, from);
    for (std::size_t k = 0; k < 3; ++k) {
        const double along = std::clamp(dot(difference(corners[k], from), way) / dot(way, way), 0.0, 1.0);
        std::array<double, 3> weights{};
        weights[edge] = 1 - along;
        weights[(edge + 1) % 3] += along;
        told.weights[2 * k] = weights[1];
        told.weights[2 * k + 1] = weights[2];
    }
    std::ranges::fill(told.site, static_cast<clsdf_uint8>(3 + edge));
}

/// for_transform: also what transforms need beside the surface.
cutting::OuterMesh outer_mesh(const Mesh& given, SignRule asked, const CallOptions& call, bool for_transform) {
    const DefaultFloatingPoint as_kernels;
    const Cancellation cancellation(call.should_stop, "the search for the outer surface");
    const std::vector<std::uint32_t> first = first_equal_vertices(given.vertices());
    std::optional<Mesh> one_of_each;
    for (std::size_t v = 0; v < first.size() && !one_of_each; ++v)
        if (first[v] != v) one_of_each = merged(given, first);
    const Mesh& joined = one_of_each ? *one_of_each : given;
    auto [topology, surface] = describe_mesh(joined, asked);
    const std::optional<ClosedCorners> closed = topology.closed ? std::nullopt : closed_corners(joined, surface, asked);
    if (closed) {
        topology = closed->described.topology;
        surface = closed->described.surface;
    }
    const Mesh& mesh = closed ? closed->mesh : joined;
    const std::size_t face_count = given.triangles().size();
    const auto face_of = [&](std::uint32_t face) {
        return face < face_count ? face : closed->added[face - face_count].face;
    };
    const std::size_t overlapping_parts = std::exchange(topology.overlapping_parts, 0);  // they are no news here
    ResolvedSignRule resolved = checked_rule(asked, given, topology);
    const SignRule rule = resolved.rule;
    if (closed)
        resolved.warning =
            fmt::format("{} in edges of other faces, and the outer surface is closed there{}{}",
                        closed->added.size() == 1 ? "1 corner of a face lies"
                                                  : fmt::format("{} corners of faces lie", closed->added.size()),
                        resolved.warning.empty() ? "" : "; ", resolved.warning);

    // Products of seven lengths must be numbers.
    const int exponent = exponent_of(mesh);
    std::vector<Vec3> scaled = mesh.vertices();
    for_each_index(scaled.size(), [&](std::size_t v) {
        for (double& x : scaled[v]) x = std::ldexp(x, -exponent);
    });
    std::vector<Triangle> triangles;
    triangles.reserve(mesh.triangles().size());
    for (const auto& [a, b, c] : mesh.triangles())
        triangles.push_back({surface.vertex(a), surface.vertex(b), surface.vertex(c)});
    std::vector<View> views = cutting::views_of(scaled, triangles);
    std::vector<bool> is_moved;
    const bool has_parts = topology.parts > 1 || !are_one_piece(triangles, scaled.size());
    cutting::FaceBoxes boxes(scaled, triangles, views, has_parts ? cutting::gap_margin / 2 : 0);
    if (has_parts) {
        cutting::ClosedGaps gaps =
            cutting::close_gaps(scaled, triangles, boxes, surface, topology.inside_out, cancellation);
        if (!gaps.is_moved.empty() || gaps.is_changed) {
            views = cutting::views_of(scaled, triangles);
            boxes = cutting::FaceBoxes(scaled, triangles, views);
        }
        add_warning(gaps, resolved);
        is_moved = std::move(gaps.is_moved);
    }
    if (!for_transform && call.log && !resolved.warning.empty()) call.log(resolved.warning);
    CutPoints points(scaled, triangles);
    const cutting::PlanePatches planes(scaled, triangles, surface);
    const std::vector<Piece> pieces = pieces_of(points, views, boxes, planes, cancellation);
    const std::vector<Fate> fates =
        cutting::fates_of(points, views, boxes, pieces, planes, surface, rule, cancellation);

    std::vector<std::array<std::uint32_t, 2>> counts(face_count);  // kept and dropped
    for (std::size_t i = 0; i < pieces.size(); ++i)
        if (pieces[i].face < face_count) ++counts[pieces[i].face][fates[i] == Fate::dropped ? 1 : 0];
    const std::vector<Piece> kept_pieces = cutting::rejoined(points, views, pieces, fates, cancellation);
    constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> numbers(points.size(), none);
    std::vector<Vec3> vertices;
    std::vector<Triangle> kept;
    std::vector<std::uint32_t> faces;
    for (const Piece& piece : kept_pieces) {
        Triangle corners = piece.corners;
        for (std::uint32_t& corner : corners) {
            if (numbers[corner] == none) {
                numbers[corner] = static_cast<std::uint32_t>(vertices.size());
                const bool is_as_given = corner < scaled.size() && (is_moved.empty() || !is_moved[corner]);
                Vec3 vertex = is_as_given ? mesh.vertices()[corner] : points.rounded(corner);
                if (!is_as_given)
                    for (double& x : vertex) x = std::ldexp(x, exponent);
                vertices.push_back(vertex);
            }
            corner = numbers[corner];
        }
        kept.push_back(corners);
        faces.push_back(face_of(piece.face));
    }
    if (kept.empty())
        throw Error(
            ErrorCode::invalid_mesh,
            fmt::format("{}: by the sign rule {} nothing is inside, so there is no outer surface: the rule none "
                        "gives the distance to the faces as given",
                        given.name(), name_of(rule)));

    if (pieces.size() != triangles.size() && !are_balanced(kept))
        refuse_unsupported(
            "{}: the pieces of its faces form no closed surface, which must not happen: please report "
            "the mesh",
            given.name());
    OuterSurface result{Mesh(std::move(vertices), std::move(kept), given.name()), std::move(faces)};
    for (const auto& [on, off] : counts)
        ++(on == 0 ? result.hidden_faces : off == 0 ? result.whole_faces : result.partial_faces);
    if (const FaceGroups& groups = given.groups(); !groups.empty()) {
        FaceGroups own{groups.names, {}};
        own.numbers.reserve(result.faces.size());
        for (const std::uint32_t face : result.faces) own.numbers.push_back(groups.numbers[face]);
        result.mesh.set_groups(std::move(own));
    }
    measure(result);
    cutting::OuterMesh made{std::move(result), {}, {}, rule, {}};
    if (!for_transform) return made;
    made.warning = warning_of(resolved, made.surface, face_count);
    if (closed || !are_all_faces(pieces, fates, surface, triangles)) {
        made.faces = cutting::given_faces(points, views, kept_pieces, cancellation);
        for (std::size_t i = 0; i < kept_pieces.size(); ++i) {
            const std::uint32_t own = kept_pieces[i].face;
            if (own < face_count) continue;
            FacePiece& told = made.faces.pieces[i];
            told.face = made.faces.numbers[i] = face_of(own);
            const Triangle& piece = made.surface.mesh.triangles()[i];
            const std::vector<Vec3>& at = made.surface.mesh.vertices();
            const auto& [a, b, c] = mesh.triangles()[told.face];
            tell_as_edge({at[piece[0]], at[piece[1]], at[piece[2]]},
                         {surface.vertex(a), surface.vertex(b), surface.vertex(c)}, closed->added[own - face_count],
                         mesh.vertices(), told);
        }
    }
    const Topology of_vertices = describe_vertices(given, first);
    made.topology = std::move(topology);
    made.topology.unused_vertices = of_vertices.unused_vertices;
    made.topology.coincident_vertices = of_vertices.coincident_vertices;
    made.topology.overlapping_parts = overlapping_parts;
    made.topology.partial_faces = made.surface.partial_faces;
    made.topology.hidden_faces = made.surface.hidden_faces;
    return made;
}

}  // namespace

cutting::OuterMesh cutting::outer_mesh(const Mesh& given, SignRule asked, const CallOptions& call) {
    return clsdf::outer_mesh(given, asked, call, true);
}

OuterSurface outer(const Mesh& given, SignRule asked, const CallOptions& call) {
    return with_host_memory("for the outer surface; divide the mesh",
                            [&] { return std::move(outer_mesh(given, asked, call, false).surface); });
}

}  // namespace clsdf
