#include "benchmarks/truth.hpp"

#include <clsdf/reference.hpp>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace clsdf::bench {

namespace {

constexpr double tolerance_voxels = 1e-5;
constexpr double tolerance_ulp = 2;
constexpr double sign_margin_voxels = 1e-6;

bool is_inside(const reference::Oracle& oracle, SignRule sign, const Vec3& position) {
    if (sign == SignRule::nonzero) return oracle.winding_number(position).value_or(0) != 0;
    if (sign == SignRule::parity) return oracle.crossings(position).value_or(0) % 2 != 0;
    return false;
}

double ulp_of(float value) {
    const float magnitude = std::abs(value);
    return static_cast<double>(std::nextafter(magnitude, INFINITY)) - static_cast<double>(magnitude);
}

}  // namespace

void Judgement::take_worse(const Judgement& other) {
    samples = std::max(samples, other.samples);
    wrong_signs = std::max(wrong_signs, other.wrong_signs);
    missed = std::max(missed, other.missed);
    leaked = std::max(leaked, other.leaked);
    wrong_values = std::max(wrong_values, other.wrong_values);
    max_error_voxels = std::max(max_error_voxels, other.max_error_voxels);
    mean_error_voxels = std::max(mean_error_voxels, other.mean_error_voxels);
}

std::vector<Truth::Sample> Truth::choose(const Workload& workload, std::size_t samples, std::uint64_t seed) {
    const SampleList& list = workload.list;
    const std::size_t count = workload.grid.sample_count();
    std::vector<Sample> chosen;
    if (samples == 0 || samples >= count) {
        chosen.resize(count);
        for (std::size_t offset = 0; offset < count; ++offset) chosen[offset].offset = offset;
        for (std::size_t brick = 0; brick < list.bricks(); ++brick)
            for (std::size_t n = list.starts[brick]; n < list.starts[brick + 1]; ++n)
                chosen[list.samples[n]].brick = brick;
        return chosen;
    }
    std::mt19937_64 random(seed);
    const auto below = [&](std::size_t limit) {
        return std::uniform_int_distribution<std::size_t>(0, limit - 1)(random);
    };
    const std::size_t common_bricks = (list.bricks() + largest_stride - 1) / largest_stride;
    while (common_bricks > 0 && chosen.size() < samples / 2) {
        Sample sample;
        sample.brick = below(common_bricks) * largest_stride;
        const std::size_t begin = list.starts[sample.brick];
        sample.offset = list.samples[begin + below(list.starts[sample.brick + 1] - begin)];
        chosen.push_back(sample);
    }
    while (chosen.size() < samples) {
        Sample sample;
        sample.offset = below(count);
        chosen.push_back(sample);
    }
    return chosen;
}

Truth::Truth(const Workload& workload, std::size_t samples, std::uint64_t seed)
    : samples_(choose(workload, samples, seed)),
      band_(workload.band),
      with_sign_(workload.sign != SignRule::none),
      voxel_(workload.grid.voxel()) {
    const reference::Oracle oracle(workload.mesh);
    const auto nx = static_cast<std::size_t>(workload.grid.size[0]),
               ny = static_cast<std::size_t>(workload.grid.size[1]);
    tbb::parallel_for(std::size_t{0}, samples_.size(), [&](std::size_t n) {
        Sample& sample = samples_[n];
        const Vec3 position = workload.grid.position(static_cast<std::int64_t>(sample.offset % nx),
                                                     static_cast<std::int64_t>(sample.offset / nx % ny),
                                                     static_cast<std::int64_t>(sample.offset / (nx * ny)));
        sample.distance = oracle.nearest(position).distance;
        sample.inside = is_inside(oracle, workload.sign, position);
    });
}

Judgement Truth::judge(std::span<const float> distance, bool takes_list, std::size_t stride) const {
    Judgement judgement;
    std::size_t in_band = 0;
    for (const Sample& sample : samples_) {
        if (takes_list && (sample.brick == not_listed || sample.brick % stride != 0)) continue;
        ++judgement.samples;
        const float found = distance[sample.offset];
        const double magnitude = std::abs(static_cast<double>(found));
        const double limit = sample.inside ? band_.inside : band_.outside;
        const double margin = std::max(tolerance_voxels * voxel_, tolerance_ulp * ulp_of(found));
        const bool carries_fill = magnitude >= limit * (1 - 1e-6) && std::isfinite(limit);
        if (!std::isfinite(found)) {
            ++judgement.missed;
            continue;
        }
        if (with_sign_ && sample.distance > sign_margin_voxels * voxel_ && std::signbit(found) != sample.inside)
            ++judgement.wrong_signs;
        if (sample.distance > limit) {
            if (!carries_fill && sample.distance > limit + margin) ++judgement.leaked;
        } else if (carries_fill) {
            if (sample.distance < limit * (1 - 1e-6) - margin) ++judgement.missed;
        } else {
            const double error = std::abs(magnitude - sample.distance);
            judgement.max_error_voxels = std::max(judgement.max_error_voxels, error / voxel_);
            judgement.mean_error_voxels += error / voxel_;
            ++in_band;
            if (error > margin) ++judgement.wrong_values;
        }
    }
    judgement.mean_error_voxels /= static_cast<double>(std::max<std::size_t>(in_band, 1));
    return judgement;
}

}  // namespace clsdf::bench
