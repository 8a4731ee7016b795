#include "polyhedra/edge_slopes.hpp"

#include "polyhedra/frame_batch.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace clsdf::polyhedra {

namespace {

constexpr std::size_t faces_at_once = WedgeBatch::capacity / 3;

/// Edges without exactly one other face.
constexpr std::uint8_t without_pair = edge_open | edge_non_manifold | edge_at_box;

}  // namespace

float open_slope(double half_width, double slack) {
    return std::max(CLSDF_OPEN_SLOPE, widened(2 * half_width / slack));
}

void EdgeSlopes::measure(std::size_t begin, std::size_t end) {
    begin_ = begin;
    size_ = end - begin;
    find_neighbours();
    measure_frames();
    slopes_.resize(size_);
    questions_.clear();
    for (std::size_t first = 0; first < size_; first += faces_at_once)
        set_group(first, std::min(size_, first + faces_at_once));
    answer_questions();
}

void EdgeSlopes::find_neighbours() {
    across_.resize(3 * size_);
    beyond_.clear();
    for (std::size_t face = 0; face < size_; ++face) {
        const FaceEdges& edges = edges_[begin_ + face];
        for (std::uint32_t k = 0; k < 3; ++k) {
            std::size_t place = face;
            if (!(edges.marks[k] & without_pair)) {
                const std::size_t other = edges.across[k] >> 2;
                place = other - begin_;
                if (place >= size_) {
                    place = size_ + beyond_.size();
                    beyond_.push_back(faces_.triangles[other]);
                }
            }
            across_[3 * face + k] = static_cast<std::uint32_t>(place);
        }
    }
}

void EdgeSlopes::measure_frames() {
    frames_.resize(size_ + beyond_.size());
    const std::span<TriangleFrame> frames(frames_);
    triangle_frames(faces_.positions, faces_.triangles.subspan(begin_, size_), faces_.lattice, frames.first(size_));
    triangle_frames(faces_.positions, beyond_, faces_.lattice, frames.subspan(size_));
}

/// Of some faces, no more than are measured at once.
void EdgeSlopes::set_group(std::size_t first, std::size_t last) {
    for (std::size_t face = first; face < last; ++face) {
        const FaceEdges& edges = edges_[begin_ + face];
        for (std::uint32_t k = 0; k < 3; ++k) {
            const TriangleFrame* from = &frames_[face];
            const TriangleFrame* to = &frames_[place_across(face, k)];
            std::uint32_t edge_from = k;
            std::uint32_t edge_to = edges.marks[k] & without_pair ? k : edges.across[k] & 3;
            if (!is_first(face, k)) {
                std::swap(from, to);
                std::swap(edge_from, edge_to);
            }
            wedges_.set(3 * (face - first) + k, *from, edge_from, *to, edge_to);
        }
    }
    WedgeBatch::Results results;
    wedges_.measure(results);
    for (std::size_t face = first; face < last; ++face) {
        FaceEdges& edges = edges_[begin_ + face];
        edges.base = static_cast<std::uint8_t>(frames_[face].base_edge);
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::size_t i = 3 * (face - first) + k;
            const float slope = std::min(open_, results.slope[i]);
            const int side = results.side[i];
            slopes_[face].above[k] = side < 0 ? slope : 0;
            slopes_[face].below[k] = side > 0 ? slope : 0;
            if (side != 0 && edges.marks[k] == 0) {
                edges.marks[k] = side < 0 ? edge_convex : edge_concave;
            } else {
                set_other({face, k, results.folded[i] != 0, slope}, side);
            }
        }
    }
}

void EdgeSlopes::set_other(const Question& edge, int side) {
    FaceEdges& edges = edges_[begin_ + edge.face];
    std::uint8_t& marks = edges.marks[edge.edge];
    if (!(marks & without_pair)) {
        if (side != 0) {
            set_pair(edge, side);
        } else if (is_first(edge.face, edge.edge) || place_across(edge.face, edge.edge) >= size_) {
            questions_.push_back(edge);
        }
        return;
    }
    EdgeSlope slope{open_, open_};
    if (frames_[edge.face].is_box) {
        marks |= edge_at_box;
    } else if (marks & edge_non_manifold) {
        slope = crowded_[edges.across[edge.edge]];
    }
    slopes_[edge.face].above[edge.edge] = slope.above;
    slopes_[edge.face].below[edge.edge] = slope.below;
}

/// A box takes the wedges of all its edges, so that faces beside it need none.
void EdgeSlopes::set_pair(const Question& edge, int side) {
    const TriangleFrame& own = frames_[edge.face];
    std::uint8_t& marks = edges_[begin_ + edge.face].marks[edge.edge];
    const bool oriented = !(marks & edge_unoriented);
    if (oriented && side != 0) marks |= side < 0 ? edge_convex : edge_concave;

    float above = 0;
    float below = 0;
    if (own.is_box || frames_[place_across(edge.face, edge.edge)].is_box) {
        marks |= edge_at_box;
        if (own.is_box) above = below = open_;
    } else if (edge.folded) {
        marks |= edge_open | edge_folded;
        above = below = open_;
    } else {
        above = side < 0 ? edge.slope : 0;
        below = side > 0 ? edge.slope : 0;
        if (!oriented && !is_first(edge.face, edge.edge)) std::swap(above, below);
    }
    slopes_[edge.face].above[edge.edge] = above;
    slopes_[edge.face].below[edge.edge] = below;
}

OppositeVertex EdgeSlopes::opposite_vertex(const Question& edge) const {
    const Corner own{static_cast<std::uint32_t>(begin_ + edge.face), edge.edge};
    const Corner across = Corner::unpack(edges_[own.face].across[edge.edge]);
    return is_first(edge.face, edge.edge) ? OppositeVertex(faces_, own.face, across)
                                          : OppositeVertex(faces_, across.face, own);
}

void EdgeSlopes::answer_questions() {
    for (std::size_t first = 0; first < questions_.size(); first += PlaneSides::capacity) {
        const std::size_t count = std::min(PlaneSides::capacity, questions_.size() - first);
        const std::span<const Question> questions = std::span(questions_).subspan(first, count);
        for (std::size_t i = 0; i < count; ++i) sides_.set(i, opposite_vertex(questions[i]));
        PlaneSides::Sides sides;
        sides_.measure(sides);
        for (std::size_t i = 0; i < count; ++i) {
            int side = sides[i];
            if (side == 0) side = side_of_plane(opposite_vertex(questions[i]));
            set_pair(questions[i], side);
            const std::size_t across = place_across(questions[i].face, questions[i].edge);
            if (across >= size_) continue;
            const std::uint32_t edge = edges_[begin_ + questions[i].face].across[questions[i].edge] & 3;
            set_pair({across, edge, questions[i].folded, questions[i].slope}, side);
        }
    }
}

void lean(const TriangleFrame& frame, FaceSlopes& slopes) {
    const double cosine = frame.normal_across[CLSDF_HALF_RIGHT] * frame.normal_across[CLSDF_HALF_LEFT] -
                          frame.normal_along[CLSDF_HALF_RIGHT] * frame.normal_along[CLSDF_HALF_LEFT];
    if (!(cosine > 0)) return;
    const std::size_t right = next_of_three(frame.base_edge);
    const std::size_t left = previous_of_three(frame.base_edge);
    for (std::array<float, 3>* side : {&slopes.above, &slopes.below}) {
        float& at_right = (*side)[right];
        float& at_left = (*side)[left];
        const float from_right = widened(cosine * static_cast<double>(at_right));
        const float from_left = widened(cosine * static_cast<double>(at_left));
        at_right = std::max(at_right, from_left);
        at_left = std::max(at_left, from_right);
    }
}

}  // namespace clsdf::polyhedra
