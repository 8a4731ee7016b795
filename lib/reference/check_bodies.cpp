#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "judge.hpp"
#include "true_samples.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <list>
#include <numeric>
#include <vector>

namespace clsdf::reference {

namespace {

/// A body's truth, and who judges samples whose least distance is that of the body.
struct JudgedBody {
    JudgedBody(const PlacedBody& body, std::uint32_t number, const Field& field, const CheckOptions& options)
        : box(body.mesh.box()),
          reach(reach_of(field, true, options)),
          truth(body.mesh, field.grid, body.sign, {}, reach),
          judge(truth, field, options, number) {}

    /// Nothing if the body cannot be nearest, nor have the sample inside.
    std::optional<TrueSample> at(const Index3& index) const {
        // Points outside the box of an open mesh may be inside.
        if (truth.sign() == SignRule::solid_angle || is_near(truth.position(index).head)) return truth.at(index);
        return std::nullopt;
    }

    Box box;
    double reach;
    TrueSamples truth;
    Judge judge;

private:
    bool is_near(const Vec3& p) const {
        double squared = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double apart = std::max({box.lower[axis] - p[axis], p[axis] - box.upper[axis], 0.0});
            squared += apart * apart;
        }
        return squared <= reach * reach * (1 + 1e-9);
    }
};

/// Judges a sample by the body that has it: the nearest, or one that is as near within the tolerance.
void judge_sample(const std::list<JudgedBody>& bodies, const Index3& index, Tally& tally) {
    struct Candidate {
        const JudgedBody* body;
        TrueSample truth;
    };
    std::vector<Candidate> near;
    // The least value, if all bodies whose sign is in doubt do not have the sample inside.
    double least = std::numeric_limits<double>::infinity();
    for (const JudgedBody& body : bodies) {
        const auto truth = body.at(index);
        if (!truth) continue;
        near.push_back({&body, *truth});
        least = std::min(least, truth->in_doubt ? truth->distance : truth->signed_distance());
        if (!truth->in_doubt) continue;
        near.push_back({&body, *truth});
        near.back().truth.inside = !truth->inside;
    }
    if (near.empty()) {
        // Beyond the band of all.
        TrueSample far;
        far.distance = std::numeric_limits<double>::infinity();
        bodies.front().judge.judge(index, far, tally);
        return;
    }
    std::ranges::stable_sort(near, {}, [](const Candidate& c) { return c.truth.signed_distance(); });
    const double allowed = std::isfinite(least) ? near.front().body->judge.tolerance(std::fabs(least)) : 0;
    Tally first;
    for (std::size_t i = 0; i < near.size() && near[i].truth.signed_distance() <= least + allowed; ++i) {
        Tally of_body;
        near[i].body->judge.judge(index, near[i].truth, of_body);
        if (of_body.report.passed()) return tally.append(of_body);
        if (i == 0) first = of_body;
    }
    tally.append(first);
}

}  // namespace

CheckReport check(std::span<const PlacedBody> bodies, const Field& field, const CheckOptions& options) {
    if (bodies.empty()) refuse("there is no body to check the field against");
    if (field.positive_inside) {
        Field negative = field;
        negative.negate();
        return check(bodies, negative, options);
    }
    field.band.validate();
    field.grid.validate();
    require_sizes(field);
    std::list<JudgedBody> judged;  // each refers to its own truth
    for (std::size_t i = 0; i < bodies.size(); ++i)
        judged.emplace_back(bodies[i], static_cast<std::uint32_t>(i), field, options);

    const std::size_t count = field.grid.sample_count();
    const auto width = static_cast<std::size_t>(field.grid.size[0]),
               height = static_cast<std::size_t>(field.grid.size[1]);
    std::vector<Index3> chosen;
    const bool is_complete = options.samples == 0 || options.samples >= count;
    if (!is_complete) {
        // As many near each body.
        const std::size_t of_body = options.samples / bodies.size() + 1;
        std::uint64_t seed = options.seed;
        for (const JudgedBody& body : judged) {
            const std::vector<Index3> some = choose_samples(body.truth, field, of_body, seed++);
            chosen.insert(chosen.end(), some.begin(), some.end());
        }
    }
    constexpr std::size_t samples_per_part = 64;
    const std::size_t all = is_complete ? count : chosen.size();
    return tally_parts(chunk_count(all, samples_per_part), 1, options,
                       [&](std::size_t part, std::span<Tally> tallies) {
                           const std::size_t end = std::min(all, (part + 1) * samples_per_part);
                           for (std::size_t i = part * samples_per_part; i < end; ++i) {
                               const Index3 index = is_complete ? Index3{static_cast<std::int64_t>(i % width),
                                                                         static_cast<std::int64_t>(i / width % height),
                                                                         static_cast<std::int64_t>(i / width / height)}
                                                                : chosen[i];
                               judge_sample(judged, index, tallies[0]);
                           }
                       })
        .front();
}

}  // namespace clsdf::reference
