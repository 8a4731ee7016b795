#include "sign/turns_of_lanes.hpp"

#include "core/parallel.hpp"

#include <cmath>

namespace clsdf::engine {

namespace {

/// In a namespace without a name: compilers export the function that chooses a target, whatever the visibility.
CLSDF_SEVERAL_TARGETS void add_turns(const LatticeCorner* corners, std::size_t count, const RowPlace& place,
                                     TurnsOfLanes& turns) {
    struct Seen {
        std::array<double, lanes> cr, ci, qy, qz;
    };
    Seen first{}, from{}, to{};
    for (std::size_t i = 0; i <= count; ++i) {
        if (i == count) {
            to = first;
        } else {
            const LatticeCorner& corner = corners[i];
            const double across_y = static_cast<double>(corner.snapped.y - place.y) * place.per_y,
                         across_z = static_cast<double>(corner.snapped.z - place.z) * place.per_z;
            const double y = (across_y + corner.rest_y) * place.spacing[1],
                         z = (across_z + corner.rest_z) * place.spacing[2];
            const Phase phase = phase_of(across_y * place.spacing[1], across_z * place.spacing[2]);
            const double behind_cr = y * phase.y + z * phase.z, behind_ci = y * phase.z - z * phase.y;
            const double squared = y * y + z * z;
            for (std::size_t l = 0; l < lanes; ++l) {
                const double x = (corner.snapped.x - (place.x + static_cast<double>(l))) * place.spacing[0];
                const double length = std::sqrt(x * x + squared), d = length - x;
                const bool is_ahead = x >= 0;
                to.cr[l] = is_ahead ? length + x : behind_cr;
                to.ci[l] = is_ahead ? 0.0 : behind_ci;
                to.qy[l] = is_ahead ? y : d * phase.y;
                to.qz[l] = is_ahead ? z : d * phase.z;
            }
        }
        if (i == 0) {
            first = from = to;
            continue;
        }
        std::array<double, lanes> re, im;
        bool may_turn = false;
        for (std::size_t l = 0; l < lanes; ++l) {
            re[l] = (from.cr[l] * to.cr[l] + from.ci[l] * to.ci[l]) + (from.qy[l] * to.qy[l] + from.qz[l] * to.qz[l]);
            im[l] = (from.cr[l] * to.ci[l] - from.ci[l] * to.cr[l]) + (from.qy[l] * to.qz[l] - from.qz[l] * to.qy[l]);
        }
        for (std::size_t l = 0; l < lanes; ++l) may_turn = may_turn || re[l] < 0;
        const double side =
            may_turn ? side_of(corners[i - 1].snapped, corners[i == count ? 0 : i].snapped, place.y, place.z) : 0;
        for (std::size_t l = 0; l < lanes; ++l) {
            const bool is_none = re[l] == 0 && im[l] == 0, is_back = re[l] < 0;
            const double a = is_none ? 1.0 : is_back ? -re[l] : re[l], b = is_back ? -im[l] : im[l];
            const double pr = turns.re[l] * a - turns.im[l] * b, pi = turns.re[l] * b + turns.im[l] * a;
            const bool is_over = pr < 0;
            turns.halves[l] += (is_back ? side : 0.0) + (is_over ? (b > 0 ? 1.0 : -1.0) : 0.0);
            const double qr = is_over ? -pr : pr, qi = is_over ? -pi : pi, size = qr + std::fabs(qi);
            const double factor = size > 0x1p200 ? 0x1p-400 : size < 0x1p-200 ? 0x1p400 : 1.0;
            turns.re[l] = qr * factor;
            turns.im[l] = qi * factor;
        }
        from = to;
    }
}

}  // namespace

void add_loop(const LatticeCorner* corners, std::size_t count, const RowPlace& place, TurnsOfLanes& turns) {
    add_turns(corners, count, place, turns);
}

}  // namespace clsdf::engine
