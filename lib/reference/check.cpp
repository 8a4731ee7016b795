#include "core/outputs.hpp"
#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "judge.hpp"
#include "true_samples.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <span>
#include <thread>

namespace clsdf::reference {

namespace {

constexpr std::size_t kept_findings = 10;

/// The step from the float nearest to a distance to the next larger one.
double ulp(double distance) {
    const auto nearest = static_cast<float>(std::fabs(distance));
    if (!std::isfinite(nearest)) {
        return 0;
    }
    return static_cast<double>(std::nextafter(nearest, std::numeric_limits<float>::infinity())) -
           static_cast<double>(nearest);
}

}  // namespace

void Tally::append(const Tally& next) {
    report.samples += next.report.samples;
    report.band_samples += next.report.band_samples;
    report.wrong_values += next.report.wrong_values;
    report.wrong_signs += next.report.wrong_signs;
    report.missed += next.report.missed;
    report.leaked += next.report.leaked;
    for (std::size_t i = 0; i < report.wrong_outputs.size(); ++i) {
        report.wrong_outputs[i] += next.report.wrong_outputs[i];
    }
    report.max_error_voxels = std::max(report.max_error_voxels, next.report.max_error_voxels);
    report.max_error_ulp = std::max(report.max_error_ulp, next.report.max_error_ulp);
    squared_errors += next.squared_errors;
    for (const CheckReport::Finding& finding : next.report.findings) {
        if (report.findings.size() < kept_findings) {
            report.findings.push_back(finding);
        }
    }
}

CheckReport Tally::finish() const {
    CheckReport finished = report;
    if (report.band_samples > 0) {
        finished.rms_error_voxels = std::sqrt(squared_errors / static_cast<double>(report.band_samples));
    }
    return finished;
}

void Judge::Case::report(std::size_t& counter, std::string what, bool of_distance) const {
    ++counter;
    if (tally.report.findings.size() < kept_findings) {
        tally.report.findings.push_back({index, expected, static_cast<double>(found), std::move(what), of_distance});
    }
}

Judge::Judge(const TrueSamples& truth, const Field& field, const CheckOptions& options, std::uint32_t body)
    : truth_(truth),
      field_(field),
      options_(options),
      body_(body),
      voxel_(field.grid.voxel()),
      joined_margin_(truth.sign_surface().vertices.empty() ? 0 : 1e-12 * truth.tree().mesh().box().longest_side()) {
    if (!field.site().empty() || !field.gradient().empty()) {
        sites_.emplace(truth.tree().mesh(), truth.sign_surface());
    }
}

double Judge::tolerance(double distance) const {
    return std::max(options_.tolerance_voxels * voxel_, options_.tolerance_ulp * ulp(distance));
}

float Judge::fill(bool inside) const {
    return static_cast<float>(truth_.is_signed() && inside ? field_.band.inside_value() : field_.band.outside);
}

void Judge::judge(const Index3& index, const TrueSample& truth, Tally& tally) const {
    const bool in_doubt =
        truth.on_surface || truth.in_doubt ||
        truth.distance <= std::max({options_.sign_margin_voxels * voxel_, truth.rounding, joined_margin_});
    const double limit = half_width(field_.band, truth_.is_signed(), truth.inside);
    const bool in_band = truth.distance <= limit;
    const bool at_limit = std::isfinite(limit) && std::fabs(truth.distance - limit) <= tolerance(limit);
    const std::size_t offset = field_.grid.offset(index[0], index[1], index[2]);
    const Case sample{index,
                      truth,
                      offset,
                      field_.distance()[offset],
                      in_band ? truth.signed_distance() : static_cast<double>(fill(truth.inside)),
                      at_limit ? Case::Place::at_limit : (in_band ? Case::Place::in_band : Case::Place::beyond),
                      !in_doubt,
                      tally};

    ++tally.report.samples;
    tally.report.band_samples += in_band ? 1 : 0;
    judge_sign(sample);
    judge_distance(sample);
    judge_outputs(sample);
}

void Judge::judge_sign(const Case& sample) const {
    if (std::isnan(sample.found)) {
        return;  // NaN, which has been counted
    }
    const bool negative = std::signbit(sample.found);
    if (!truth_.is_signed()) {
        if (negative) {
            sample.report(sample.tally.report.wrong_signs, "negative in an unsigned field");
        }
    } else if (sample.sign_is_certain) {
        if (negative != sample.truth.inside) {
            sample.report(sample.tally.report.wrong_signs,
                          sample.truth.inside ? "inside, but not negative" : "outside, but negative");
        }
    } else if (negative && sample.found == 0 && sample.found != fill(true)) {
        sample.report(sample.tally.report.wrong_signs, "a zero distance written as -0");
    }
}

void Judge::judge_distance(const Case& sample) const {
    const double magnitude = std::fabs(static_cast<double>(sample.found));
    const double error = std::fabs(magnitude - sample.truth.distance);
    const double allowed = tolerance(sample.truth.distance);
    // The sign has been judged, so a sample with the wrong sign is compared with the fill value of that side. An
    // infinite half width has no fill value.
    const bool on_found_side = std::signbit(sample.found);
    const bool is_fill = std::isfinite(fill(on_found_side)) && sample.found == fill(on_found_side);

    const bool measured = sample.place == Case::Place::in_band || (sample.place == Case::Place::at_limit && !is_fill);
    if (sample.truth.distance <= half_width(field_.band, truth_.is_signed(), sample.truth.inside) && measured &&
        !std::isnan(error)) {
        sample.tally.report.max_error_voxels = std::max(sample.tally.report.max_error_voxels, error / voxel_);
        sample.tally.squared_errors += (error / voxel_) * (error / voxel_);
        if (sample.truth.distance > voxel_ && ulp(sample.truth.distance) > 0) {
            sample.tally.report.max_error_ulp =
                std::max(sample.tally.report.max_error_ulp, error / ulp(sample.truth.distance));
        }
    }

    switch (sample.place) {
        case Case::Place::in_band:
            if (error <= allowed) {
                return;
            }
            if (is_fill) {
                sample.report(sample.tally.report.missed, "in the band, but with the fill value");
            } else {
                sample.report(sample.tally.report.wrong_values, "in the band, with another distance");
            }
            return;
        case Case::Place::at_limit:
            if (!(error <= allowed) && !is_fill) {
                sample.report(sample.tally.report.wrong_values, "at the band's limit, with another distance");
            }
            return;
        case Case::Place::beyond:
            if (!is_fill) {
                sample.report(sample.tally.report.leaked, "beyond the band, but not with the fill value");
            }
            return;
    }
}

void require_sizes(const Field& field) {
    const std::size_t count = field.grid.sample_count();
    for (const OutputInfo& info : infos_of(field.outputs())) {
        const std::size_t bytes = field.bytes(info.output).size();
        if (bytes != count * info.sample_bytes()) {
            refuse("the field has {} values of {} but its grid has {} samples{}", bytes / bytes_of(info.type),
                   info.name, count, info.components > 1 ? fmt::format(" of {} values", info.components) : "");
        }
    }
}

std::vector<CheckReport> tally_parts(std::size_t count, std::size_t fields, const CheckOptions& options,
                                     const std::function<void(std::size_t, std::span<Tally>)>& part) {
    std::vector<Tally> tallies(count * fields);
    const auto tallies_of = [&](std::size_t index) { return std::span(tallies).subspan(index * fields, fields); };
    std::atomic<std::size_t> done = 0;
    const std::thread::id caller = std::this_thread::get_id();
    for_each_index(
        count,
        [&](std::size_t index) {
            const bool is_caller = std::this_thread::get_id() == caller;
            if (is_caller && options.should_stop && options.should_stop())
                throw Error(ErrorCode::cancelled, "the check was cancelled");
            part(index, tallies_of(index));
            const std::size_t parts = ++done;
            if (is_caller && options.progress && parts < count)
                options.progress(static_cast<double>(parts) / static_cast<double>(count));
        },
        1);
    if (options.progress) options.progress(1);
    std::vector<CheckReport> reports;
    for (std::size_t field = 0; field < fields; ++field) {
        Tally total;
        for (std::size_t index = 0; index < count; ++index) {
            total.append(tallies_of(index)[field]);
        }
        reports.push_back(total.finish());
    }
    return reports;
}

double reach_of(const Field& field, bool is_signed, const CheckOptions& options) {
    // Large enough that a sample without a result is beyond the band's limit and its tolerance.
    return widest(field.band, is_signed) * (1 + 1e-6 + 1e-6 * options.tolerance_ulp) +
           (1 + options.tolerance_voxels + options.sign_margin_voxels) * field.grid.voxel();
}

namespace {

/// Judges one sample of every field.
void judge_all(std::span<const Judge> judges, const Index3& index, const TrueSample& sample, std::span<Tally> tallies) {
    for (std::size_t field = 0; field < judges.size(); ++field) {
        judges[field].judge(index, sample, tallies[field]);
    }
}

std::vector<CheckReport> check_every_sample(const TrueSamples& truth, std::span<const Judge> judges, const Grid& grid,
                                            const CheckOptions& options) {
    const auto rows = static_cast<std::size_t>(grid.size[1]) * static_cast<std::size_t>(grid.size[2]);
    constexpr std::size_t rows_per_part = 16;
    const std::size_t parts = (rows + rows_per_part - 1) / rows_per_part;
    return tally_parts(parts, judges.size(), options, [&](std::size_t part, std::span<Tally> tallies) {
        std::vector<TrueSample> samples;
        for (std::size_t row = part * rows_per_part; row < std::min(rows, (part + 1) * rows_per_part); ++row) {
            const std::int64_t j = static_cast<std::int64_t>(row) % grid.size[1];
            const std::int64_t k = static_cast<std::int64_t>(row) / grid.size[1];
            truth.row(j, k, samples);
            for (std::size_t i = 0; i < samples.size(); ++i) {
                judge_all(judges, {static_cast<std::int64_t>(i), j, k}, samples[i], tallies);
            }
        }
    });
}

std::vector<CheckReport> check_some_samples(const TrueSamples& truth, std::span<const Judge> judges,
                                            const std::vector<Index3>& chosen, const CheckOptions& options) {
    constexpr std::size_t samples_per_part = 64;
    const std::size_t parts = (chosen.size() + samples_per_part - 1) / samples_per_part;
    return tally_parts(parts, judges.size(), options, [&](std::size_t part, std::span<Tally> tallies) {
        const std::size_t end = std::min(chosen.size(), (part + 1) * samples_per_part);
        for (std::size_t i = part * samples_per_part; i < end; ++i) {
            judge_all(judges, chosen[i], truth.at(chosen[i]), tallies);
        }
    });
}

/// Throws if the fields are not of one problem, or if an array of one does not fit its grid.
void require_one_problem(std::span<const Field> fields) {
    if (fields.empty()) {
        refuse("there is no field to check");
    }
    const Field& first = fields.front();
    first.band.validate();
    first.grid.validate();
    for (const Field& field : fields) {
        if (field.grid != first.grid || field.band != first.band || field.sign != first.sign ||
            field.floor != first.floor) {
            refuse("the fields to check have different grids, bands or sign rules: check them one by one");
        }
        require_sizes(field);
    }
}

}  // namespace

std::vector<CheckReport> check(const Mesh& mesh, std::span<const Field> fields, const CheckOptions& options) {
    require_one_problem(fields);
    if (std::ranges::any_of(fields, [](const Field& field) { return field.positive_inside; })) {
        std::vector<Field> negative(fields.begin(), fields.end());
        for (Field& field : negative)
            if (field.positive_inside) field.negate();
        return check(mesh, negative, options);
    }
    const Field& first = fields.front();
    const std::size_t count = first.grid.sample_count();

    const TrueSamples truth(mesh, first.grid, first.sign, first.floor,
                            reach_of(first, first.sign != SignRule::none, options));
    std::vector<Judge> judges;
    judges.reserve(fields.size());
    for (const Field& field : fields) {
        judges.emplace_back(truth, field, options);
    }
    if (options.samples == 0 || options.samples >= count) {
        return check_every_sample(truth, judges, first.grid, options);
    }
    const std::vector<Index3> chosen = choose_samples(truth, first, options.samples, options.seed);
    return check_some_samples(truth, judges, chosen, options);
}

CheckReport check(const Mesh& mesh, const Field& field, const CheckOptions& options) {
    return check(mesh, std::span(&field, 1), options).front();
}

}  // namespace clsdf::reference
