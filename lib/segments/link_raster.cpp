#include "segments/link_raster.hpp"

#include "core/parallel.hpp"

namespace clsdf::segments {

PairedDirections paired(std::span<const Place> directions) {
    PairedDirections paired;
    for (std::size_t direction = 0; direction < directions.size(); ++direction) {
        const Place& step = directions[direction];
        if (step == Place{}) continue;
        const auto opposite = std::ranges::find(paired.steps, Place{-step[0], -step[1], -step[2]});
        if (opposite != paired.steps.end()) {
            paired.pairs[static_cast<std::size_t>(opposite - paired.steps.begin())].backward = direction;
        } else {
            paired.steps.push_back(step);
            paired.pairs.push_back({direction});
        }
    }
    return paired;
}

LinkRaster::LinkRaster(const SampleBox& box, std::span<const Place> steps) : box_(box) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        origin_[axis] = box.grid.origin[axis] * box.scale;
        per_unit_[axis] = 1 / (box.grid.spacing[axis] * box.scale);
        first_[axis] = static_cast<double>(box.grid.first[axis]);
        far_ = std::max(far_, std::abs(first_[axis]) + static_cast<double>(box.size[axis]));
    }
    for (std::size_t number = 0; number < steps.size(); ++number) {
        const Place& step = steps[number];
        // The axis on which the step is shortest: fewest lines side by side.
        std::size_t along = 3;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            slope_ = std::max(slope_, 1.0 + std::abs(step[axis]));
            if (step[axis] != 0 && (along == 3 || std::abs(step[axis]) < std::abs(step[along]))) along = axis;
        }
        const std::size_t first = (along + 1) % 3, second = (along + 2) % 3;
        const std::int64_t stride = step[along];
        for (std::int64_t residue = 0; residue < std::abs(stride); ++residue) {
            const std::int64_t last = box.size[along] - 1;
            if (residue > last) continue;
            // Samples residue, residue + |stride| and so on, in the order of the steps.
            const std::int64_t count = (last - residue) / std::abs(stride);
            const std::int64_t begin = stride > 0 ? residue : residue + count * -stride;
            if (batches_.empty() || batches_.back().steps.size() == lanes) batches_.emplace_back();
            Batch& batch = batches_.back();
            const std::size_t lane = batch.steps.size();
            batch.steps.push_back({number, along, first, second, begin, stride, step[first], step[second]});
            const auto of_stride = static_cast<double>(stride), from = static_cast<double>(begin);
            batch.k_of[along][lane] = 1 / of_stride;
            batch.k_from[lane] = -from / of_stride;
            batch.most_k[lane] = static_cast<double>(count);
            const auto across = [&](std::size_t axis, std::array<Lanes<double>, 3>& of, Lanes<double>& start,
                                    Lanes<double>& least, Lanes<double>& most) {
                const double slope = step[axis];
                of[axis][lane] = 1;
                of[along][lane] = -slope / of_stride;
                start[lane] = slope * from / of_stride;
                const double far = slope * static_cast<double>(count);
                least[lane] = std::min(0.0, -far);
                most[lane] = static_cast<double>(box.size[axis] - 1) + std::max(0.0, -far);
            };
            across(first, batch.u_of, batch.u_from, batch.least_u, batch.most_u);
            across(second, batch.v_of, batch.v_from, batch.least_v, batch.most_v);
        }
    }
}

void LinkRaster::describe(const PairedDirections& paired, LinkLattice& lattice, std::vector<LinkLine>& lines) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        lattice.origin[axis] = origin_[axis];
        lattice.per_unit[axis] = per_unit_[axis];
    }
    lattice.far = far_;
    lattice.slope = slope_;
    lattice.rounding = box_.rounding;
    const auto number_of = [](std::size_t direction) {
        return direction == DirectionPair::not_asked ? CLSDF_NO_DIRECTION : static_cast<clsdf_uint32>(direction);
    };
    for (const Batch& batch : batches_)
        for (std::size_t lane = 0; lane < batch.steps.size(); ++lane) {
            const Batch::Lane& of = batch.steps[lane];
            const Place& step = paired.steps[of.step];
            const DirectionPair& pair = paired.pairs[of.step];
            lines.push_back({{step[0], step[1], step[2]},
                             static_cast<clsdf_int32>(of.along),
                             static_cast<clsdf_int32>(of.first),
                             static_cast<clsdf_int32>(of.second),
                             static_cast<clsdf_int32>(of.begin),
                             static_cast<clsdf_int32>(batch.most_k[lane]),
                             number_of(pair.forward),
                             number_of(pair.backward)});
        }
}

namespace {

CLSDF_SEVERAL_TARGETS void see_by_vectors(const LineBatch& batch, const std::array<Vec3, 3>& at, double margin,
                                          SeenFace& seen) {
    constexpr std::size_t lanes = LineBatch::lanes;
    using Values = LineBatch::Lanes<double>;
    for (std::size_t i = 0; i < 3; ++i) {
        const double x = at[i][0], y = at[i][1], z = at[i][2];
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            seen.u[i][lane] =
                batch.u_from[lane] + batch.u_of[0][lane] * x + batch.u_of[1][lane] * y + batch.u_of[2][lane] * z;
            seen.v[i][lane] =
                batch.v_from[lane] + batch.v_of[0][lane] * x + batch.v_of[1][lane] * y + batch.v_of[2][lane] * z;
            seen.k[i][lane] =
                batch.k_from[lane] + batch.k_of[0][lane] * x + batch.k_of[1][lane] * y + batch.k_of[2][lane] * z;
        }
    }
    const auto range = [margin](const std::array<Values, 3>& of, const Values& least, const Values& most, Values& begin,
                                Values& end) {
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const double a = of[0][lane], b = of[1][lane], c = of[2][lane];
            const double low_of_two = a < b ? a : b, high_of_two = a < b ? b : a;
            const double low = std::ceil((low_of_two < c ? low_of_two : c) - margin),
                         high = std::floor((high_of_two < c ? c : high_of_two) + margin);
            begin[lane] = low < least[lane] ? least[lane] : low;
            end[lane] = high > most[lane] ? most[lane] : high;
        }
    };
    range(seen.u, batch.least_u, batch.most_u, seen.begin_u, seen.end_u);
    range(seen.v, batch.least_v, batch.most_v, seen.begin_v, seen.end_v);
}

}  // namespace

void LinkRaster::see(const Batch& batch, const std::array<Vec3, 3>& at, double margin, Seen& seen) {
    see_by_vectors(batch, at, margin, seen);
}

}  // namespace clsdf::segments
