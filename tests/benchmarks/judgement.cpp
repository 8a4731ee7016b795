#include "small_workload.hpp"

#include <boost/test/unit_test.hpp>

#include <cmath>
#include <functional>
#include <limits>

using namespace clsdf;
using namespace clsdf::bench;
using clsdf::test::small_workload;

namespace {

/// Ours, with something done to what it computed.
class Spoilt : public Method {
public:
    using Spoil = std::function<void(const Workload&, std::span<float>)>;
    explicit Spoilt(Spoil spoil) : spoil_(std::move(spoil)) {}

    std::string name() const override { return "spoilt"; }
    std::string note() const override { return "wrong on purpose"; }

    Cost compute(const Workload& workload, std::span<float> distance, std::size_t) override {
        DistanceTransform(Device::strongest(), workload.mesh).compute(workload.grid, workload.band, distance);
        spoil_(workload, distance);
        return {};
    }

private:
    Spoil spoil_;
};

/// Judged at every sample of the grid.
Judgement judgement_of(const Spoilt::Spoil& spoil, const Workload& workload) {
    Spoilt method(spoil);
    return test::measure(workload, method).judgement;
}

std::size_t some_band_sample(const Workload& workload) {
    return workload.list.samples[workload.list.samples.size() / 3];
}

std::size_t some_sample_beyond(std::span<float> distance, const Workload& workload) {
    for (std::size_t n = 0; n < distance.size(); ++n)
        if (distance[n] == static_cast<float>(workload.band.outside)) return n;
    BOOST_FAIL("no sample lies beyond the band");
    return 0;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(judgement)

BOOST_AUTO_TEST_CASE(a_field_that_is_right_is_called_exact_and_every_sample_was_looked_at) {
    const Workload workload = small_workload();
    const Judgement found = judgement_of([](const Workload&, std::span<float>) {}, workload);
    BOOST_TEST(found.exact());
    BOOST_TEST(found.samples == workload.grid.sample_count());
    BOOST_TEST(found.max_error_voxels < 1e-5);
    BOOST_TEST(found.max_error_voxels > 0);
}

BOOST_AUTO_TEST_CASE(one_sample_that_is_off_by_a_thousandth_of_a_voxel_is_reported) {
    const Judgement found = judgement_of(
        [](const Workload& workload, std::span<float> distance) {
            distance[some_band_sample(workload)] += static_cast<float>(1e-3 * workload.grid.voxel());
        },
        small_workload());
    BOOST_TEST(!found.exact());
    BOOST_TEST(found.wrong_values == 1U);
    BOOST_TEST(found.max_error_voxels > 0.9e-3);
    BOOST_TEST(found.max_error_voxels < 1.1e-3);
    BOOST_TEST(found.wrong_signs + found.missed + found.leaked == 0U);
}

BOOST_AUTO_TEST_CASE(one_sign_that_is_wrong_is_reported_in_the_band_and_beyond_it) {
    const Workload workload = small_workload();
    const Judgement within = judgement_of(
        [](const Workload& w, std::span<float> distance) {
            const std::size_t sample = some_band_sample(w);
            distance[sample] = -distance[sample];
        },
        workload);
    BOOST_TEST(within.wrong_signs == 1U);
    BOOST_TEST(within.wrong_values + within.missed + within.leaked == 0U);
    const Judgement beyond = judgement_of(
        [](const Workload& w, std::span<float> distance) {
            const std::size_t sample = some_sample_beyond(distance, w);
            distance[sample] = -distance[sample];
        },
        workload);
    BOOST_TEST(beyond.wrong_signs == 1U);
    BOOST_TEST(beyond.wrong_values + beyond.missed + beyond.leaked == 0U);
}

BOOST_AUTO_TEST_CASE(samples_left_alone_or_left_at_the_bands_limit_are_reported_as_missed) {
    const Workload workload = small_workload();
    const Judgement unset = judgement_of(
        [](const Workload& w, std::span<float> distance) {
            distance[some_band_sample(w)] = std::numeric_limits<float>::quiet_NaN();
        },
        workload);
    BOOST_TEST(unset.missed == 1U);
    const Judgement filled = judgement_of(
        [](const Workload& w, std::span<float> distance) {
            const std::size_t sample = some_band_sample(w);
            distance[sample] = std::copysign(static_cast<float>(w.band.outside), distance[sample]);
        },
        workload);
    BOOST_TEST(filled.missed == 1U);
    BOOST_TEST(filled.wrong_signs + filled.leaked == 0U);
}

BOOST_AUTO_TEST_CASE(a_value_within_the_band_at_a_sample_beyond_it_is_reported_as_leaked) {
    const Judgement found = judgement_of(
        [](const Workload& w, std::span<float> distance) {
            distance[some_sample_beyond(distance, w)] = static_cast<float>(0.5 * w.band.outside);
        },
        small_workload());
    BOOST_TEST(found.leaked == 1U);
    BOOST_TEST(found.wrong_signs + found.missed + found.wrong_values == 0U);
}

BOOST_AUTO_TEST_CASE(a_method_that_is_right_in_its_first_call_only_is_reported) {
    int call = 0;
    const Judgement found = judgement_of(
        [&](const Workload& w, std::span<float> distance) {
            if (++call > 2) distance[some_band_sample(w)] *= 1.5F;
        },
        small_workload());
    BOOST_TEST(found.wrong_values + found.missed == 1U);
}

BOOST_AUTO_TEST_SUITE_END()
