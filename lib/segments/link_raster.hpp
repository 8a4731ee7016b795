#pragma once

#include "link_lattice.h"
#include "segments/sample_box.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace clsdf::segments {

/// A direction and its opposite, which have the same lines of links.
struct DirectionPair {
    static constexpr std::size_t not_asked = 32;
    std::size_t forward = not_asked, backward = not_asked;  ///< their numbers
};
/// All directions but zero, in pairs, and the step of each pair.
struct PairedDirections {
    std::vector<Place> steps;
    std::vector<DirectionPair> pairs;
};
PairedDirections paired(std::span<const Place> directions);

/// Lines of directions: a place x has the coordinates u, v across the line and k along it, in steps, each linear in
/// x. A step with a component of n >= 2 on the axis along which its links are counted has n lanes: every n-th sample
/// on that axis belongs to one.
struct LineBatch {
    /// Lines that are projected together.
    static constexpr std::size_t lanes = 16;
    template <typename T>
    using Lanes = std::array<T, lanes>;

    std::array<Lanes<double>, 3> u_of{}, v_of{}, k_of{};
    Lanes<double> u_from{}, v_from{}, k_from{};
    Lanes<double> least_u{}, most_u{}, least_v{}, most_v{}, most_k{};  ///< of samples of the box
    struct Lane {
        std::size_t step;
        std::size_t along, first, second;  ///< axes
        std::int64_t begin, stride;        ///< of the samples on the axis `along`
        std::int64_t first_slope, second_slope;
    };
    std::vector<Lane> steps;
};

/// A face as the lines of a batch see it.
struct SeenFace {
    template <typename T>
    using Lanes = LineBatch::Lanes<T>;

    std::array<Lanes<double>, 3> u, v, k;
    Lanes<double> begin_u, end_u, begin_v, end_v;  ///< of lines that may cross it, both included
};

/// The links of a box that may cross a face, by the lines of the lattice along each direction: seen along it, the face
/// is a triangle in a plane in which the lines are the points of whole coordinates.
///
/// Doubles with a margin decide what may be crossed, and if the margin is kept, that it is. The margin is above the
/// rounding of samples, which do not lie on a line to the last bit, and of all that is computed here.
class LinkRaster {
public:
    /// steps: not 0; components up to 16 samples in size.
    LinkRaster(const SampleBox& box, std::span<const Place> steps);

    /// Calls visit(begin, step, is_sure) for links of the box: from sample `begin` to `begin` + steps[step]. is_sure:
    /// the link crosses the face between its ends, in every look. No other link crosses the face.
    template <typename Visit>
    void visit_links(const crossing::Corners& corners, const Visit& visit) const;

    /// The same as kernels read it: sets origin, per_unit, far, slope and rounding, and adds the lines. paired: those
    /// of the constructor's steps.
    void describe(const PairedDirections& paired, LinkLattice& lattice, std::vector<LinkLine>& lines) const;

private:
    static constexpr std::size_t lanes = LineBatch::lanes;
    template <typename T>
    using Lanes = LineBatch::Lanes<T>;
    using Batch = LineBatch;
    using Seen = SeenFace;

    static double least_of(const std::array<double, 3>& x) {
        const double of_two = x[0] < x[1] ? x[0] : x[1];
        return x[2] < of_two ? x[2] : of_two;
    }
    static double most_of(const std::array<double, 3>& x) {
        const double of_two = x[0] < x[1] ? x[1] : x[0];
        return x[2] < of_two ? of_two : x[2];
    }
    static void see(const Batch& batch, const std::array<Vec3, 3>& at, double margin, Seen& seen);
    template <typename Visit>
    void visit_lines(const Batch& batch, std::size_t lane, const Seen& seen, double margin, const Visit& visit) const;
    template <typename Visit>
    void visit_line(const Batch& batch, std::size_t lane, const std::array<double, 3>& u,
                    const std::array<double, 3>& v, const std::array<double, 3>& k, double x, double y, double margin,
                    double tolerance, double length, const Visit& visit) const;

    const SampleBox& box_;
    std::vector<Batch> batches_;
    Vec3 origin_{}, per_unit_{}, first_{};
    double far_ = 0;    ///< the greatest number of a sample
    double slope_ = 1;  ///< 1 and the greatest component of a step
};

template <typename Visit>
void LinkRaster::visit_links(const crossing::Corners& corners, const Visit& visit) const {
    std::array<Vec3, 3> at{};  // in samples from the box's first one
    double most = far_, span = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t i = 0; i < 3; ++i) {
            at[i][axis] = (corners[i][axis] - origin_[axis]) * per_unit_[axis] - first_[axis];
            most = std::max(most, std::abs(at[i][axis]));
        }
        const auto [low, high] = std::minmax({at[0][axis], at[1][axis], at[2][axis]});
        if (high < -1 || low > static_cast<double>(box_.size[axis])) return;
        span = std::max(span, high - low);
    }
    const double margin = 8 * slope_ * (0x1p-50 * most + box_.rounding * (1 + span));
    for (const Batch& batch : batches_) {
        Seen seen;
        see(batch, at, margin, seen);
        for (std::size_t lane = 0; lane < batch.steps.size(); ++lane)
            if (seen.begin_u[lane] <= seen.end_u[lane] && seen.begin_v[lane] <= seen.end_v[lane])
                visit_lines(batch, lane, seen, margin, visit);
    }
}

template <typename Visit>
void LinkRaster::visit_lines(const Batch& batch, std::size_t lane, const Seen& seen, double margin,
                             const Visit& visit) const {
    std::array<double, 3> u{}, v{}, k{};
    for (std::size_t i = 0; i < 3; ++i) {
        u[i] = seen.u[i][lane];
        v[i] = seen.v[i][lane];
        k[i] = seen.k[i][lane];
    }
    const double low_u = least_of(u), high_u = most_of(u), low_v = least_of(v), high_v = most_of(v),
                 low_k = least_of(k), high_k = most_of(k);
    if (high_k < -margin - 1 || low_k > batch.most_k[lane] + 1 + margin) return;
    // Of an edge function: corners and lines may be off by the margin.
    const double tolerance = 4 * margin * (high_u - low_u + high_v - low_v + margin);
    const bool is_wide = seen.end_u[lane] - seen.begin_u[lane] > 4;
    for (double y = seen.begin_v[lane]; y <= seen.end_v[lane]; ++y) {
        double begin = seen.begin_u[lane], end = seen.end_u[lane];
        if (is_wide) {
            // Where the row meets the edges.
            double least = high_u, most = low_u;
            for (std::size_t i = 0; i < 3; ++i) {
                const std::size_t j = (i + 1) % 3;
                const double low = std::min(v[i], v[j]), high = std::max(v[i], v[j]);
                if (low > y + margin || high < y - margin) continue;
                double from = u[i], to = u[j];
                if (high - low > 4 * margin) {
                    const double slope = (u[j] - u[i]) / (v[j] - v[i]);
                    const double one = u[i] + slope * (std::clamp(y - margin, low, high) - v[i]),
                                 other = u[i] + slope * (std::clamp(y + margin, low, high) - v[i]);
                    from = one;
                    to = other;
                }
                least = std::min({least, from, to});
                most = std::max({most, from, to});
            }
            // Twice: of the corners and of the row.
            begin = std::max(begin, std::ceil(least - 2 * margin));
            end = std::min(end, std::floor(most + 2 * margin));
        }
        for (double x = begin; x <= end; ++x)
            visit_line(batch, lane, u, v, k, x, y, margin, tolerance, high_k - low_k, visit);
    }
}

template <typename Visit>
void LinkRaster::visit_line(const Batch& batch, std::size_t lane, const std::array<double, 3>& u,
                            const std::array<double, 3>& v, const std::array<double, 3>& k, double x, double y,
                            double margin, double tolerance, double length, const Visit& visit) const {
    std::array<double, 3> w{};
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t a = (i + 1) % 3, b = (i + 2) % 3;
        w[i] = (u[b] - u[a]) * (y - v[a]) - (v[b] - v[a]) * (x - u[a]);
    }
    const double least = least_of(w), most = most_of(w);
    if (least < -tolerance && most > tolerance) return;
    const bool is_within = least > tolerance || most < -tolerance;
    const double area = w[0] + w[1] + w[2];
    double low = 0, high = 0;
    if (std::abs(area) > 8 * tolerance) {
        const double per_area = 1 / area;
        const double place = (w[0] * k[0] + w[1] * k[1] + w[2] * k[2]) * per_area;
        const double error = 4 * tolerance * length * std::abs(per_area) + 2 * margin;
        low = place - error;
        high = place + error;
    } else {
        low = least_of(k) - 2 * margin;
        high = most_of(k) + 2 * margin;
    }
    if (high < 0 || low >= batch.most_k[lane] + 1) return;
    const std::int64_t begin = low < 0 ? -1 : static_cast<std::int64_t>(low),
                       end = high > batch.most_k[lane] + 1 ? static_cast<std::int64_t>(batch.most_k[lane]) + 1
                                                           : static_cast<std::int64_t>(high);
    const bool is_sure = is_within && begin == end;
    const Batch::Lane& of = batch.steps[lane];
    for (std::int64_t n = begin; n <= end; ++n) {
        std::array<std::int64_t, 3> sample{};
        sample[of.along] = of.begin + of.stride * n;
        sample[of.first] = static_cast<std::int64_t>(x) + of.first_slope * n;
        sample[of.second] = static_cast<std::int64_t>(y) + of.second_slope * n;
        bool is_in = true;
        for (std::size_t axis = 0; axis < 3; ++axis)
            is_in = is_in && sample[axis] >= 0 && sample[axis] < box_.size[axis];
        if (is_in)
            visit(Place{static_cast<std::int32_t>(sample[0]), static_cast<std::int32_t>(sample[1]),
                        static_cast<std::int32_t>(sample[2])},
                  of.step, is_sure);
    }
}

}  // namespace clsdf::segments
