// The known fields of the self-test are those of the reference.
#include "support/exact_field.hpp"

#include "checks/known_field.hpp"
#include "core/outputs.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>

using namespace clsdf;
using namespace clsdf::test;
using checks::KnownField;
using checks::KnownFieldKind;

namespace {

/// A field as packed arrays.
targets::HostArrays arrays_of(Field& field) {
    targets::HostArrays arrays;
    for (const OutputInfo& info : output_table()) {
        const std::span<std::byte> bytes = field.bytes(info.output);
        arrays[info.output] = {!bytes.empty(), info.type == ElementType::float64, bytes.data()};
    }
    return arrays;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(the_known_field)

BOOST_AUTO_TEST_CASE(is_the_reference_s_field) {
    for (const KnownFieldKind& kind :
         {KnownFieldKind{}, KnownFieldKind{.long_bricks = true}, KnownFieldKind{.wide = true},
          KnownFieldKind{.on_surface = true}, KnownFieldKind{.wide = true, .on_surface = true},
          KnownFieldKind{.long_bricks = true, .on_surface = true},
          KnownFieldKind{.wide = true, .many_at_vertex = true}}) {
        const KnownField known(kind);
        DistanceTransform transform(test_device(), known.mesh(), {.sign = SignRule::nonzero});
        TransformStatistics statistics;
        Field field = transform.compute(known.grid(), known.band(), all_outputs(), {}, &statistics);
        BOOST_TEST(check_exact(known.mesh(), field, guaranteed).band_samples > 500U);
        const std::optional<std::string> difference = known.difference(arrays_of(field));
        BOOST_TEST(!difference.has_value(), difference.value_or(""));
        // The purpose of the self-test: wrong compilers.
        BOOST_TEST(statistics.work->point_sites == 1U);
        BOOST_TEST(statistics.work->saddle_vertices > 0U);
        BOOST_TEST(statistics.work->coarse_bricks == 8U);
        const auto has = [&](const auto& is) { return std::ranges::any_of(field.distance(), is); };
        const auto sites_on_surface = [&](auto first, auto last) {
            std::size_t count = 0;
            for (std::size_t i = 0; i < field.distance().size(); ++i)
                count += std::abs(field.distance()[i]) < 1e-8F && first <= field.site()[i] && field.site()[i] <= last;
            return count;
        };
        BOOST_TEST((sites_on_surface(0, 6) > 0) == kind.on_surface);
        if (kind.wide) continue;
        BOOST_TEST(has([&](float d) { return d == static_cast<float>(known.band().outside); }));
        BOOST_TEST(has([&](float d) { return d == -static_cast<float>(known.band().inside); }));
        BOOST_TEST(has([&](float d) { return d > 0 && d < 0.5F; }));
        BOOST_TEST(has([&](float d) { return d < 0 && d > -0.5F; }));
    }
}

BOOST_AUTO_TEST_CASE(has_coarse_bricks_without_polyhedra_inside_and_outside) {
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group})
        for (const bool long_bricks : {false, true}) {
            const KnownField known({.long_bricks = long_bricks, .fine = true});
            DistanceTransform transform(test_device(), known.mesh(), {.sign = SignRule::nonzero, .body = body});
            TransformStatistics statistics;
            Field field = transform.compute(known.grid(), known.band(), all_outputs(), {}, &statistics);
            BOOST_TEST(check_exact(known.mesh(), field, guaranteed).band_samples > 30U);
            const std::optional<std::string> difference = known.difference(arrays_of(field));
            BOOST_TEST(!difference.has_value(), difference.value_or(""));
            // One of three coarse bricks: the first samples of a row lie outside, the last ones inside.
            BOOST_TEST(statistics.work->coarse_bricks == 1U);
            BOOST_TEST(field.distance().front() == static_cast<float>(known.band().outside));
            BOOST_TEST(field.distance().back() == -static_cast<float>(known.band().inside));
        }
}

BOOST_AUTO_TEST_SUITE_END()
