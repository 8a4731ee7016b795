#include "judge.hpp"
#include "true_samples.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <mutex>

namespace clsdf::reference {

namespace {

/// Throws if an array of the field does not fit its grid.
void require_sizes(const Field& field) {
    const std::size_t count = field.grid.sample_count();
    const auto require = [&](const char* name, const auto& values, std::size_t bytes) {
        const std::size_t components = bytes / sizeof(values[0]);
        if (values.size() != count * components) {
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("the field has {} values of {} but its grid has {} samples{}", values.size(), name,
                                    count, components > 1 ? fmt::format(" of {} values", components) : ""));
        }
    };
    require("distance", field.distance, output_bytes.distance);
    visit_extras(
        [&](const char* name, const auto& values, std::size_t bytes) {
            if (!values.empty()) {
                require(name, values, bytes);
            }
        },
        field, output_bytes);
}

/// Runs `part(index, tally)` for all parts on all cores and adds the tallies in the order of the parts, so the result
/// does not depend on the number of threads.
template <typename Part>
CheckReport tally_parts(std::size_t count, const CheckOptions& options, const Part& part) {
    std::vector<Tally> tallies(count);
    std::mutex mutex;
    std::size_t done = 0;
    oneapi::tbb::parallel_for(std::size_t{0}, count, [&](std::size_t index) {
        if (options.should_stop && options.should_stop()) {
            throw Error(ErrorCode::cancelled, "the check was cancelled");
        }
        part(index, tallies[index]);
        if (options.progress) {
            const std::lock_guard lock(mutex);
            options.progress(static_cast<double>(++done) / static_cast<double>(count));
        }
    });
    Tally total;
    for (const Tally& tally : tallies) {
        total.append(tally);
    }
    return total.finish();
}

CheckReport check_every_sample(const TrueSamples& truth, const Judge& judge, const Grid& grid,
                               const CheckOptions& options) {
    const auto rows = static_cast<std::size_t>(grid.size[1]) * static_cast<std::size_t>(grid.size[2]);
    constexpr std::size_t rows_per_part = 16;
    return tally_parts((rows + rows_per_part - 1) / rows_per_part, options, [&](std::size_t part, Tally& tally) {
        std::vector<TrueSample> samples;
        for (std::size_t row = part * rows_per_part; row < std::min(rows, (part + 1) * rows_per_part); ++row) {
            const std::int64_t j = static_cast<std::int64_t>(row) % grid.size[1];
            const std::int64_t k = static_cast<std::int64_t>(row) / grid.size[1];
            truth.row(j, k, samples);
            for (std::size_t i = 0; i < samples.size(); ++i) {
                judge.judge({static_cast<std::int64_t>(i), j, k}, samples[i], tally);
            }
        }
    });
}

CheckReport check_some_samples(const TrueSamples& truth, const Judge& judge, const std::vector<Index3>& chosen,
                               const CheckOptions& options) {
    constexpr std::size_t samples_per_part = 64;
    const std::size_t parts = (chosen.size() + samples_per_part - 1) / samples_per_part;
    return tally_parts(parts, options, [&](std::size_t part, Tally& tally) {
        const std::size_t end = std::min(chosen.size(), (part + 1) * samples_per_part);
        for (std::size_t i = part * samples_per_part; i < end; ++i) {
            judge.judge(chosen[i], truth.at(chosen[i]), tally);
        }
    });
}

}  // namespace

CheckReport check(const Mesh& mesh, const Field& field, const CheckOptions& options) {
    field.band.validate();
    field.grid.validate();
    const std::size_t count = field.grid.sample_count();
    require_sizes(field);

    // Large enough that a sample without a result is beyond the band's limit and its tolerance.
    const double widest_half = widest(field.band, field.sign != SignRule::none);
    const double reach = widest_half * (1 + 1e-6 + 1e-6 * options.tolerance_ulp) +
                         (1 + options.tolerance_voxels + options.sign_margin_voxels) * field.grid.voxel();
    const TrueSamples truth(mesh, field.grid, field.sign, reach);
    const Judge judge(truth, field, options);
    if (options.samples == 0 || options.samples >= count) {
        return check_every_sample(truth, judge, field.grid, options);
    }
    const std::vector<Index3> chosen = choose_samples(truth, field, options.samples, options.seed);
    return check_some_samples(truth, judge, chosen, options);
}

}  // namespace clsdf::reference
