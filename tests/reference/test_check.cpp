#include <clsdf/error.hpp>
#include <clsdf/reference.hpp>

#include <boost/test/unit_test.hpp>

#include "support/random_meshes.hpp"
#include "support/test_meshes.hpp"

#include <oneapi/tbb/global_control.h>
#include <stop_token>
#include <thread>

using namespace clsdf;
using namespace clsdf::test;
using reference::check;
using reference::CheckOptions;
using reference::CheckReport;
using reference::reference_field;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

CheckOptions complete() {
    return {.samples = 0};
}

std::size_t findings_of(const CheckReport& report) {
    std::size_t wrong = report.wrong_values + report.wrong_signs + report.missed + report.leaked;
    for (const std::size_t count : report.wrong_outputs) wrong += count;
    return wrong;
}

/// A mesh of inradius 0.4.
Mesh tetrahedron() {
    return {{{0, 0, 0.1}, {2, 0.1, 0}, {0.1, 2, 0}, {0, 0.2, 2.1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
}

/// No sample is on the surface.
Grid grid_around_it() {
    return {{-1.03, -1.01, -0.97}, {0.21, 0.27, 0.23}, {20, 16, 18}, {}};
}

/// The distance and the triangle alone: other outputs do not follow when a test changes a band.
Field plain_field(const Mesh& mesh, const Grid& grid, const Band& band, SignRule sign = SignRule::automatic) {
    Field field = reference_field(mesh, grid, band, sign);
    for (const OutputInfo& info : output_table())
        if (info.output != Output::distance && info.output != Output::triangle) field.erase(info.output);
    return field;
}

Field right_field(const Band& band = {0.1, 0.7}, SignRule sign = SignRule::nonzero) {
    return plain_field(tetrahedron(), grid_around_it(), band, sign);
}

/// The first sample that fits; there must be one.
template <typename Predicate>
std::size_t find(const Field& field, const Predicate& predicate) {
    for (std::size_t i = 0; i < field.distance().size(); ++i) {
        if (predicate(field.distance()[i])) {
            return i;
        }
    }
    BOOST_REQUIRE(false);
    return 0;
}

bool is_in_outer_band(float d) {
    return d > 0.2F && d < 0.6F;
}
bool is_in_inner_band(float d) {
    return d < -0.03F && d > -0.09F;
}
bool is_outside_beyond(float d) {
    return d == 0.7F;
}
bool is_inside_beyond(float d) {
    return d == -0.1F;
}

CheckReport check_broken(const Field& field, const CheckOptions& options = complete()) {
    return check(tetrahedron(), field, options);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_right_field_passes_complete_and_sampled) {
    for (const Band& band : {Band{0.1, 0.7}, Band{0, 0.7}, Band{0.1, 0}, Band::signs_only(), Band{infinity, infinity},
                             Band{0.05, infinity}, Band{9, 9}}) {
        for (const SignRule sign : {SignRule::nonzero, SignRule::parity, SignRule::none, SignRule::automatic}) {
            BOOST_TEST_CONTEXT("inside " << band.inside << " outside " << band.outside << " sign " << name_of(sign)) {
                const Field field = right_field(band, sign);
                const CheckReport report = check_broken(field);
                BOOST_TEST(report.passed());
                BOOST_TEST(report.samples == field.grid.sample_count());
                BOOST_TEST(report.findings.empty());
                BOOST_TEST(report.max_error_ulp <= 0.5);
                BOOST_TEST(report.max_error_voxels <= 1e-6);
                const CheckReport sampled = check_broken(field, {.samples = 3000});
                BOOST_TEST(sampled.passed());
                BOOST_TEST(sampled.samples == 3000U);
                BOOST_TEST(check_broken(field, {.samples = report.samples + 1}).samples == report.samples);
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(fields_checked_together_get_the_reports_that_each_gets_alone) {
    std::vector<Field> fields(3, right_field());
    fields[1].distance()[find(fields[1], is_in_outer_band)] += 3e-5F;
    fields[2].distance()[find(fields[2], is_in_inner_band)] *= -1;
    for (const CheckOptions& options : {complete(), CheckOptions{.samples = 3000}}) {
        const std::vector<CheckReport> reports = check(tetrahedron(), fields, options);
        BOOST_REQUIRE(reports.size() == fields.size());
        for (std::size_t i = 0; i < fields.size(); ++i) {
            const CheckReport alone = check_broken(fields[i], options);
            BOOST_TEST(reports[i].samples == alone.samples);
            BOOST_TEST(reports[i].band_samples == alone.band_samples);
            BOOST_TEST(reports[i].wrong_values == alone.wrong_values);
            BOOST_TEST(reports[i].wrong_signs == alone.wrong_signs);
            BOOST_TEST(reports[i].max_error_voxels == alone.max_error_voxels);
            BOOST_TEST(reports[i].findings.size() == alone.findings.size());
        }
    }
    const std::vector<CheckReport> reports = check(tetrahedron(), fields, complete());
    BOOST_TEST(reports[0].passed());
    BOOST_TEST(reports[1].wrong_values == 1U);
    BOOST_TEST(reports[2].wrong_signs == 1U);
}

BOOST_AUTO_TEST_CASE(fields_of_different_problems_are_not_checked_together) {
    const auto refused = [](const Field& other) {
        const std::vector<Field> fields{right_field(), other};
        BOOST_CHECK_EXCEPTION(check(tetrahedron(), fields), Error,
                              [](const Error& error) { return error.code() == ErrorCode::invalid_argument; });
    };
    refused(right_field({0.1, 0.6}));
    refused(right_field({0.1, 0.7}, SignRule::parity));
    Field moved = right_field();
    moved.grid.first[0] += 1;
    refused(moved);
    BOOST_CHECK_THROW(check(tetrahedron(), std::vector<Field>{}), Error);
}

BOOST_AUTO_TEST_CASE(the_number_of_band_samples_is_that_of_the_triangles_named) {
    const Field field = right_field();
    const auto named = static_cast<std::size_t>(
        std::ranges::count_if(field.triangle(), [](std::uint32_t triangle) { return triangle != no_triangle; }));
    BOOST_TEST(check_broken(field).band_samples == named);
}

BOOST_AUTO_TEST_CASE(one_wrong_value_is_found_and_described) {
    Field field = right_field();
    const std::size_t at = find(field, is_in_outer_band);
    const float right = field.distance()[at];
    field.distance()[at] += 3e-5F;
    const CheckReport report = check_broken(field);
    BOOST_TEST(report.wrong_values == 1U);
    BOOST_TEST(findings_of(report) == 1U);
    BOOST_REQUIRE(report.findings.size() == 1U);
    const auto& finding = report.findings.front();
    BOOST_TEST(field.grid.offset(finding.sample[0], finding.sample[1], finding.sample[2]) == at);
    BOOST_TEST(finding.expected == right, boost::test_tools::tolerance(1e-6));
    BOOST_TEST(static_cast<float>(finding.found) == field.distance()[at]);
    BOOST_TEST(report.max_error_voxels == 3e-5 / 0.21, boost::test_tools::tolerance(1e-2));
    BOOST_TEST(!report.passed());
}

BOOST_AUTO_TEST_CASE(an_error_within_the_tolerance_is_none) {
    Field field = right_field();
    for (float& value : field.distance()) {
        if (is_in_outer_band(value) || is_in_inner_band(value)) {
            value += 0.9e-5F * 0.21F;
        }
    }
    BOOST_TEST(check_broken(field).passed());
    CheckOptions strict = complete();
    strict.tolerance_voxels = 1e-6;
    BOOST_TEST(check_broken(field, strict).wrong_values > 100U);
}

BOOST_AUTO_TEST_CASE(the_root_mean_square_is_that_of_the_band_samples) {
    Field field = right_field({9, 9});
    for (float& value : field.distance()) {
        value += value < 0 ? -2.1e-3F : 2.1e-3F;
    }
    const CheckReport report = check_broken(field);
    BOOST_TEST(report.rms_error_voxels == 0.01, boost::test_tools::tolerance(1e-3));
    BOOST_TEST(report.max_error_voxels == 0.01, boost::test_tools::tolerance(1e-3));
}

BOOST_AUTO_TEST_CASE(large_distances_are_judged_in_units_of_the_float_written) {
    // 1e5 voxels away a float32 is coarser than 1e-5 voxel.
    const Mesh mesh = tetrahedron();
    const Grid grid{{1e5, 0.1, 0.2}, {1, 1, 1}, {30, 2, 2}, {}};
    Field field = plain_field(mesh, grid, {infinity, infinity});
    BOOST_TEST(check(mesh, field, complete()).passed());
    const auto step = [](float& value, int steps) {
        for (int i = 0; i < steps; ++i) {
            value = std::nextafter(value, 0.0F);
        }
    };
    step(field.distance()[3], 1);
    BOOST_TEST(check(mesh, field, complete()).passed());
    step(field.distance()[5], 3);
    const CheckReport report = check(mesh, field, complete());
    BOOST_TEST(report.wrong_values == 1U);
    BOOST_TEST(report.max_error_ulp >= 2.5);
    BOOST_TEST(report.max_error_ulp <= 3.5);
}

BOOST_AUTO_TEST_CASE(one_wrong_sign_in_the_band_or_beyond_it_is_found) {
    for (const auto& where : {&is_in_outer_band, &is_in_inner_band, &is_outside_beyond, &is_inside_beyond}) {
        Field field = right_field();
        const std::size_t at = find(field, *where);
        field.distance()[at] = -field.distance()[at];
        const CheckReport report = check_broken(field);
        BOOST_TEST(report.wrong_signs == 1U);
        BOOST_TEST(!report.passed());
        BOOST_REQUIRE(!report.findings.empty());
        BOOST_TEST(report.findings.front().found == static_cast<double>(field.distance()[at]));
    }
    // Beyond the band the other side's fill value is nothing but a wrong sign.
    Field field = right_field();
    field.distance()[find(field, is_outside_beyond)] = -0.1F;
    BOOST_TEST(findings_of(check_broken(field)) == 1U);
}

BOOST_AUTO_TEST_CASE(one_missed_and_one_leaked_sample_are_found) {
    Field missed = right_field();
    const std::size_t in_band = find(missed, is_in_outer_band);
    missed.distance()[in_band] = 0.7F;
    const CheckReport missed_report = check_broken(missed);
    BOOST_TEST(missed_report.missed == 1U);
    BOOST_TEST(findings_of(missed_report) == 1U);

    Field leaked = right_field();
    leaked.distance()[find(leaked, is_outside_beyond)] = 0.75F;
    const CheckReport leaked_report = check_broken(leaked);
    BOOST_TEST(leaked_report.leaked == 1U);
    BOOST_TEST(findings_of(leaked_report) == 1U);
}

BOOST_AUTO_TEST_CASE(a_value_that_is_not_a_number_is_found_wherever_it_is) {
    for (const auto& where : {&is_in_outer_band, &is_in_inner_band, &is_outside_beyond, &is_inside_beyond}) {
        for (const float bad : {std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::quiet_NaN()}) {
            Field field = right_field();
            field.distance()[find(field, *where)] = bad;
            const CheckReport report = check_broken(field);
            BOOST_TEST(report.wrong_values + report.leaked == 1U);
            BOOST_TEST(std::isfinite(report.max_error_voxels));
            BOOST_TEST(std::isfinite(report.rms_error_voxels));
        }
    }
    Field infinite = right_field();
    infinite.distance()[find(infinite, is_in_outer_band)] = std::numeric_limits<float>::infinity();
    BOOST_TEST(check_broken(infinite).wrong_values == 1U);
    BOOST_TEST(std::isinf(check_broken(infinite).max_error_voxels));
    BOOST_TEST(std::isinf(check_broken(infinite).max_error_ulp));
    BOOST_TEST(std::isinf(check_broken(infinite).rms_error_voxels));
}

BOOST_AUTO_TEST_CASE(the_sign_of_zero_is_part_of_the_contract) {
    // Inside a band without an inside, -0 is the fill value, and +0 is the wrong sign.
    Field field = right_field({0, 0.7});
    const std::size_t inside = find(field, [](float d) { return d == 0 && std::signbit(d); });
    field.distance()[inside] = 0.0F;
    BOOST_TEST(check_broken(field).wrong_signs == 1U);

    // Outside a band without an outside, +0 is.
    field = right_field({0.1, 0});
    const std::size_t outside = find(field, [](float d) { return d == 0 && !std::signbit(d); });
    field.distance()[outside] = -0.0F;
    BOOST_TEST(check_broken(field).wrong_signs == 1U);

    // An unsigned field is never negative.
    field = right_field({0, 0.7}, SignRule::none);
    field.distance()[find(field, is_in_outer_band)] *= -1;
    BOOST_TEST(check_broken(field).wrong_signs == 1U);
}

BOOST_AUTO_TEST_CASE(a_zero_distance_is_written_as_positive_zero) {
    const Mesh mesh({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}});
    const Grid grid{{-1, -1, -1}, {1, 1, 1}, {7, 7, 7}, {}};
    Field field = plain_field(mesh, grid, {1, 1});
    BOOST_TEST(check(mesh, field, complete()).passed());
    const std::size_t zero = find(field, [](float d) { return d == 0; });
    field.distance()[zero] = -0.0F;
    const CheckReport report = check(mesh, field, complete());
    BOOST_TEST(report.wrong_signs == 1U);
    BOOST_TEST(findings_of(report) == 1U);
    // Unless -0 is the fill value, and the sample within the tolerance of that limit.
    Field without_inside = plain_field(mesh, grid, {0, 1});
    without_inside.distance()[zero] = -0.0F;
    BOOST_TEST(check(mesh, without_inside, complete()).passed());
    // The sign of a sample on the surface, to within the margin, is not judged otherwise.
    field.distance()[zero] = -1e-7F;
    BOOST_TEST(check(mesh, field, complete()).passed());
}

BOOST_AUTO_TEST_CASE(a_sample_at_the_limit_may_carry_its_distance_or_the_fill_value) {
    // A lattice of whole numbers and a band of one: limits are hit exactly.
    const Mesh mesh({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}});
    const Grid grid{{-3, -3, -3}, {1, 1, 1}, {11, 11, 11}, {}};
    for (const double width : {1.0 + 1e-7, 1.0 - 1e-7}) {
        Field field = plain_field(mesh, grid, {1, width});
        field.band.outside = 1;
        for (float& value : field.distance()) {
            value = value == static_cast<float>(width) ? 1.0F : value;
        }
        BOOST_TEST(check(mesh, field, complete()).passed());
        // Nothing else, though, at (-1, 1, 1).
        field.distance()[grid.offset(2, 4, 4)] = 0.5F;
        const CheckReport report = check(mesh, field, complete());
        BOOST_TEST(report.wrong_values == 1U);
        BOOST_TEST(findings_of(report) == 1U);
    }
}

BOOST_AUTO_TEST_CASE(a_triangle_that_is_not_a_nearest_one_is_found) {
    const Field right = right_field();
    const std::size_t in_band = find(right, is_in_outer_band);
    const std::size_t beyond = find(right, is_outside_beyond);
    for (const auto& [at, triangle] : {std::pair{in_band, no_triangle}, {in_band, 77U}, {beyond, 0U}, {beyond, 77U}}) {
        Field field = right;
        field.triangle()[at] = triangle;
        BOOST_TEST(check_broken(field).wrong_outputs[detail::index_of(Output::triangle)] == 1U);
        BOOST_TEST(findings_of(check_broken(field)) == 1U);
    }
    std::size_t accepted = 0;
    for (std::uint32_t triangle = 0; triangle < 4; ++triangle) {
        Field field = right;
        field.triangle()[in_band] = triangle;
        accepted += check_broken(field).passed() ? 1U : 0U;
    }
    BOOST_TEST(accepted >= 1U);
    BOOST_TEST(accepted < 4U);
}

BOOST_AUTO_TEST_CASE(an_output_that_breaks_its_contract_is_found) {
    const Field right = reference_field(tetrahedron(), grid_around_it(), {0.1, 0.7}, SignRule::nonzero);
    BOOST_TEST(check_broken(right).passed());
    const std::size_t in_band = find(right, is_in_outer_band);
    const std::size_t beyond = find(right, is_outside_beyond);
    struct Change {
        Output output;
        std::function<void(Field&)> make;
    };
    const std::vector<Change> changes{
        {Output::site, [&](Field& field) { field.site()[in_band] = no_site; }},
        {Output::site, [&](Field& field) { field.site()[in_band] = 7; }},
        {Output::site,
         [&](Field& field) { field.site()[in_band] = static_cast<std::uint8_t>((field.site()[in_band] + 1) % 7); }},
        {Output::site, [&](Field& field) { field.site()[beyond] = 6; }},
        {Output::closest, [&](Field& field) { field.closest()[3 * in_band + 1] += 1e-3; }},
        {Output::closest, [&](Field& field) { field.closest()[3 * in_band] = std::nan(""); }},
        {Output::closest, [&](Field& field) { field.closest()[3 * beyond + 2] = 0; }},
        {Output::gradient,
         [&](Field& field) {
             for (std::size_t i = 0; i < 3; ++i) field.gradient()[3 * in_band + i] *= -1;
         }},
        {Output::gradient, [&](Field& field) { field.gradient()[3 * in_band + 2] += 1e-3F; }},
        {Output::gradient, [&](Field& field) { field.gradient()[3 * in_band] = std::nanf(""); }},
        {Output::barycentric, [&](Field& field) { field.barycentric()[2 * in_band] += 0.01F; }},
        {Output::barycentric, [&](Field& field) { field.barycentric()[2 * in_band + 1] = 1.1F; }},
        {Output::offset, [&](Field& field) { field.offset()[3 * in_band + 1] += 1e-3F; }},
        {Output::offset,
         [&](Field& field) {
             for (std::size_t i = 0; i < 3; ++i) field.offset()[3 * in_band + i] *= -1;
         }},
        {Output::offset, [&](Field& field) { field.offset()[3 * beyond] = 0; }},
    };
    for (const Change& change : changes) BOOST_TEST_CONTEXT(info_of(change.output).name) {
            Field field = right;
            change.make(field);
            const CheckReport report = check_broken(field);
            for (const OutputInfo& info : output_table())
                BOOST_TEST(
                    report.wrong_outputs[detail::index_of(info.output)] == (info.output == change.output ? 1U : 0U),
                    info.name);
        }
}

BOOST_AUTO_TEST_CASE(only_the_first_ten_findings_are_kept_but_all_are_counted) {
    Field field = right_field();
    for (float& value : field.distance()) {
        value = -value;
    }
    const CheckReport report = check_broken(field);
    BOOST_TEST(report.wrong_signs == field.grid.sample_count());
    BOOST_TEST(report.findings.size() == 10U);
    BOOST_TEST((report.findings.front().sample == Index3{0, 0, 0}));
}

BOOST_AUTO_TEST_CASE(the_drawn_half_finds_faults_at_the_limits_and_near_edges_and_vertices) {
    // 1.8 million samples, of which each fault has so few that uniform draws alone would hit it hardly ever.
    const Mesh mesh = tetrahedron();
    const Grid grid{{-0.53, -0.51, -0.47}, {0.025, 0.027, 0.023}, {120, 114, 132}, {}};
    const Field right = plain_field(mesh, grid, {0.1, 0.3});
    const CheckOptions sampled{.samples = 4000};
    BOOST_TEST(check(mesh, right, sampled).passed());

    const auto count_found = [&](const auto& is_faulty) {
        Field field = right;
        std::size_t faults = 0;
        for (std::int64_t k = 0; k < grid.size[2]; ++k) {
            for (std::int64_t j = 0; j < grid.size[1]; ++j) {
                for (std::int64_t i = 0; i < grid.size[0]; ++i) {
                    float& value = field.distance()[grid.offset(i, j, k)];
                    if (is_faulty(value, grid.position(i, j, k))) {
                        value += 0.01F;
                        ++faults;
                    }
                }
            }
        }
        const double uniform = 4000.0 * static_cast<double>(faults) / static_cast<double>(grid.sample_count());
        return static_cast<double>(findings_of(check(mesh, field, sampled))) / uniform;
    };
    // So many times more of them are found than by uniform draws.
    BOOST_TEST(count_found([](float d, const Vec3&) { return d > 0.29F && d < 0.3F; }) > 3);
    BOOST_TEST(count_found([](float d, const Vec3&) { return d < -0.095F && d > -0.1F; }) > 3);
    BOOST_TEST(count_found([](float, const Vec3& p) {
                   return std::hypot(p[0] - 2, p[1] - 0.1, p[2]) < 0.05;  // a vertex
               }) > 100);
    BOOST_TEST(count_found([](float, const Vec3& p) {
                   const double t = 0.5 * (p[0] + p[1]);  // the edge between vertices 1 and 2, away from both
                   return std::fabs(p[0] - p[1]) < 1 && std::hypot(t - 1.05, p[2]) < 0.03;
               }) > 10);
}

BOOST_AUTO_TEST_CASE(the_report_does_not_depend_on_the_number_of_threads) {
    Field field = right_field();
    for (std::size_t i = 0; i < field.distance().size(); i += 7) {
        field.distance()[i] *= 1.001F;
    }
    for (const std::size_t samples : {std::size_t{0}, std::size_t{3000}}) {
        CheckReport reports[2];
        for (const std::size_t threads : {1U, 2U}) {
            const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism, threads);
            reports[threads - 1] = check_broken(field, {.samples = samples});
        }
        BOOST_TEST(reports[0].wrong_values == reports[1].wrong_values);
        BOOST_TEST(reports[0].rms_error_voxels == reports[1].rms_error_voxels);
        BOOST_TEST(reports[0].max_error_ulp == reports[1].max_error_ulp);
        BOOST_REQUIRE(reports[0].findings.size() == reports[1].findings.size());
        for (std::size_t i = 0; i < reports[0].findings.size(); ++i) {
            BOOST_TEST((reports[0].findings[i].sample == reports[1].findings[i].sample));
        }
    }
}

BOOST_AUTO_TEST_CASE(another_seed_draws_other_samples) {
    Field field = right_field();
    for (std::size_t i = 0; i < field.distance().size(); i += 2) {
        field.distance()[i] *= -1;
    }
    const CheckReport one = check_broken(field, {.samples = 1000, .seed = 1});
    const CheckReport again = check_broken(field, {.samples = 1000, .seed = 1});
    const CheckReport other = check_broken(field, {.samples = 1000, .seed = 2});
    BOOST_TEST((one.findings[0].sample == again.findings[0].sample));
    BOOST_TEST((one.findings[0].sample != other.findings[0].sample));
}

BOOST_AUTO_TEST_CASE(a_mesh_far_from_the_origin_raises_no_false_alarm_and_hides_no_fault) {
    for (const double far : {1e6, 1e9}) {
        BOOST_TEST_CONTEXT("offset " << far) {
            Random random(5);
            std::vector<Vec3> vertices(4);
            for (Vec3& vertex : vertices) {
                vertex = along({far, -far, far}, random.uniform(4, 9), random.direction());
            }
            const Mesh mesh(vertices, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
            const Grid grid{{far - 12.3, -far - 11.9, far - 12.1}, {1, 1, 1}, {25, 25, 25}, {}};
            Field field = plain_field(mesh, grid, {2, 3});
            BOOST_TEST(check(mesh, field, complete()).passed());
            CheckOptions strict = complete();
            strict.tolerance_voxels = 1e-7;
            strict.tolerance_ulp = 0.5;
            BOOST_TEST(check(mesh, field, strict).passed());
            const std::size_t at = find(field, [](float d) { return d > 1 && d < 2.5F; });
            field.distance()[at] += 2e-5F;
            BOOST_TEST(check(mesh, field, complete()).wrong_values == 1U);
        }
    }
}

BOOST_AUTO_TEST_CASE(every_counterexample_passes_with_its_own_field) {
    for (const Counterexample& example : all_counterexamples()) {
        BOOST_TEST_CONTEXT(example.name()) {
            const Vec3 extent = example.mesh.box().extent();
            Grid grid{example.mesh.box().lower, {}, {18, 18, 18}, {}};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                grid.origin[axis] -= example.half_width;
                grid.spacing[axis] = (extent[axis] + 2 * example.half_width) / 17;
            }
            const Band band{example.half_width, example.half_width};
            BOOST_TEST(check(example.mesh, plain_field(example.mesh, grid, band), complete()).passed());
        }
    }
}

BOOST_AUTO_TEST_CASE(a_field_that_does_not_fit_its_grid_or_its_mesh_is_an_error) {
    Field field = right_field();
    field.resize(Output::distance, field.distance().size() - 1);
    BOOST_CHECK_THROW(check_broken(field), Error);
    field = right_field();
    field.resize(Output::triangle, field.triangle().size() - 1);
    BOOST_CHECK_THROW(check_broken(field), Error);
    const Mesh open({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
    BOOST_CHECK_THROW(check(open, right_field(), complete()), Error);
}

BOOST_AUTO_TEST_CASE(a_check_reports_its_progress_and_can_be_cancelled) {
    CheckOptions options = complete();
    double last = 0;
    const std::thread::id caller = std::this_thread::get_id();
    options.progress = [&](double fraction) {
        BOOST_TEST((std::this_thread::get_id() == caller));
        BOOST_TEST(fraction > last);
        last = fraction;
    };
    check_broken(right_field(), options);
    BOOST_TEST(last == 1);
    std::stop_source source;
    options.should_stop = [&] {
        BOOST_TEST((std::this_thread::get_id() == caller));
        return source.stop_requested();
    };
    options.progress = [&](double) { source.request_stop(); };
    try {
        check_broken(right_field(), options);
        BOOST_TEST(false);
    } catch (const Error& error) {
        BOOST_TEST((error.code() == ErrorCode::cancelled));
    }
}
