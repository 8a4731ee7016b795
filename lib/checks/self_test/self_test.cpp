#include "self_test/self_test.hpp"

#include "core/tuning_variables.hpp"
#include "plan/grid_plan.hpp"
#include "points/kept_points.hpp"
#include "points/point_query.hpp"
#include "prepare/layout_of.hpp"
#include "self_test/known_field.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <mutex>
#include <string_view>
#include <system_error>

namespace clsdf::transform {

namespace {

// Part of the records' keys: with another known field, all is tested again.
constexpr int known_field_number = 6;

bool is_switched_off() {
    const char* const value = tuning_variable("CLSDF_SELF_TEST");
    return value != nullptr && std::string_view(value) == "0";
}

/// The counters that a counting variant must agree with the field in.
std::optional<std::string> wrong_counts(const KnownField& known, const HostArrays& found,
                                        const CallStatistics& statistics) {
    const std::size_t in_band = known.band_samples(found);
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

/// Whether a record may be there.
bool may_have(const device::Records& records) {
    std::error_code none;
    return std::filesystem::exists(records.folder(), none);
}

/// On the first lattice the values that may be floats or doubles have the type of fields, on the others the other type,
/// which other code stores. Only finishing makes distances in double.
HostArrays arrays_of(OutputSet outputs, bool is_first, bool is_finished) {
    HostArrays arrays = arrays_for(outputs);
    for_each_output(
        [&](const OutputInfo& row, HostArray& array) {
            if (is_real(row) && (is_finished || row.output != Output::distance)) array.in_double ^= !is_first;
        },
        arrays);
    return arrays;
}

OutputSet every_output() {
    OutputSet outputs;
    for (const OutputInfo& info : extra_outputs()) outputs.insert(info.output);
    return outputs;
}

/// Computes a known field with the launches of a transform that has these stages.
std::optional<std::string> run_field_test(const Device& device, const Programs& programs, const TestCase& test_case,
                                          const KnownFieldKind& kind, Stages& stages, const device::BuildWatch& watch) {
    const KnownField known(kind);
    const Grid& grid = known.grid();
    const SignRule sign = test_case.is_signed ? SignRule::nonzero : SignRule::none;
    OutputSet outputs;
    if (test_case.variant.nearest) outputs = test_case.method ? OutputSet(Output::triangle) : every_output();
    device::Context& context = device::context_of(device);
    // The plan, which waits for the device when it ends, is made after the memory that the device writes.
    OwnArrays own;
    const bool is_finished = test_case.variant.nearest && !test_case.method;
    const HostArrays arrays =
        own.for_samples(arrays_of(outputs, !kind.later && !kind.fine, is_finished), grid.sample_count());
    OutputMemories memories;
    device::guarded([&] { memories.place(context, *stages.pool(), arrays, grid.sample_count()); });
    Inputs inputs = stages.inputs(grid, layout_of(grid, known.band(), sign), sign);
    if (is_finished) inputs.sites = stages.sites(true, stages.may_meet_samples(grid));
    GridPlan plan({device, stages.pool(), programs, test_case.method, sign}, std::move(inputs),
                  {grid, known.band(), outputs, {}, test_case.variant.count}, watch.begins);
    return device::guarded([&] {
        const auto between = [&](double) {
            if (watch.tests) watch.tests();
        };
        CommandChain chain(context.queue(), {});
        plan.enqueue(chain, memories.buffers, between);
        memories.enqueue_handover(context.queue());
        context.queue().finish();
        memories.read(context, context.queue());
        plan.read_back(context.queue());
        std::optional<std::string> difference = known.difference(arrays);
        if (!difference && test_case.variant.count) difference = wrong_counts(known, arrays, plan.statistics);
        return difference;
    });
}

/// Looks up the samples of known fields as points: those of the first lattice without a limit, with signs by crossings;
/// those of the later one within a limit, with signs by the sides of faces.
std::optional<std::string> run_point_test(const Device& device, const Programs& programs,
                                          const PointTestCase& test_case) {
    constexpr double limit = 2.5;
    device::Context& context = device::context_of(device);
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    const KnownField unlimited({.wide = true}), limited = KnownField({.later = true}).within(limit);
    Stages stages(context, pool, unlimited.mesh(), {programs});
    if (test_case.is_later) stages.frusta();
    points::KeptPoints kept(stages);
    points::PointInputs inputs;
    inputs.mesh = kept.tree();
    inputs.sign = SignRule::nonzero;
    if (test_case.are_scanned) inputs.scanned = kept.scanned_mesh(programs.point_scan);
    inputs.sites = stages.sites(true, true);
    const auto difference = [&](const KnownField& known, bool is_later) {
        const std::vector<Vec3> positions = positions_of(known.grid());
        OwnArrays own;
        const HostArrays arrays = own.for_samples(arrays_of(every_output(), !is_later, true), positions.size());
        points::query_points(context, programs, pool, inputs, positions, known.band().outside, arrays, {});
        return known.difference(arrays);
    };
    if (auto wrong = difference(unlimited, false)) return wrong;
    inputs.sides = kept.face_sides(inputs.sign, true);
    return difference(limited, true);
}

}  // namespace

std::string TestCase::name() const {
    return fmt::format("{} {}{}{}{} {} {}{}", device::name_of(body), method ? method->name() : "bricks",
                       variant.nearest ? " NEAREST" : "", variant.count ? " COUNT" : "",
                       variant.long_bricks ? " LONG_BRICKS" : "", is_signed ? "signed" : "unsigned",
                       is_wide ? "wide" : "narrow", is_later ? " later" : "");
}

std::size_t step_count(const TestCase& test_case) {
    const std::size_t sweep = test_case.is_signed ? 4 : 0;
    if (test_case.method) return Programs::field_programs + test_case.method->step_count() + sweep;
    // The program, and on each lattice the lists and the scan. The first buffer is too small for this mesh's pairs, so
    // the counting pass runs twice.
    const std::size_t lists = test_case.is_wide ? 4 : 3, lattices = test_case.is_wide ? 2 : 3;
    return Programs::field_programs + 1 + lattices * (sweep + lists + 1);
}

std::optional<std::string> run_self_test(const Device& device, const Programs& programs, const TestCase& test_case,
                                         const device::BuildWatch& watch) {
    KnownFieldKind kind{
        .wide = test_case.is_wide, .is_signed = test_case.is_signed, .long_bricks = test_case.variant.long_bricks};
    device::Context& context = device::context_of(device);
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    const auto make_stages = [&] {
        return std::make_unique<Stages>(
            context, pool, KnownField(kind).mesh(),
            Stages::Options{.programs = programs, .method = test_case.method, .is_whole = true});
    };
    std::unique_ptr<Stages> stages = make_stages();
    std::optional<std::string> difference = run_field_test(device, programs, test_case, kind, *stages, watch);
    if (difference || test_case.method) return difference;
    const auto run_on_another_lattice = [&] {
        if (!test_case.is_later) stages = make_stages();
        return run_field_test(device, programs, test_case, kind, *stages, watch);
    };
    kind.later = true;
    if ((difference = run_on_another_lattice()) || test_case.is_wide) return difference;
    // The group body computes all bricks of a coarse brick that a polyhedron overlaps; the fill is left with the
    // others.
    kind.later = false;
    kind.fine = true;
    return run_on_another_lattice();
}

bool test_once(const Device& device, const TestSubject& subject,
               const std::function<std::optional<std::string>()>& test) {
    device::Context& context = device::context_of(device);
    if (context.is_tested(subject.name)) return false;
    const std::scoped_lock lock(context.test_mutex());
    if (context.is_tested(subject.name)) return false;
    const device::Records records = context.records();
    const auto key = [&] { return key_of(context, subject.name, subject.build()); };
    const bool is_run = !is_switched_off() && !(may_have(records) && records.has(key()));
    if (is_run)
        if (const std::optional<std::string> difference = test())
            throw Error(
                ErrorCode::wrong_results,
                fmt::format("{} computes wrong fields, so it is not used. In a small known field, computed by the "
                            "kernels \"{}\", {}. The OpenCL compiler or driver is at fault: update it, or take another "
                            "device (\"clsdf devices\" lists them, --device or CLSDF_DEVICE chooses)",
                            device::guarded([&] { return context.description(); }), subject.name, *difference));
    const std::string built = key();
    if (is_run) records.note(built);
    context.set_tested(subject.name);
    return is_run;
}

bool ensure_tested(const Device& device, const Programs& programs, const TestCase& test_case,
                   const device::BuildWatch& watch) {
    device::Context& context = device::context_of(device);
    if (context.is_tested(test_case.name())) return false;
    const std::vector<cl::Program> of_fields = device::guarded([&] { return programs.of_fields(watch); });
    // In a first test, after the other kernels: "clsdf compute" has them compiled by another process meanwhile.
    const auto with_scan = [&] {
        return device::guarded([&] {
            const BrickVariant& variant = test_case.variant;
            std::vector<cl::Program> all = of_fields;
            for (cl::Program& program : test_case.method ? test_case.method->build(context, programs, variant, watch)
                                                         : std::vector{programs.bricks(context, variant, watch)})
                all.push_back(std::move(program));
            return all;
        });
    };
    // The case of a later lattice runs all that the case of a first one runs.
    TestCase first = test_case;
    first.is_later = false;
    const TestSubject subject{test_case.name(), with_scan};
    const bool is_run = test_once(device, subject, [&] {
        std::optional<std::string> difference = run_self_test(device, programs, test_case, watch);
        if (!difference && test_case.is_later) context.records().note(key_of(context, first.name(), with_scan()));
        return difference;
    });
    context.set_tested(first.name());
    return is_run;
}

bool ensure_points_tested(const Device& device, const Programs& programs, const PointTestCase& test_case,
                          const device::BuildWatch& watch) {
    std::vector<cl::Program> built;
    device::guarded([&] {
        built.push_back(programs.points.get(watch));
        if (!test_case.are_scanned) return;
        built.push_back(programs.mesh_records.get(watch));
        built.push_back(programs.point_scan.get(watch));
    });
    const TestSubject subject{fmt::format("{} {}points{}", device::name_of(programs.body),
                                          test_case.are_scanned ? "many " : "", test_case.is_later ? " later" : ""),
                              [&] { return built; }};
    return test_once(device, subject, [&] { return run_point_test(device, programs, test_case); });
}

}  // namespace clsdf::transform
