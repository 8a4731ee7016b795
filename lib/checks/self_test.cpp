#include "checks/self_test.hpp"

#include "checks/known_field.hpp"
#include "checks/known_topology.hpp"
#include "core/tuning_variables.hpp"
#include "device/in_flight.hpp"
#include "device/read_back.hpp"
#include "lattice/layout_of.hpp"
#include "lists/coarse_lists.hpp"
#include "plan/field_method.hpp"
#include "plan/grid_inputs.hpp"
#include "plan/grid_plan.hpp"
#include "points/kept_points.hpp"
#include "points/point_query.hpp"

#include <clsdf/sparse.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <mutex>
#include <span>
#include <string_view>
#include <utility>

namespace clsdf::checks {

namespace {

// Part of the records' keys: with other known values, all is tested again.
constexpr int known_values_number = 8;

struct TestedField {
    FieldKernels kernels;
    KnownFieldKind kind;
};

/// In the fine field, the group body computes all bricks of a coarse brick that a polyhedron overlaps, and leaves the
/// other coarse bricks to the fill. Bricks alone make the difference.
constexpr std::array tested_fields{
    TestedField{FieldKernels::of_all, {}},
    TestedField{FieldKernels::of_all, {.on_surface = true}},
    TestedField{FieldKernels::of_all, {.fine = true}},
    TestedField{FieldKernels::of_kept_frusta, {.on_surface = true}},
    TestedField{FieldKernels::of_wide_bands, {.wide = true}},
    TestedField{FieldKernels::of_sparse_fields, {}},
    TestedField{FieldKernels::of_sparse_fields, {.fine = true}},
};

/// By kernels.
constexpr std::array names_of_kernels{"", ", kept frusta", ", wide bands", ", sparse fields"};

bool is_switched_off() {
    const char* const value = tuning_variable("CLSDF_SELF_TEST");
    return value != nullptr && std::string_view(value) == "0";
}

/// The counters that a counting variant must agree with the field in.
std::optional<std::string> wrong_counts(const KnownField& known, const targets::HostArrays& found,
                                        const CallStatistics& statistics) {
    const std::size_t in_band = known.band_samples(found);
    if (statistics.band_samples == in_band && statistics.samples_covered >= in_band &&
        statistics.lanes_evaluated >= statistics.samples_covered)
        return std::nullopt;
    return fmt::format("{} samples of the band were counted, {} covered and {} evaluated, and the field has {}",
                       statistics.band_samples, statistics.samples_covered, statistics.lanes_evaluated, in_band);
}

/// All that the results of a test depend on.
std::string key_of(const device::Context& context, const TestSubject& subject, const device::BuildWatch& watch) {
    std::string key = fmt::format("{}known values {} {}\n", context.identity(), known_values_number, subject.name);
    for (const cl::Program& program : subject.build(watch)) key += context.key_of(program) + '\n';
    return key;
}

/// On the first lattice the values that may be floats or doubles have the type of fields, on the others the other type,
/// which other code stores. Only finishing makes distances in double.
targets::HostArrays arrays_of(OutputSet outputs, bool is_first, bool is_finished) {
    targets::HostArrays arrays = targets::arrays_for(outputs);
    for_each_output(
        [&](const OutputInfo& row, targets::HostArray& array) {
            if (may_be_double(row) && (is_finished || row.output != Output::distance)) array.in_double ^= !is_first;
        },
        arrays);
    return arrays;
}

OutputSet every_output() {
    OutputSet outputs;
    for (const OutputInfo& info : extra_outputs()) outputs.insert(info.output);
    return outputs;
}

/// The outputs of a variant's known fields.
OutputSet outputs_of(const engine::Workshop& workshop, const engine::BrickVariant& variant) {
    if (!variant.nearest) return {};
    return workshop.method ? OutputSet(Output::triangle) : every_output();
}

/// From the values that the mesh keeps.
std::unique_ptr<engine::GridPlan> make_plan(const engine::Workshop& workshop, engine::KeptMesh& kept_mesh,
                                            const engine::JobKey& asked, bool shares_short_lists = false) {
    const engine::Job job = kept_mesh.checked(asked, workshop.sign);
    engine::Inputs inputs = engine::grid_inputs(kept_mesh, job, workshop.sign);
    if (asked.outputs != OutputSet{} && !workshop.method) inputs.sites = kept_mesh.sites(true, inputs.needs_normals);
    inputs.shares_short_lists = shares_short_lists;
    return std::make_unique<engine::GridPlan>(workshop, std::move(inputs), job, std::function<void()>());
}

/// Computes a known field.
std::optional<std::string> field_difference(const engine::Workshop& workshop, engine::KeptMesh& kept_mesh,
                                            const KnownFieldKind& kind, const engine::BrickVariant& variant,
                                            const device::BuildWatch& watch) {
    if (watch.begins) watch.begins();
    const KnownField known(kind);
    const Grid& grid = known.grid();
    const OutputSet outputs = outputs_of(workshop, variant);
    device::Context& context = workshop.context();
    device::InFlight<targets::OwnArrays> own(context);
    own.begin();
    const bool is_finished = variant.nearest && !workshop.method;
    const targets::HostArrays arrays =
        own->for_samples(arrays_of(outputs, !kind.on_surface && !kind.fine, is_finished), grid.sample_count());
    targets::OutputMemories memories;
    memories.place(context, *workshop.pool, arrays, grid.sample_count());
    const auto plan = make_plan(workshop, kept_mesh, {grid, known.band(), outputs, {}, variant.count}, kind.on_surface);
    if (watch.tests) watch.tests();
    context.run_or_drain([&] {
        engine::CommandChain chain(context.queue(), {});
        plan->enqueue(chain, memories.buffers, {});
        memories.enqueue_handover(context.queue());
        context.finish();
        memories.read(context, context.queue());
        plan->read_back(context.queue());
    });
    own.end();
    std::optional<std::string> difference = known.difference(arrays);
    if (!difference && variant.count) difference = wrong_counts(known, arrays, plan->statistics);
    return difference;
}

/// Sample n of a packed grid, on the lattice.
Index3 sample_of(const Grid& grid, std::size_t n) {
    const auto at = static_cast<std::int64_t>(n);
    return {grid.first[0] + at % grid.size[0], grid.first[1] + at / grid.size[0] % grid.size[1],
            grid.first[2] + at / grid.size[0] / grid.size[1]};
}

/// A sparse field of whole bricks as the kernels leave it.
struct KernelBricks {
    Grid grid;
    std::vector<cl_uint> listed;    ///< CLSDF_STORED
    std::vector<cl_uchar> marks{};  ///< CLSDF_INSIDE_BRICK
    targets::HostArrays values{};   ///< of the listed bricks

    explicit KernelBricks(const Grid& grid_in) : grid(grid_in), listed(CLSDF_STORED + count()), marks(count()) {
        listed[CLSDF_STORED_ROOM] = static_cast<cl_uint>(count());
    }
    std::size_t count() const { return grid.sample_count() / brick_samples; }

    /// The number of a sample's brick, and that of the sample in it.
    std::pair<std::size_t, std::size_t> place_of(const Index3& sample) const {
        std::int64_t brick = 0, within = 0;
        for (std::size_t axis = 3; axis-- > 0;) {
            const std::int64_t at = sample[axis] - grid.first[axis];
            brick = brick * (grid.size[axis] / brick_side) + at / brick_side;
            within = within * brick_side + at % brick_side;
        }
        return {static_cast<std::size_t>(brick), static_cast<std::size_t>(within)};
    }
};

/// Sets the samples of the dense field that the bricks stand for. Describes what is wrong with the list.
std::optional<std::string> expand(const KernelBricks& bricks, const KnownField& known,
                                  const targets::HostArrays& field) {
    const std::size_t count = bricks.count(), listed = bricks.listed[CLSDF_STORED_COUNT];
    if (listed > count) return fmt::format("{} bricks have values, and the grid has {}", listed, count);
    std::vector<std::size_t> place(count, count);  // in the list
    for (std::size_t n = 0; n < listed; ++n) {
        const cl_uint brick = bricks.listed[CLSDF_STORED + n];
        if (brick >= count || place[brick] != count)
            return fmt::format("brick {} of {} is not in the grid, or has values twice", brick, count);
        place[brick] = n;
    }
    const Grid& grid = known.grid();
    for_each_output(
        [&](const OutputInfo& row, const targets::HostArray& from, const targets::HostArray& to) {
            if (!from.is_wanted) return;
            const bool is_distance = row.output == Output::distance;
            const std::size_t bytes = row.sample_bytes();
            const std::size_t with_values = is_distance ? count : bricks.listed[CLSDF_STORED_IN_BAND];
            for (std::size_t n = 0; n < grid.sample_count(); ++n) {
                const auto [brick, within] = bricks.place_of(sample_of(grid, n));
                std::byte* const sample = to.data + n * bytes;
                if (place[brick] < with_values) {
                    std::memcpy(sample, from.data + (place[brick] * brick_samples + within) * bytes, bytes);
                } else if (is_distance) {
                    const bool is_inside = bricks.marks[brick] == CLSDF_INSIDE_BRICK;
                    const auto limit = static_cast<float>(is_inside ? -known.band().inside : known.band().outside);
                    std::memcpy(sample, &limit, bytes);
                } else {
                    std::memset(sample, 0xFF, bytes);
                }
            }
        },
        bricks.values, field);
    return std::nullopt;
}

/// Computes a known field as a sparse one, and tests the dense field that it stands for.
std::optional<std::string> sparse_difference(const engine::Workshop& workshop, engine::KeptMesh& kept_mesh,
                                             const KnownFieldKind& kind, const engine::BrickVariant& variant,
                                             const device::BuildWatch& watch) {
    if (watch.begins) watch.begins();
    const KnownField known(kind);
    KernelBricks bricks(in_whole_bricks(known.grid()));
    const std::size_t samples = bricks.grid.sample_count();
    const auto plan =
        make_plan(workshop, kept_mesh, {bricks.grid, known.band(), outputs_of(workshop, variant), {}, variant.count});
    if (watch.tests) watch.tests();
    targets::OwnArrays own_field, own_values;
    const targets::HostArrays wanted = targets::arrays_for(plan->job.outputs);
    const targets::HostArrays field = own_field.for_samples(wanted, known.grid().sample_count());
    bricks.values = own_values.for_samples(wanted, samples);
    engine::OutputBuffers buffers;
    PerOutput<device::BufferPool::Lease> leases;
    for_each_output(
        [&](const OutputInfo& row, const targets::HostArray& array, device::BufferPool::Lease& lease,
            cl::Buffer& buffer) {
            if (!array.is_wanted) return;
            lease = workshop.pool->lease(samples * row.sample_bytes(), "values of a known field");
            buffer = *lease;
        },
        wanted, leases, buffers);
    const std::size_t list_bytes = bricks.listed.size() * sizeof(cl_uint);
    const auto list = workshop.pool->lease(list_bytes, "list of the bricks of a known field");
    buffers.listed = *list;
    device::Context& context = workshop.context();
    context.run_or_drain([&] {
        device::write_values(context, bricks.listed, *list);
        engine::CommandChain chain(context.queue(), {});
        plan->enqueue(chain, buffers, {});
        context.finish();
        device::read_values(context, *list, bricks.listed);
        device::read_values(context, plan->marks(), bricks.marks);
        for_each_output(
            [&](const OutputInfo& row, const targets::HostArray& array, const cl::Buffer& buffer) {
                if (array.is_wanted) context.read(context.queue(), buffer, 0, samples * row.sample_bytes(), array.data);
            },
            bricks.values, buffers);
    });
    if (auto wrong = expand(bricks, known, field)) return wrong;
    return known.difference(field);
}

// Points: more than a work-group sorts.
constexpr std::size_t looked_up_together = 2500;

/// Whether the device orders the points and counts crossings.
bool is_by_device(const engine::Programs& programs, PointKernels kernels) {
    return programs.body == KernelBody::by_group || kernels == PointKernels::of_plans;
}

/// Looks up the samples of known fields as points: those of the first lattice without a limit, with signs by crossings;
/// those of the second within a limit, with signs by the sides of faces, and from records that are made from kept
/// frusta. The first has points that are as near to more faces than a list holds.
/// If the device orders them, not all at once: it may have little memory.
std::optional<std::string> point_difference(const Device& device, const engine::Programs& programs,
                                            PointKernels kernels) {
    const bool are_scanned = kernels == PointKernels::of_many;
    constexpr double limit = 2.5;
    const bool are_ordered = is_by_device(programs, kernels);
    const auto pool = std::make_shared<device::BufferPool>(device::shared_context_of(device));
    for (const bool from_kept_frusta : {false, true}) {
        const KnownField known = from_kept_frusta ? KnownField({.on_surface = true}).within(limit)
                                                  : KnownField(KnownFieldKind{.wide = true, .many_at_vertex = true});
        engine::KeptMesh kept_mesh(device::context_of(device), pool, known.mesh(), {programs});
        if (from_kept_frusta && are_scanned) kept_mesh.frusta();
        points::KeptPoints kept(kept_mesh);
        points::PointInputs inputs;
        inputs.mesh = kept.faces();
        inputs.host_mesh = [&kept] { return kept.mesh(); };
        inputs.host_tree = [&kept] { return kept.wide_tree(); };
        inputs.has_deep_stack = kernels == PointKernels::of_deep_trees;
        inputs.sign = SignRule::nonzero;
        if (programs.body == KernelBody::by_group)
            inputs.tree = kept.fitted_tree();
        else
            inputs.leaves = kept.wide_leaves();
        if (are_ordered) {
            inputs.triangles = kept.triangles();
            inputs.sign_faces = kept.sign_faces(inputs.sign);
        }
        if (are_scanned) inputs.scanned = kept.scanned_mesh();
        inputs.sites = kept_mesh.sites(true, true);
        if (from_kept_frusta) inputs.sides = kept.face_sides(inputs.sign, true);
        const std::vector<Vec3> positions = positions_of(known.grid());
        device::InFlight<targets::OwnArrays> own(kept_mesh.context());
        own.begin();
        const targets::HostArrays arrays =
            own->for_samples(arrays_of(every_output(), !from_kept_frusta, true), positions.size());
        for (std::size_t begin = 0, count = 0; begin < positions.size(); begin += count) {
            count = std::min(are_ordered ? looked_up_together : positions.size(), positions.size() - begin);
            points::query_points(kept_mesh.tools(), inputs, std::span(positions).subspan(begin, count),
                                 known.band().outside, targets::arrays_from(begin, arrays), {});
        }
        own.end();
        if (auto difference = known.difference(arrays)) return difference;
    }
    return std::nullopt;
}

}  // namespace

std::vector<FieldKernels> kernels_of(const engine::Workshop& workshop, const engine::Job& job) {
    std::vector<FieldKernels> kernels{FieldKernels::of_all};
    if (!workshop.method && !engine::has_uniform_bounds(job.layout)) kernels.push_back(FieldKernels::of_wide_bands);
    return kernels;
}

TestSubject field_subject(const engine::Workshop& workshop, const engine::Job& job, FieldKernels kernels) {
    const Device& device = workshop.device;
    const engine::Programs& programs = workshop.programs;
    const engine::BrickVariant variant{job.outputs != OutputSet{}, job.counts, engine::has_long_bricks(job.grid)};
    std::shared_ptr<const FieldMethod> method;
    if (workshop.method)
        method = device::guarded([&] { return workshop.method->tested_as(workshop.context(), job.layout, variant); });
    std::vector<KnownFieldKind> kinds;
    for (const TestedField& field : tested_fields)
        if (field.kernels == kernels && !(method && (field.kind.fine || field.kind.on_surface)))
            kinds.push_back(field.kind);
    const bool are_first = kernels == FieldKernels::of_all;
    TestSubject subject;
    subject.name = fmt::format("{} {}{}{}", device::name_of(programs.body), method ? method->name() : "bricks",
                               engine::options_of(variant), names_of_kernels[static_cast<std::size_t>(kernels)]);
    subject.steps = (are_first ? programs.field_programs + (programs.mesh_lanes() == 1 ? 1 : 0) +
                                     (method ? method->step_count() : 1)
                               : 0) +
                    2 * kinds.size();
    subject.build = [&device, &programs, method, variant](const device::BuildWatch& watch) {
        device::Context& context = device::context_of(device);
        std::vector<cl::Program> all = programs.of_fields(watch);
        for (cl::Program& program : method ? method->build(context, programs, variant, watch)
                                           : std::vector{programs.bricks(context, variant, watch)})
            all.push_back(std::move(program));
        return all;
    };
    subject.difference = [&device, &programs, method, variant, kinds,
                          kernels](const device::BuildWatch& watch) -> std::optional<std::string> {
        const engine::Workshop tested{device, std::make_shared<device::BufferPool>(device::shared_context_of(device)),
                                      programs, method, SignRule::nonzero};
        for (KnownFieldKind kind : kinds) {
            engine::KeptMesh kept_mesh(tested.context(), tested.pool, KnownField({}).mesh(),
                                       {.programs = programs, .method = method, .is_whole = true});
            // As on every lattice but the first.
            if (kernels == FieldKernels::of_kept_frusta) kept_mesh.frusta();
            kind.long_bricks = variant.long_bricks;
            const auto& difference_of =
                kernels == FieldKernels::of_sparse_fields ? sparse_difference : field_difference;
            if (auto difference = difference_of(tested, kept_mesh, kind, variant, watch)) return difference;
        }
        return std::nullopt;
    };
    return subject;
}

TestSubject point_subject(const Device& device, const engine::Programs& programs, PointKernels kernels) {
    TestSubject subject;
    subject.name =
        fmt::format("{} {}points{}", device::name_of(programs.body), kernels == PointKernels::of_many ? "many " : "",
                    kernels == PointKernels::of_deep_trees ? " in deep trees"
                    : kernels == PointKernels::of_plans    ? " of plans"
                                                           : "");
    std::vector<engine::LazyProgram> needed{programs.points};
    if (is_by_device(programs, kernels))
        needed.insert(needed.end(), {programs.radix_sort, programs.point_order, programs.point_signs});
    if (programs.body == KernelBody::by_group) {
        const bool are_deep = kernels == PointKernels::of_deep_trees;
        needed.insert(needed.end(),
                      {programs.scan, programs.binary_tree, are_deep ? programs.nearest_deep : programs.nearest});
    }
    if (kernels == PointKernels::of_many) needed.insert(needed.end(), {programs.face_records, programs.point_scan});
    subject.steps = needed.size();
    subject.build = [needed](const device::BuildWatch& watch) {
        std::vector<cl::Program> built;
        for (const engine::LazyProgram& program : needed) built.push_back(program.get(watch));
        return built;
    };
    subject.difference = [&device, &programs, kernels](const device::BuildWatch&) {
        return point_difference(device, programs, kernels);
    };
    return subject;
}

TestSubject topology_subject(const engine::Workshop& workshop) {
    TestSubject subject;
    subject.name = fmt::format("{} topology", device::name_of(workshop.programs.body));
    subject.steps = 3;
    subject.build = [&workshop](const device::BuildWatch& watch) -> std::vector<cl::Program> {
        return {workshop.programs.radix_sort.get(watch), workshop.programs.mesh_topology.get(watch),
                workshop.programs.face_records.get(watch)};
    };
    subject.difference = [&workshop](const device::BuildWatch&) {
        const engine::DeviceSetUp set_up{workshop.tools()};
        auto difference = topology_difference(set_up, mesh_of_known_topology());
        return difference ? difference : sweep_difference(set_up);
    };
    return subject;
}

bool ensure_tested(const Device& device, const TestSubject& subject, const device::BuildWatch& watch) {
    device::Context& context = device::context_of(device);
    if (context.is_tested(subject.name)) return false;
    return device::guarded([&] {
        const std::string key = key_of(context, subject, watch);  // builds: other threads need not wait for that
        const std::scoped_lock lock(context.test_mutex());
        if (context.is_tested(subject.name)) return false;
        const device::Records records = context.records();
        const bool is_run = !is_switched_off() && !records.has(key);
        if (is_run) {
            if (const std::optional<std::string> difference = subject.difference(watch))
                throw Error(ErrorCode::wrong_results,
                            fmt::format("{} computes wrong fields, so it is not used. In a small known field, computed "
                                        "by the kernels \"{}\", {}. The OpenCL compiler or driver is at fault: update "
                                        "it, or take another device (\"clsdf devices\" lists them, --device or "
                                        "CLSDF_DEVICE chooses)",
                                        context.description(), subject.name, *difference));
            records.note(key);
        }
        context.set_tested(subject.name);
        return is_run;
    });
}

}  // namespace clsdf::checks
