#include "polyhedra/edge_slopes.hpp"

#include "core/parallel.hpp"
#include "polyhedra/edge_batches.hpp"
#include "polyhedra/edges.hpp"
#include "polyhedra/frame_batch.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace clsdf::polyhedra {

namespace {

/// Edges without exactly one other face.
constexpr std::uint8_t without_pair = edge_open | edge_non_manifold | edge_at_box;

}  // namespace

void EdgeSlopes::measure(std::size_t begin, std::size_t end) {
    begin_ = begin;
    size_ = end - begin;
    find_wedges();
    measure_frames();
    slopes_.resize(size_);
    for (const Corner& edge : alone_) set_alone(edge);
    questions_.clear();
    const std::span<const Wedge> wedges(wedges_);
    for (std::size_t first = 0; first < wedges.size(); first += WedgeBatch::capacity)
        measure_wedges(wedges.subspan(first, std::min(WedgeBatch::capacity, wedges.size() - first)));
    answer_questions();
}

void EdgeSlopes::find_wedges() {
    alone_.clear();
    beyond_.clear();
    wedges_.resize(3 * size_);
    std::size_t count = 0;
    for (std::uint32_t face = 0; face < size_; ++face) {
        const FaceEdges& edges = edges_[begin_ + face];
        for (std::uint32_t k = 0; k < 3; ++k) {
            const Corner own{face, k};
            if (edges.marks[k] & without_pair) {
                alone_.push_back(own);
                continue;
            }
            const Corner other = Corner::unpack(edges.across[k]);
            const std::size_t place = other.face - begin_;
            if (place < size_) {
                wedges_[count] = {own, {static_cast<std::uint32_t>(place), other.vertex}};
                count += face < place ? 1U : 0U;  // not a branch: that could not be predicted
            } else {
                const Corner across{static_cast<std::uint32_t>(size_ + beyond_.size()), other.vertex};
                beyond_.push_back(faces_.triangles[other.face]);
                wedges_[count++] = {own, across};
            }
        }
    }
    wedges_.resize(count);
}

void EdgeSlopes::measure_frames() {
    frames_.resize(size_ + beyond_.size());
    const std::span<TriangleFrame> frames(frames_);
    triangle_frames(faces_.positions, faces_.triangles.subspan(begin_, size_), faces_.lattice, frames.first(size_));
    triangle_frames(faces_.positions, beyond_, faces_.lattice, frames.subspan(size_));
    for (std::size_t face = 0; face < size_; ++face)
        edges_[begin_ + face].base = static_cast<std::uint8_t>(frames_[face].base_edge);
}

void EdgeSlopes::set_alone(const Corner& edge) {
    EdgeSlope slope{open_, open_};
    if (frames_[edge.face].is_box) {
        marks(edge) |= edge_at_box;
    } else if (marks(edge) & edge_non_manifold) {
        slope = of_non_manifold_[edges_[begin_ + edge.face].across[edge.vertex]];
    }
    set(edge, slope);
}

/// No more than are measured at once.
void EdgeSlopes::measure_wedges(std::span<const Wedge> wedges) {
    for (std::size_t i = 0; i < wedges.size(); ++i) {
        const auto& [first, second] = wedges[i];
        batch_.set(i, frames_[first.face], first.vertex, frames_[second.face], second.vertex);
    }
    batch_.measure(measured_);
    for (std::size_t i = 0; i < wedges.size(); ++i) {
        const Measured wedge{wedges[i], measured_.folded[i] != 0, std::min(open_, measured_.slope[i])};
        const int side = measured_.side[i];
        if (side == 0)
            questions_.push_back(wedge);
        else if (marks(wedge.faces.first) & edge_unoriented)
            set_any(wedge, side);
        else
            set_usual(wedge, side);
    }
}

/// The usual case: two faces of one orientation, and their frames tell the side.
void EdgeSlopes::set_usual(const Measured& wedge, int side) {
    for (const Corner& edge : {wedge.faces.first, wedge.faces.second}) {
        if (edge.face >= size_) continue;
        marks(edge) = side < 0 ? edge_convex : edge_concave;
        set(edge, {side < 0 ? wedge.slope : 0, side > 0 ? wedge.slope : 0});
    }
}

/// A box takes the wedges of all its edges, so that faces beside it need none.
void EdgeSlopes::set_any(const Measured& wedge, int side) {
    const auto& [first, second] = wedge.faces;
    const bool at_box = frames_[first.face].is_box || frames_[second.face].is_box;
    for (const Corner& edge : {first, second}) {
        if (edge.face >= size_) continue;
        const bool oriented = !(marks(edge) & edge_unoriented);
        if (oriented && side != 0) marks(edge) |= side < 0 ? edge_convex : edge_concave;

        EdgeSlope slope{0, 0};
        if (at_box) {
            marks(edge) |= edge_at_box;
            if (frames_[edge.face].is_box) slope = {open_, open_};
        } else if (wedge.folded) {
            marks(edge) |= edge_open | edge_folded;
            slope = {open_, open_};
        } else {
            slope = {side < 0 ? wedge.slope : 0, side > 0 ? wedge.slope : 0};
            if (!oriented && edge.face == second.face) std::swap(slope.above, slope.below);
        }
        set(edge, slope);
    }
}

OppositeVertex EdgeSlopes::opposite_vertex(const Wedge& wedge) const {
    const std::size_t face = begin_ + wedge.first.face;
    return {faces_, static_cast<std::uint32_t>(face), Corner::unpack(edges_[face].across[wedge.first.vertex])};
}

void EdgeSlopes::answer_questions() {
    for (std::size_t first = 0; first < questions_.size(); first += PlaneSides::capacity) {
        const std::size_t count = std::min(PlaneSides::capacity, questions_.size() - first);
        const std::span<const Measured> questions = std::span(questions_).subspan(first, count);
        for (std::size_t i = 0; i < count; ++i) sides_.set(i, opposite_vertex(questions[i].faces));
        PlaneSides::Sides sides;
        sides_.measure(sides);
        for (std::size_t i = 0; i < count; ++i) {
            const int side = sides[i] != 0 ? sides[i] : side_of_plane(opposite_vertex(questions[i].faces));
            set_any(questions[i], side);
        }
    }
}

namespace {

/// Each face shares its wedges with the next faces in either direction around the edge. Faces folded onto each other
/// have an empty wedge between them, whichever comes first.
void set_around(std::span<const EdgeEntry> faces, std::span<const TriangleFrame> frames, float open,
                std::span<EdgeSlope> slopes) {
    struct Spoke {
        double angle;
        std::size_t face;
    };
    const Vector x = frames[0].inwards[faces[0].edge().vertex];
    const Vector y = frames[0].normal;
    std::vector<Spoke> spokes;
    for (std::size_t i = 0; i < faces.size(); ++i) {
        const Vector& inward = frames[i].inwards[faces[i].edge().vertex];
        spokes.push_back({std::atan2(inward.dot(y), inward.dot(x)), i});
    }
    std::stable_sort(spokes.begin(), spokes.end(), [](const Spoke& a, const Spoke& b) { return a.angle < b.angle; });

    constexpr double turn = 2 * std::numbers::pi;
    const auto slope_of_gap = [open](double gap) {
        if (gap <= std::numbers::pi) return 0.0F;
        return gap < turn - fold_angle ? std::min(open, widened(-1 / std::tan(gap / 2))) : open;
    };
    for (std::size_t i = 0; i < spokes.size(); ++i) {
        const double angle = spokes[i].angle;
        const double next = i + 1 < spokes.size() ? spokes[i + 1].angle : spokes.front().angle + turn;
        const double previous = i > 0 ? spokes[i - 1].angle : spokes.back().angle - turn;
        const Vector turning = -std::sin(angle) * x + std::cos(angle) * y;
        EdgeSlope& slope = slopes[spokes[i].face];
        slope = {slope_of_gap(next - angle), slope_of_gap(angle - previous)};
        if (frames[spokes[i].face].normal.dot(turning) < 0) std::swap(slope.above, slope.below);
    }
}

}  // namespace

std::vector<EdgeSlope> non_manifold_slopes(const MeshFaces& faces, const OneRings& rings, PairedEdges& edges,
                                           float open) {
    std::vector<EdgeSlope> slopes(edges.non_manifold_corners);
    std::atomic<std::size_t> taken = 0;
    for_each_range(edges.non_manifold_ends.size(), [&](std::size_t begin, std::size_t end) {
        std::vector<EdgeEntry> entries;
        std::vector<TriangleFrame> frames;
        for (std::size_t i = begin; i < end; ++i) {
            edges_above(faces.triangles, rings, edges.non_manifold_ends[i], entries);
            for_each_edge(entries, [&](std::span<const EdgeEntry> edge) {
                if (!is_non_manifold(edge)) return;
                const std::size_t place = taken.fetch_add(edge.size());
                frames.clear();
                for (const EdgeEntry& entry : edge) frames.push_back(faces.frame(entry.edge().face));
                // A box takes the wedges of all its edges, so that faces beside it need none.
                const bool at_box =
                    std::any_of(frames.begin(), frames.end(), [](const TriangleFrame& frame) { return frame.is_box; });
                if (!at_box) set_around(edge, frames, open, std::span(slopes).subspan(place, edge.size()));
                for (std::size_t face = 0; face < edge.size(); ++face) {
                    const Corner corner = edge[face].edge();
                    edges.faces[corner.face].across[corner.vertex] = static_cast<std::uint32_t>(place + face);
                    if (at_box) edges.faces[corner.face].marks[corner.vertex] |= edge_at_box;
                }
            });
        }
    });
    return slopes;
}

}  // namespace clsdf::polyhedra
