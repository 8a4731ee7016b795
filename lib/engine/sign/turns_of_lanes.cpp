#include "sign/turns_of_lanes.hpp"

#include "core/parallel.hpp"

#include <cmath>

namespace clsdf::engine {

namespace {

/// In a namespace without a name: compilers export the function that chooses a target, whatever the visibility.
using Vector [[gnu::vector_size(lanes * sizeof(double))]] = double;

CLSDF_SEVERAL_TARGETS void add_turns(const LatticeCorner* corners, std::size_t count, const PlanePlace& place,
                                     TurnsOfRows& turns_of_rows) {
    struct Seen {
        Vector cr, ci, qy, qz;
    };
    struct Row {
        Seen first, from;
        Vector re, im, halves;
    };
    const Vector zero{}, one = zero + 1;
    std::array<Row, lanes> rows{};
    Vector offsets;
    for (std::size_t l = 0; l < lanes; ++l) offsets[l] = place.x + static_cast<double>(l);
    for (std::size_t n = 0; n < lanes; ++n)
        for (std::size_t l = 0; l < lanes; ++l) {
            rows[n].re[l] = turns_of_rows[n].re[l];
            rows[n].im[l] = turns_of_rows[n].im[l];
            rows[n].halves[l] = turns_of_rows[n].halves[l];
        }
    for (std::size_t i = 0; i <= count; ++i) {
        const std::size_t next = i == count ? 0 : i;
        const LatticeCorner& corner = corners[next];
        const double across_z = static_cast<double>(corner.snapped.z - place.z) * place.per_z,
                     z = (across_z + corner.rest_z) * place.spacing[2];
        const Vector x = (corner.snapped.x - offsets) * place.spacing[0];
        // Rows do not depend on each other, so that the processor works on several of them at once.
        for (std::size_t n = 0; n < lanes; ++n) {
            Row& row = rows[n];
            const std::int64_t row_y = place.y + static_cast<std::int64_t>(n) * place.next_y;
            Seen to;
            if (i == count) {
                to = row.first;
            } else {
                const double across_y = static_cast<double>(corner.snapped.y - row_y) * place.per_y,
                             y = (across_y + corner.rest_y) * place.spacing[1];
                const Phase phase = phase_of(across_y * place.spacing[1], across_z * place.spacing[2]);
                const Vector square = x * x + (y * y + z * z);
                Vector length;
                for (std::size_t l = 0; l < lanes; ++l) length[l] = std::sqrt(square[l]);
                const Vector d = length - x;
                const auto is_ahead = x >= zero;
                to.cr = is_ahead ? length + x : zero + (y * phase.y + z * phase.z);
                to.ci = is_ahead ? zero : zero + (y * phase.z - z * phase.y);
                to.qy = is_ahead ? zero + y : d * phase.y;
                to.qz = is_ahead ? zero + z : d * phase.z;
            }
            if (i == 0) {
                row.first = row.from = to;
                continue;
            }
            const Seen& last = row.from;
            const Vector re = (last.cr * to.cr + last.ci * to.ci) + (last.qy * to.qy + last.qz * to.qz),
                         im = (last.cr * to.ci - last.ci * to.cr) + (last.qy * to.qz - last.qz * to.qy);
            const auto is_back = re < zero;
            bool may_turn = false;
            for (std::size_t l = 0; l < lanes; ++l) may_turn = may_turn || is_back[l] != 0;
            Vector a = re, b = im;
            if (may_turn) {
                const Vector side = zero + side_of(corners[i - 1].snapped, corner.snapped, row_y, place.z);
                row.halves += is_back ? side : zero;
                a = is_back ? -re : re;
                b = is_back ? -im : im;
            }
            const auto is_none = (re == zero) & (im == zero);
            a = is_none ? one : a;
            const Vector pr = row.re * a - row.im * b, pi = row.re * b + row.im * a;
            const auto is_over = pr < zero;
            row.halves += is_over ? (b > zero ? one : -one) : zero;
            const Vector qr = is_over ? -pr : pr, qi = is_over ? -pi : pi, size = qr + (qi < zero ? -qi : qi);
            const Vector factor = size > 0x1p200 ? one * 0x1p-400 : size < 0x1p-200 ? one * 0x1p400 : one;
            row.re = qr * factor;
            row.im = qi * factor;
            row.from = to;
        }
    }
    for (std::size_t n = 0; n < lanes; ++n)
        for (std::size_t l = 0; l < lanes; ++l) {
            turns_of_rows[n].re[l] = rows[n].re[l];
            turns_of_rows[n].im[l] = rows[n].im[l];
            turns_of_rows[n].halves[l] = rows[n].halves[l];
        }
}

CLSDF_SEVERAL_TARGETS void add_far(const FarPiece* pieces, std::size_t count, const Vec3& first, const Vec3& spacing,
                                   FarTurns& turns) {
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3& centre = pieces[i].centre;
        const Vec3 r{centre[0] - first[0], centre[1] - first[1], centre[2] - first[2]};
        std::array<double, lanes> y;
        for (std::size_t n = 0; n < lanes; ++n) y[n] = r[1] - static_cast<double>(n) * spacing[1];
        const FarTurns one = pieces[i].expansion->at<lanes, lanes>(r, y, spacing[0]);
        for (std::size_t n = 0; n < lanes; ++n)
            for (std::size_t l = 0; l < lanes; ++l) turns[n][l] += one[n][l];
    }
}

}  // namespace

void add_loop(std::span<const LatticeCorner> corners, const PlanePlace& place, TurnsOfRows& turns) {
    add_turns(corners.data(), corners.size(), place, turns);
}

FarTurns turns_of_expansions(std::span<const FarPiece> pieces, const Vec3& first, const Vec3& spacing) {
    FarTurns turns{};
    add_far(pieces.data(), pieces.size(), first, spacing, turns);
    return turns;
}

}  // namespace clsdf::engine
