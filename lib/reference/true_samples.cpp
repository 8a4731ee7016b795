#include "true_samples.hpp"

#include <clsdf/topology.hpp>

#include <algorithm>

namespace clsdf::reference {

TrueSamples::TrueSamples(const Mesh& mesh, const Grid& grid, SignRule sign, double reach)
    : grid_(grid),
      sign_(resolve_sign_rule(sign, describe_topology(mesh)).rule),
      reach_(reach),
      tree_(mesh),
      rays_(tree_) {
    grid_.validate();
}

void TrueSamples::measure(const ExactPosition& position, double bound, TrueSample& sample) const {
    std::optional<Nearest> nearest = tree_.nearest(position, bound);
    if (!nearest && bound < reach_) {
        nearest = tree_.nearest(position, reach_);  // the hint was less than the rounding of a far distance
    }
    sample.distance = nearest ? nearest->distance : std::numeric_limits<double>::infinity();
    sample.triangle = nearest ? nearest->triangle : no_triangle;
    if (nearest) {
        sample.site = nearest->site;
        sample.point = nearest->point;
    }
    sample.rounding = 2 * position.rounding();
}

void TrueSamples::take_sign(const std::optional<RayCount>& count, TrueSample& sample) const {
    sample.on_surface = !count;
    sample.inside = count && (sign_ == SignRule::nonzero ? count->winding != 0 : count->crossings % 2 != 0);
}

TrueSample TrueSamples::at(const Index3& index) const {
    const ExactPosition position = exact_position(grid_, index);
    TrueSample sample;
    measure(position, reach_, sample);
    if (is_signed()) {
        const Vec3& point = position.head;
        take_sign(rays_.count_along_row({point.data(), 1}, point[1], point[2]).front(), sample);
    }
    return sample;
}

void TrueSamples::row(std::int64_t j, std::int64_t k, std::vector<TrueSample>& samples) const {
    samples.assign(static_cast<std::size_t>(grid_.size[0]), {});
    std::vector<double> x(samples.size());
    ExactPosition position;
    // The distance cannot change by more than the step from one sample to the next.
    double bound = reach_;
    const double step = 1.001 * grid_.spacing[0];
    for (std::size_t i = 0; i < samples.size(); ++i) {
        position = exact_position(grid_, {static_cast<std::int64_t>(i), j, k});
        x[i] = position.head[0];
        measure(position, bound, samples[i]);
        bound = std::min(reach_, samples[i].distance + step + 2 * samples[i].rounding);
    }
    if (is_signed()) {
        const auto counts = rays_.count_along_row(x, position.head[1], position.head[2]);
        for (std::size_t i = 0; i < samples.size(); ++i) {
            take_sign(counts[i], samples[i]);
        }
    }
}

}  // namespace clsdf::reference
