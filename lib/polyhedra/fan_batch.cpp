#include "polyhedra/fan_batch.hpp"

#include "core/several_targets.hpp"
#include "polyhedra/fan_rejections.hpp"

namespace clsdf::polyhedra {

namespace {

/// Conditions v . u >= 0 for all faces of a fan to reject u, each at one of its edges and on one side.
using Conditions = std::array<LaneVectors, FanBatch::most_faces>;

inline double lesser(double a, double b) {
    return a < b ? a : b;
}

/// Whether three of the conditions combine to sign * middle . u >= 0, strictly but for u = 0: sign_of_combination() of
/// all of them, lane by lane. 1 where they do.
CLSDF_SEVERAL_TARGETS void find_combinations(const Conditions& v, std::size_t count, const LaneVectors& middle,
                                             double sign, Lanes& found) {
    std::array<std::array<LaneVectors, FanBatch::most_faces>, FanBatch::most_faces> crosses;
    std::array<std::array<Lanes, FanBatch::most_faces>, FanBatch::most_faces> turns;  // middle . cross
    for (std::size_t j = 0; j < count; ++j) {
        for (std::size_t k = j + 1; k < count; ++k) {
            const LaneVectors& a = v[j];
            const LaneVectors& b = v[k];
            LaneVectors& cross = crosses[j][k];
            Lanes& turn = turns[j][k];
#pragma omp simd
            for (std::size_t i = 0; i < lanes; ++i) {
                cross.x[i] = a.y[i] * b.z[i] - a.z[i] * b.y[i];
                cross.y[i] = a.z[i] * b.x[i] - a.x[i] * b.z[i];
                cross.z[i] = a.x[i] * b.y[i] - a.y[i] * b.x[i];
                turn[i] = dot_of_lane(middle, cross, i);
            }
        }
    }
    Lanes best{};  // the least of a combination's numbers
    for (std::size_t first = 0; first < count; ++first) {
        for (std::size_t j = first + 1; j < count; ++j) {
            for (std::size_t k = j + 1; k < count; ++k) {
                const LaneVectors& a = v[first];
                const LaneVectors& cross = crosses[j][k];
                const Lanes& from_first = turns[first][j];
                const Lanes& from_second = turns[j][k];
                const Lanes& to_first = turns[first][k];  // reversed
#pragma omp simd
                for (std::size_t i = 0; i < lanes; ++i) {
                    const double least = lesser(lesser(from_first[i], from_second[i]),
                                                lesser(-to_first[i], sign * dot_of_lane(a, cross, i)));
                    best[i] = best[i] > least ? best[i] : least;
                }
            }
        }
    }
    for (std::size_t i = 0; i < lanes; ++i) found[i] = best[i] > certain_product ? 1 : 0;
}

}  // namespace

// cannot_all_reject() in fan_rejections.cpp does the same, fan by fan.
CLSDF_SEVERAL_TARGETS void FanBatch::ask(double margin, Answers& are_covered) const {
    const std::size_t count = face_count_;
    LaneVectors middle{};
    for (std::size_t f = 0; f < count; ++f) {
        for (std::size_t i = 0; i < lanes; ++i) {
            middle.x[i] += normals_[f].x[i];
            middle.y[i] += normals_[f].y[i];
            middle.z[i] += normals_[f].z[i];
        }
    }
    const auto faces = static_cast<double>(count);
    for (std::size_t i = 0; i < lanes; ++i) {
        middle.x[i] /= faces;
        middle.y[i] /= faces;
        middle.z[i] /= faces;
    }

    const double sure_margin = certain_part * margin;
    std::array<Lanes, 4> found{};
    Lanes steepest{};
    Conditions above;
    Conditions below;
    for (std::size_t end = 0; end < 2; ++end) {
        for (std::size_t f = 0; f < count; ++f) {
            const LaneVectors& normal = normals_[f];
            const Edge& edge = edges_[end][f];
            for (std::size_t i = 0; i < lanes; ++i) {
                const double a = edge.above[i];
                const double b = edge.below[i];
                const double steeper = a > b ? a : b;
                steepest[i] = steepest[i] > steeper ? steepest[i] : steeper;
                const double lower = sure_margin * (1 + a);
                const double raise = sure_margin * (1 + b);
                above[f].x[i] = -edge.inward.x[i] - a * normal.x[i] - lower * middle.x[i];
                above[f].y[i] = -edge.inward.y[i] - a * normal.y[i] - lower * middle.y[i];
                above[f].z[i] = -edge.inward.z[i] - a * normal.z[i] - lower * middle.z[i];
                below[f].x[i] = -edge.inward.x[i] + b * normal.x[i] + raise * middle.x[i];
                below[f].y[i] = -edge.inward.y[i] + b * normal.y[i] + raise * middle.y[i];
                below[f].z[i] = -edge.inward.z[i] + b * normal.z[i] + raise * middle.z[i];
            }
        }
        find_combinations(above, count, middle, -1, found[2 * end]);
        find_combinations(below, count, middle, 1, found[2 * end + 1]);
    }
    for (std::size_t i = 0; i < lanes; ++i)
        are_covered[i] =
            found[0][i] * found[1][i] * found[2][i] * found[3][i] > 0 && steepest[i] <= steepest_slope ? 1 : 0;
}

}  // namespace clsdf::polyhedra
