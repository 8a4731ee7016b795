#include "transform/self_test.hpp"

#include "points/point_query.hpp"
#include "scan/layout_of.hpp"
#include "transform/grid_plan.hpp"
#include "transform/known_field.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <mutex>
#include <string_view>

namespace clsdf::transform {

namespace {

// Part of the records' keys: with another known field, all is tested again.
constexpr int known_field_number = 1;

bool is_switched_off() {
    const char* const value = std::getenv("CLSDF_SELF_TEST");
    return value != nullptr && std::string_view(value) == "0";
}

/// The counters that a counting variant must agree with the field in.
std::optional<std::string> wrong_counts(const KnownField& known, const std::vector<float>& distance,
                                        const TransformStatistics& statistics) {
    std::size_t in_band = 0;
    const auto inside = -static_cast<float>(known.band().inside), outside = static_cast<float>(known.band().outside);
    for (const float value : distance) in_band += static_cast<std::size_t>(inside < value && value < outside);
    if (statistics.band_samples == in_band && statistics.samples_covered >= in_band &&
        statistics.lanes_evaluated >= statistics.samples_covered)
        return std::nullopt;
    return fmt::format("{} samples of the band were counted, {} covered and {} evaluated, and the field has {}",
                       statistics.band_samples, statistics.samples_covered, statistics.lanes_evaluated, in_band);
}

/// All keys of the programs that a test runs.
std::string key_of(const device::Context& context, const std::string& name, const std::vector<cl::Program>& programs) {
    std::string key = fmt::format("{}known field {} {}\n", context.identity(), known_field_number, name);
    for (const cl::Program& program : programs) key += context.key_of(program) + '\n';
    return key;
}

std::vector<cl::Program> common_programs(const Programs& programs) {
    return {programs.scan, programs.coarse_lists, programs.sign_sweep, programs.fill, programs.mesh_records};
}

/// The known field's grid has the same samples at points, whose distances have no limit.
std::optional<std::string> run_point_test(const Device& device, const Programs& programs, bool are_scanned) {
    KnownFieldKind kind;
    kind.wide = true;
    const KnownField known(kind);
    device::Context& context = device::context_of(device);
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    Stages stages(context, pool, known.mesh());
    const Grid& grid = known.grid();
    std::vector<Vec3> samples;
    for (std::int64_t k = 0; k < grid.size[2]; ++k)
        for (std::int64_t j = 0; j < grid.size[1]; ++j)
            for (std::int64_t i = 0; i < grid.size[0]; ++i) samples.push_back(grid.position(i, j, k));
    std::vector<float> distance(samples.size());
    std::vector<std::uint32_t> triangle(samples.size());
    HostArrays arrays;
    arrays.distance = {true, false, reinterpret_cast<std::byte*>(distance.data())};
    arrays.triangle = {true, false, reinterpret_cast<std::byte*>(triangle.data())};
    points::PointInputs inputs;
    inputs.mesh = stages.points();
    inputs.sign = SignRule::nonzero;
    if (are_scanned) {
        inputs.scanned = stages.scanned_mesh(programs.point_scan(context));
        inputs.sides = stages.face_sides(inputs.sign, true);
    }
    inputs.sites = stages.sites(true, are_scanned);
    points::query_points(context, programs, pool, inputs, samples, known.band().outside, arrays, {});
    return known.difference(distance, triangle);
}

}  // namespace

TestCase TestCase::with_small_triangles() const {
    TestCase result = *this;
    result.is_large = false;
    return result;
}

std::string TestCase::name() const {
    return fmt::format("{} {}{}{}{} {} {}{}", device::name_of(body), method ? method->name() : "bricks",
                       variant.nearest ? " NEAREST" : "", variant.count ? " COUNT" : "",
                       variant.long_bricks ? " LONG_BRICKS" : "", is_signed ? "signed" : "unsigned",
                       is_wide ? "wide" : "narrow", is_large ? " large" : "");
}

std::vector<cl::Program> variant_programs(device::Context& context, const Programs& programs, const TestCase& test_case,
                                          const device::BuildWatch& watch) {
    if (test_case.method) return test_case.method->build(context, programs, test_case.variant, watch);
    return {programs.bricks(context, test_case.variant, watch)};
}

std::size_t step_count(const TestCase& test_case) {
    const std::size_t sweep = test_case.is_signed ? (test_case.is_large ? 4 : 3) : 0;
    if (test_case.method) return test_case.method->step_count() + sweep;
    // The program, the lists and the scan. The first buffer is too small for this mesh's pairs, so the counting pass
    // runs twice.
    const std::size_t lists = test_case.is_wide ? 4 : 3;
    return 1 + sweep + lists + 1;
}

std::optional<std::string> run_self_test(const Device& device, const Programs& programs, const TestCase& test_case,
                                         const device::BuildWatch& watch) {
    const KnownField known({test_case.is_wide, test_case.is_signed, test_case.variant.long_bricks, test_case.is_large});
    const SignRule sign = test_case.is_signed ? SignRule::nonzero : SignRule::none;
    const Outputs outputs{.triangle = test_case.variant.nearest};
    device::Context& context = device::context_of(device);
    const cl::CommandQueue& queue = context.queue();
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    Stages stages(context, pool, known.mesh(), {test_case.method, {programs.mesh_records, programs.mesh_lanes()}});
    Inputs inputs = stages.inputs(known.grid(), layout_of(known.grid(), known.band(), sign), sign);
    if (outputs.triangle && !test_case.method) inputs.sites = stages.sites(true, false);
    GridPlan plan(device, pool, programs, std::move(inputs), known.grid(), known.band(), sign, outputs,
                  {test_case.variant.count, test_case.method}, watch.begins);
    return device::guarded([&] {
        std::vector<float> distance(known.grid().sample_count());
        std::vector<std::uint32_t> triangle(outputs.triangle ? distance.size() : 0);
        const auto distances = pool->lease(distance.size() * sizeof(float), "samples of the self-test");
        const auto triangles = pool->lease(distance.size() * sizeof(float), "samples of the self-test");
        const auto between = [&](double) {
            if (watch.begins) watch.begins();
        };
        OutputBuffers buffers;
        buffers.distance = *distances;
        if (outputs.triangle) buffers.triangle = *triangles;
        plan.enqueue(queue, buffers, {}, between);
        queue.enqueueReadBuffer(*distances, CL_TRUE, 0, distance.size() * sizeof(float), distance.data());
        if (outputs.triangle)
            queue.enqueueReadBuffer(*triangles, CL_TRUE, 0, triangle.size() * sizeof(std::uint32_t), triangle.data());
        plan.read_counters();
        std::optional<std::string> difference = known.difference(distance, triangle);
        if (!difference && test_case.variant.count) difference = wrong_counts(known, distance, plan.statistics);
        return difference;
    });
}

bool test_once(const Device& device, const TestSubject& subject, const device::BuildWatch& watch,
               const std::function<std::optional<std::string>()>& test) {
    device::Context& context = device::context_of(device);
    if (context.is_tested(subject.name)) return false;
    const std::scoped_lock lock(context.test_mutex());
    if (context.is_tested(subject.name)) return false;
    bool is_run = false;
    if (!is_switched_off()) {
        const device::BuildSubject build{key_of(context, subject.name, subject.programs),
                                         fmt::format("the kernels \"{}\"", subject.name), context.identity()};
        device::build_once(context.records(), build, watch, [&] {
            is_run = true;
            const std::optional<std::string> difference = test();
            if (!difference) return;
            throw Error(
                ErrorCode::device_failure,
                fmt::format("{} computes wrong fields, so it is not used: of a small field that is known, computed by "
                            "the kernels \"{}\", {}. Its OpenCL compiler or driver is at fault: update it, or take "
                            "another device (\"clsdf devices\" lists them, --device or CLSDF_DEVICE chooses)",
                            device::one_line(context.identity()), subject.name, *difference));
        });
    }
    context.set_tested(subject.name);
    return is_run;
}

bool ensure_tested(const Device& device, const Programs& programs, const TestCase& test_case,
                   const device::BuildWatch& watch) {
    device::Context& context = device::context_of(device);
    if (context.is_tested(test_case.name())) return false;
    TestSubject subject{test_case.name(), common_programs(programs)};
    for (cl::Program& program : device::guarded([&] { return variant_programs(context, programs, test_case, watch); }))
        subject.programs.push_back(std::move(program));
    const bool is_run = test_once(device, subject, watch, [&] {
        std::optional<std::string> difference = run_self_test(device, programs, test_case, watch);
        if (!difference && test_case.is_large)
            context.records().note(key_of(context, test_case.with_small_triangles().name(), subject.programs));
        return difference;
    });
    if (test_case.is_large) context.set_tested(test_case.with_small_triangles().name());
    return is_run;
}

bool ensure_points_tested(const Device& device, const Programs& programs, bool are_scanned,
                          const device::BuildWatch& watch) {
    device::Context& context = device::context_of(device);
    TestSubject subject{fmt::format("{} {}points", device::name_of(programs.body), are_scanned ? "many " : ""), {}};
    device::guarded([&] {
        subject.programs.push_back(programs.points(context, watch));
        if (are_scanned) subject.programs.push_back(programs.point_scan(context, watch));
    });
    return test_once(device, subject, watch, [&] { return run_point_test(device, programs, are_scanned); });
}

}  // namespace clsdf::transform
