#include "polyhedra/fan_batch.hpp"

#include "core/several_targets.hpp"

#include <algorithm>

// Why three planes prove it, v_i and w_i: docs/method.md, 'Gaps at saddle vertices'.

namespace clsdf::polyhedra {

namespace {

/// Above the rounding of a product of three vectors no longer than ten, 1e-12.
constexpr double certain_product = 1e-9;
/// Vectors of steeper slopes, at sharp edges, would be longer than ten.
constexpr double steepest_slope = 8;
/// Share of the margin; the rest covers the rounding of the conditions.
constexpr double certain_part = 0.99;

/// Conditions v . u >= 0 for all faces of a fan to reject u, each at one of its edges and on one side.
using Conditions = std::array<LaneVectors, FanBatch::most_faces>;

/// A value for each pair of faces j < k, at [j][k].
template <typename Value>
using OfPairs = std::array<std::array<Value, FanBatch::most_faces>, FanBatch::most_faces>;

inline double lesser(double a, double b) {
    return a < b ? a : b;
}
inline double greater(double a, double b) {
    return a > b ? a : b;
}

/// middle . (a x b)
inline double turn_of_lane(const LaneVectors& middle, const LaneVectors& a, const LaneVectors& b, std::size_t i) {
    return dot(middle.x[i], middle.y[i], middle.z[i], a.y[i] * b.z[i] - a.z[i] * b.y[i],
               a.z[i] * b.x[i] - a.x[i] * b.z[i], a.x[i] * b.y[i] - a.y[i] * b.x[i]);
}

inline bool are_all(const Lanes& numbers) {
    bool all = true;
    for (std::size_t i = 0; i < lanes; ++i) all = all && numbers[i] > certain_product;
    return all;
}

/// Whether three of the conditions combine to sign * middle . u >= 0 by positive factors, surely: 1 where they do.
///
///     middle . (b x c) a + middle . (c x a) b + middle . (a x b) c = det(a, b, c) middle
///
/// Only those are looked for that run counter-clockwise around `middle`, as the faces of a fan do around its mean
/// normal.
CLSDF_SEVERAL_TARGETS void find_combinations(const Conditions& v, std::size_t count, const LaneVectors& middle,
                                             double sign, Lanes& found) {
    Lanes best{};  // the least of a combination's three factors and of its determinant

    // Conditions a third of the fan apart mostly do.
    const std::size_t third = (count + 1) / 3;
    for (std::size_t first = 0; first < third; ++first) {
        const LaneVectors& a = v[first];
        const LaneVectors& b = v[first + third];
        const LaneVectors& c = v[std::min(first + 2 * third, count - 1)];
        for (std::size_t i = 0; i < lanes; ++i) {
            const double x = b.y[i] * c.z[i] - b.z[i] * c.y[i];
            const double y = b.z[i] * c.x[i] - b.x[i] * c.z[i];
            const double z = b.x[i] * c.y[i] - b.y[i] * c.x[i];
            const double of_a = dot(middle.x[i], middle.y[i], middle.z[i], x, y, z);
            const double of_b = turn_of_lane(middle, c, a, i);
            const double of_c = turn_of_lane(middle, a, b, i);
            const double determinant = sign * dot(a.x[i], a.y[i], a.z[i], x, y, z);
            best[i] = greater(best[i], lesser(lesser(of_a, of_b), lesser(of_c, determinant)));
        }
    }
    if (are_all(best)) {
        found.fill(1);
        return;
    }

    OfPairs<LaneVectors> crosses;
    OfPairs<Lanes> turns;  // middle . cross
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
                    best[i] = greater(best[i], least);
                }
            }
        }
    }
    for (std::size_t i = 0; i < lanes; ++i) found[i] = best[i] > certain_product ? 1 : 0;
}

}  // namespace

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
                const auto a = static_cast<double>(edge.above[i]);
                const auto b = static_cast<double>(edge.below[i]);
                steepest[i] = greater(steepest[i], greater(a, b));
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
