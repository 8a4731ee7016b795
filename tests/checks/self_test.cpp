#include "support/deep_mesh.hpp"
#include "support/exact_field.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/fraction_plan.hpp>
#include <clsdf/fractions.hpp>
#include <clsdf/papers.hpp>
#include <clsdf/tuning.hpp>

#include "device/context.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr KernelBody vector_body = KernelBody::by_vector, group_body = KernelBody::by_group;

/// A device with programs of its own, whose kernels' text is changed, and which keeps records in `folder`.
struct Changed {
    std::string file;  ///< empty: nothing is changed
    std::string from;
    std::string to;
    bool is_found = false;

    Device device(const std::string& folder) {
        Device device = Device::strongest();
        device.keep_records(folder);
        device::context_of(device).set_text_edit([this](std::string_view name, std::string& text) {
            if (name != file) return;
            const std::size_t at = text.find(from);
            if (at == std::string::npos) return;
            is_found = true;
            text.replace(at, from.size(), to);
        });
        return device;
    }
};

const Band narrow = Band::symmetric(0.1);

/// The first calls of a program.
using Use = std::function<TransformStatistics(const Device&, KernelBody, const CallOptions&)>;

Use fields(OutputSet outputs, bool has_long_bricks = false, bool count_work = false) {
    return [=](const Device& device, KernelBody body, CallOptions call) {
        call.count_work = count_work;
        const Mesh mesh = make_shape("cube");
        Grid grid = Grid::around(mesh, 16, narrow);
        if (has_long_bricks) grid.spacing[2] *= 1.7;
        return DistanceTransform(device, mesh, {.body = body}).compile(grid, narrow, outputs, call);
    };
}

const Use distances = fields(Output::distance), outputs = fields(all_outputs()),
          long_outputs = fields(all_outputs(), true), counted = fields(Output::triangle, false, true);

TransformStatistics in_a_wide_band(const Device& device, KernelBody body, const CallOptions& call) {
    const Mesh mesh = make_shape("cube");
    return DistanceTransform(device, mesh, {.body = body})
        .compile(Grid::around(mesh, 16, narrow), Band::full(), Output::distance, call);
}

TransformStatistics on_a_later_lattice(const Device& device, KernelBody body, const CallOptions& call) {
    const Mesh mesh = make_shape("cube");
    const DistanceTransform transform(device, mesh, {.body = body});
    transform.compute(Grid::around(mesh, 16, narrow), narrow);
    TransformStatistics statistics;
    transform.compute(Grid::around(mesh, 17, narrow), narrow, Output::distance, call, &statistics);
    return statistics;
}

Use sparse_fields(OutputSet extras) {
    return [=](const Device& device, KernelBody body, const CallOptions& call) {
        const Mesh mesh = make_shape("cube");
        TransformStatistics statistics;
        DistanceTransform(device, mesh, {.body = body})
            .compute_sparse(Grid::around(mesh, 16, narrow), narrow, extras, call, &statistics);
        return statistics;
    };
}

TransformStatistics exact_signs(const Device& device, KernelBody body, const CallOptions& call) {
    const Mesh mesh = make_shape("cube");
    TransformStatistics statistics;
    DistanceTransform(device, mesh, {.body = body})
        .compute(Grid::around(mesh, 16, narrow), narrow.with_exact_signs(), Output::distance, call, &statistics);
    return statistics;
}

TransformStatistics links(const Device& device, KernelBody body, const CallOptions& call) {
    const Mesh mesh = make_shape("cube");
    TransformStatistics statistics;
    DistanceTransform(device, mesh, {.body = body})
        .links(Grid::around(mesh, 16, narrow), stencil("D3Q19"), {}, call, &statistics);
    return statistics;
}

Use slices(SliceMinimum minimum) {
    return [=](const Device& device, KernelBody body, const CallOptions& call) {
        const Mesh mesh = make_shape("cube");
        return make_transform(device, mesh, {.scan = Scan::slices, .slice_minimum = minimum}, {.body = body})
            .compile(Grid::around(mesh, 16, narrow), narrow, Output::distance, call);
    };
}

Use points(std::size_t count) {
    return [=](const Device& device, KernelBody body, const CallOptions& call) {
        const std::vector<Vec3> all(count, {0.5, 0, 0});
        std::vector<float> distance(count);
        return DistanceTransform(device, make_shape("cube"), {.body = body}).query(all, 1, distance, call);
    };
}

const Use few_points = points(500), many_points = points(20000);

TransformStatistics points_in_a_deep_tree(const Device& device, KernelBody body, const CallOptions& call) {
    const std::vector<Vec3> all(500, {0.5, 0, 0});
    std::vector<float> distance(all.size());
    return DistanceTransform(device, deep_mesh(4096), {.sign = SignRule::none, .body = body})
        .query(all, 1, distance, call);
}

/// A plan for an array with gaps.
TransformStatistics boxes(const Device& device, KernelBody body, const CallOptions& call) {
    const Mesh mesh = make_shape("cube");
    const Grid grid = Grid::around(mesh, 16, narrow);
    constexpr std::ptrdiff_t stride = 2 * sizeof(float);
    const cl::Buffer memory(device::context_of(device).context(), CL_MEM_READ_WRITE, stride * grid.sample_count());
    OutputArray target(memory());
    target.strides = {stride, stride * grid.size[0], stride * grid.size[0] * grid.size[1]};
    return DistanceTransform(device, mesh, {.body = body}).plan({grid, narrow, target}, call).statistics();
}

TransformStatistics sparse_plan(const Device& device, KernelBody body, const CallOptions& call) {
    const Mesh mesh = make_shape("cube");
    return DistanceTransform(device, mesh, {.body = body})
        .plan_sparse({Grid::around(mesh, 16, narrow), narrow}, {1, 1}, call)
        .statistics();
}

TransformStatistics fraction_plan(const Device& device, KernelBody, const CallOptions& call) {
    const OuterSurface surface = outer(make_shape("cube"));
    return FractionPlan(device, surface, Grid::around(surface.mesh.box(), {.resolution = 8}), 1000, {}, call)
        .statistics();
}

}  // namespace

BOOST_AUTO_TEST_SUITE(the_self_test)

BOOST_AUTO_TEST_CASE(passes_with_every_program_in_as_many_steps_as_it_tells) {
    for (const KernelBody body : {vector_body, group_body})
        for (const Use& use :
             {distances, outputs, long_outputs, counted, slices(SliceMinimum::one_pass),
              slices(SliceMinimum::two_passes), few_points, many_points, Use(boxes), Use(sparse_plan)}) {
            Changed nothing;
            const Device device = nothing.device("");
            std::vector<Progress> steps;
            CallOptions call;
            call.progress = [&](const Progress& progress) {
                if (progress.stage != Progress::Stage::computing) steps.push_back(progress);
            };
            BOOST_TEST(use(device, body, call).first_use);
            BOOST_TEST(steps.back().step == steps.back().steps);
            if (steps.front().steps > 1) BOOST_TEST(steps.front().steps == steps.back().steps);
            steps.clear();
            BOOST_TEST(!use(device, body, call).first_use);
            BOOST_TEST(steps.empty());
        }
}

// Each changed line of a kernel stands for wrong code that a compiler makes of a right line.
BOOST_AUTO_TEST_CASE(refuses_wrong_kernels_before_the_first_result) {
    const std::string by_vector = "bricks_by_vector.cl", by_group = "bricks_by_group.cl", records = "face_records.cl",
                      nearest = "nearest_by_group.cl";
    struct Mutation {
        const char* what;
        Use use;
        std::vector<KernelBody> bodies;
        Changed changed;
    };
    const std::vector<KernelBody> both{vector_body, group_body}, vectors{vector_body}, groups{group_body};
    const std::string fill = "inside ? inside_fill : outside_fill";
    const std::vector<Mutation> mutations{
        {"wrong distance at the face",
         distances,
         vectors,
         {by_vector, "outward = GREATER(r, zero)", "outward = GREATER(r, (Real)0.01f)"}},
        {"wrong sign",
         distances,
         vectors,
         {by_vector, "(negative ? 0.0f - GREATER(length, least)", "(negative ? GREATER(length, least)"}},
        {"a missed brick",
         distances,
         vectors,
         {by_vector, "used |= (ulong)has_distances(minima + b) << b",
          "used |= (ulong)(b && has_distances(minima + b)) << b"}},
        {"the polyhedron of the lane beside it",
         long_outputs,
         vectors,
         {by_vector, "polyhedra + queue->numbers[n];", "polyhedra + queue->numbers[n == 5 ? 4 : n];"}},
        {"slender polyhedra's samples beside their places",
         distances,
         vectors,
         {by_vector, "sample_i = samples & 31u", "sample_i = (samples + 1u) & 31u"}},
        {"displacements of the lane beside it",
         distances,
         vectors,
         {by_vector, "displacements->x + lane", "displacements->x + (lane ^ 1u)"}},
        {"a crossing of the surface too few",
         distances,
         vectors,
         {"sign_sweep.cl", "if (orientation == 0)", "if (orientation == 0 || rows.begin_z == rows.end_z)"}},
        {"a slice of a large triangle's rows too few",
         distances,
         vectors,
         {"sign_sweep.cl", "begin_z + slices * strip / strips;", "begin_z + slices * strip / strips + 1;"}},
        {"a triangle beside its place",
         distances,
         both,
         {records, "to_foot = is_right ? f.right : -f.left;", "to_foot = is_right ? f.right : f.left;"}},
        {"records of other faces, from kept frusta",
         on_a_later_lattice,
         both,
         {records, "groups[n / CLSDF_RECORD_GROUP]", "groups[0]"}},
        {"too small bounds, in wide bands",
         in_a_wide_band,
         vectors,
         {"coarse_lists.cl", "sqrt(least[layer]) * (1.0f + 1.0e-5f)", "sqrt(least[layer]) * 0.2f"}},
        {"too small bounds, in wide bands",
         in_a_wide_band,
         groups,
         {"coarse_lists_by_group.cl", "sqrt(least[layer]) * (1.0f + 1.0e-5f)", "sqrt(least[layer]) * 0.2f"}},
        {"a brick that is not listed",
         sparse_fields(Output::distance),
         vectors,
         {by_vector, "if (has_band(layout, brick,", "if (b && has_band(layout, brick,"}},
        {"a brick's values in the place of another",
         sparse_fields(Output::triangle),
         groups,
         {by_group, "(size_t)at * CLSDF_BRICK_SAMPLES", "(size_t)(at ^ 1u) * CLSDF_BRICK_SAMPLES"}},
        {"bricks inside that are not marked",
         sparse_fields(Output::distance),
         both,
         {"fill.cl", "is_mixed ? 1 : CLSDF_INSIDE_BRICK", "is_mixed ? 1 : 0"}},
        {"a fill with the other side's limit", distances, both, {"fill.cl", fill, "inside_fill"}},
        {"a fill with the other side's limit", distances, both, {"fill.cl", fill, "outside_fill"}},
        {"outputs that are not left out", outputs, both, {"fill.cl", "store_ones(run_begin, run_end);\n}", "}"}},
        {"a missed brick",
         outputs,
         groups,
         {by_group, "if (any(relative_brick < 0)", "if (b == 0 || any(relative_brick < 0)"}},
        {"the lane beside it",
         outputs,
         groups,
         {by_group, "sample_of(b, number % SMALL_SUBBLOCK_SAMPLES)) - BRICK_CENTRE",
          "sample_of(b, (number + 1) % SMALL_SUBBLOCK_SAMPLES)) - BRICK_CENTRE"}},
        {"the minima of a share that are not joined",
         distances,
         groups,
         {by_group, "is_join && n < task.shares", "is_join && n + 1 < task.shares"}},
        {"another polyhedron out of a share",
         outputs,
         groups,
         {by_group, "polyhedron = set[512 + s * GROUP + get_local_id(0)]", "polyhedron = set[512 + get_local_id(0)]"}},
        {"a wrong triangle",
         outputs,
         groups,
         {by_group, "nearest = better ? chosen[n] : nearest",
          "nearest = better ? chosen[n] + (chosen[n] % 8 == 3) : nearest"}},
        {"a row too few",
         slices(SliceMinimum::two_passes),
         vectors,
         {"slices.cl", "int end = layout.first[1] + (int)(LESSER(high, last) - first) + 1",
          "int end = layout.first[1] + (int)(LESSER(high, last) - first)"}},
        {"a wrong counter",
         counted,
         vectors,
         {by_vector, "counters[CLSDF_COUNT_BAND] += popcount", "counters[CLSDF_COUNT_BAND] += 1 + popcount"}},
        {"a gradient without the sign",
         outputs,
         groups,
         {by_group, "nearest->sign / sqrt(squared)", "1.0 / sqrt(squared)"}},
        {"a gradient that is no number",
         outputs,
         groups,
         {by_group, "nearest->sign / sqrt(squared)", "nearest->sign / sqrt(-squared)"}},
        {"a closest point on the other side",
         outputs,
         groups,
         {by_group, "nearest->position - offset_of(nearest)", "nearest->position + offset_of(nearest)"}},
        {"an offset that points away from the surface",
         outputs,
         vectors,
         {by_vector, "store_vectors(-(rows->x * unit)", "store_vectors((rows->x * unit)"}},
        {"a distance in double with the digits of a float",
         outputs,
         groups,
         {by_group, "const double length = LESSER(root, most),", "const double length = (float)LESSER(root, most),"}},
        {"a distance in double with the digits of a float",
         outputs,
         vectors,
         {by_vector, "sqrt(rows->squared) * how.unit", "TO_DOUBLES(TO_FLOATS(sqrt(rows->squared))) * how.unit"}},
        {"barycentric coordinates of the other way along an edge",
         outputs,
         groups,
         {by_group, "named.is_reversed ? 1.0 - first : first", "first"}},
        {"a gradient without the sign",
         outputs,
         vectors,
         {by_vector, "select((doubleL)1.0, (doubleL)-1.0, TO_LONGS(inside))", "(doubleL)1.0"}},
        {"a gradient on the surface of another site",
         outputs,
         vectors,
         {by_vector, "6 * (size_t)p->triangle + site_of_triangle(p, nearest->frame_site)", "6 * (size_t)p->triangle"}},
        {"another site",
         outputs,
         vectors,
         {by_vector, "(uchar)told_site(finishing, named)", "(uchar)(named.site == 4u ? 5u : named.site)"}},
        {"coordinates of the sample beside it",
         outputs,
         vectors,
         {by_vector, "store(EIGHT_OF(high, z, Order, 3, 13, 4, 5, 14, 6, 7, 15), 2, to)",
          "store(EIGHT_OF(high, z, Order, 3, 13, 4, 5, 14, 6, 7, 14), 2, to)"}},
        {"signs of the other side",
         few_points,
         both,
         {"points.cl", "sides & (outward > 0.0 ?", "sides & (outward < 0.0 ?"}},
        {"signs of the other side",
         many_points,
         vectors,
         {"points.cl", "sides & (outward > 0.0 ?", "sides & (outward < 0.0 ?"}},
        {"a gradient without the sign",
         few_points,
         vectors,
         {"points.cl", "nearest->sign / sqrt(squared)", "1.0 / sqrt(squared)"}},
        {"a distance in double with the digits of a float",
         few_points,
         vectors,
         {"points.cl", "length > 0.0 ? length :", "length > 0.0 ? (float)length :"}},
        {"a face that is not taken, of more than a list holds",
         few_points,
         groups,
         {nearest, "bound_of_squared(squared[i])", "bound_of_squared(0.9 * squared[i])"}},
        {"a face that is not the nearest, in a deep tree",
         points_in_a_deep_tree,
         groups,
         {nearest, "lowest_face(all_faces, found.face)", "STACK == 32 ? lowest_face(all_faces, found.face) : 0u"}},
        {"a crossing that does not count",
         few_points,
         groups,
         {"point_signs.cl", "ray->winding += counts * crossing;", "ray->winding += counts - 1;"}},
        {"a triangle beside its place",
         many_points,
         vectors,
         {records, "to_foot = is_right ? f.right : -f.left;", "to_foot = is_right ? f.right : f.left;"}},
        {"records of other faces, after a field",
         many_points,
         vectors,
         {records, "groups[n / CLSDF_RECORD_GROUP]", "groups[0]"}},
        {"bricks in the places of others",
         sparse_plan,
         both,
         {"brick_order.cl", "other < number; ++other", "other + 1 < number; ++other"}},
        {"a run of bricks beyond its row",
         sparse_plan,
         vectors,
         {"brick_order.cl", "behind % row != 0 && marks", "marks"}},
        {"a sample on a wall that is inside",
         exact_signs,
         groups,
         {"exact_sides.cl", "is_tie ? looks & FORWARD_LOOKS : 0u", "is_tie ? looks : 0u"}},
        {"the highest of the triangles at a place",
         links,
         groups,
         {"links.cl", "crossed[i].triangle < crossed[lowest].triangle",
          "crossed[i].triangle > crossed[lowest].triangle"}},
        {"a cell's surface without the rest of its sums",
         fraction_plan,
         groups,
         {"cut_cells.cl", "to->rest += (to->sum - (sum - part)) + (value - part);", "to->rest = 0;"}},
        {"rows of floats in the places of doubles",
         fraction_plan,
         groups,
         {"store_cells.cl", "*(__global float*)target", "*(__global float*)to"}},
        {"a vertex on a plane that counts as below it",
         fraction_plan,
         groups,
         {"cut_cells.cl", "above_plane(p, axis, plane) >= 0", "above_plane(p, axis, plane) > 0"}},
        {"slices in the places of rows",
         boxes,
         vectors,
         {"box_store.cl", "z * box->strides[2]", "z * box->strides[1]"}},
    };
    const TemporaryFolder folder;
    // Each is compiled anew, so a run takes a part of them, CLSDF_MUTATIONS=PART/PARTS. The texts of the others must be
    // there.
    unsigned part = 0, parts = 3;
    if (const char* const given = std::getenv("CLSDF_MUTATIONS"))
        BOOST_REQUIRE((std::sscanf(given, "%u/%u", &part, &parts) == 2 && part < parts));
    BOOST_TEST_MESSAGE("mutations: part " << part << " of " << parts);
    for (std::size_t n = 0; n < mutations.size(); ++n) {
        const Mutation& mutation = mutations[n];
        const Changed& change = mutation.changed;
        // The papers' kernels are part of the build from their first use on.
        if (n % parts != part && change.file != "slices.cl") {
            BOOST_TEST(device::kernel_text(change.file).find(change.from) != std::string::npos,
                       "the text to be changed is no longer there: " << change.from);
            continue;
        }
        for (const KernelBody body : mutation.bodies) {
            Changed changed = mutation.changed;
            const Device device = changed.device(folder.file("cache"));
            BOOST_TEST_CONTEXT(mutation.what << " in " << changed.file)
            // Neither a second computation nor a second process takes it.
            for (int i = 0; i < 2; ++i)
                check_throws(ErrorCode::wrong_results,
                             {device.name(), device.platform(), "driver", "computes wrong fields", "clsdf devices"},
                             [&] { mutation.use(device, body, {}); });
            BOOST_TEST(changed.is_found, "the text to be changed is no longer there: " << changed.from);
        }
    }
}

BOOST_AUTO_TEST_CASE(stops_every_way_to_a_field) {
    Changed changed{"face_records.cl", "to_foot = is_right ? f.right : -f.left;",
                    "to_foot = is_right ? f.right : f.left;"};
    const Device device = changed.device("");
    const Mesh mesh = make_shape("cube");
    const DistanceTransform transform(device, mesh);
    const Grid grid = Grid::around(mesh, 16, narrow);
    const auto check = [](auto&& call) { check_throws(ErrorCode::wrong_results, {"computes wrong fields"}, call); };
    check([&] { transform.compute(grid, narrow); });
    check([&] { transform.plan(grid, narrow); });
    check([&] { transform.compile(grid, narrow); });
}

BOOST_AUTO_TEST_CASE(is_run_once_on_a_device_and_driver) {
    const TemporaryFolder folder;
    const Mesh mesh = make_shape("sphere3");
    const Band band = Band::symmetric(0.1);
    const Grid grid = Grid::around(mesh, 40, band);
    for (const bool first : {true, false}) {
        Changed nothing;
        const Device device = nothing.device(folder.file("cache"));
        DistanceTransform transform(device, mesh);
        TransformStatistics statistics;
        transform.compute(grid, band, Output::distance, {}, &statistics);
        BOOST_TEST(statistics.first_use == first);
        const double compile_seconds = statistics.compile_seconds;
        BOOST_TEST(compile_seconds > 0);
        transform.compute(grid, band, Output::distance, {}, &statistics);
        BOOST_TEST(!statistics.first_use);
        BOOST_TEST(statistics.compile_seconds < compile_seconds);
    }
    // Without files once in every process, and for each device that is opened.
    for (int i = 0; i < 2; ++i) {
        Changed nothing;
        const Device device = nothing.device("");
        DistanceTransform transform(device, mesh);
        BOOST_TEST(transform.compile(grid, band).first_use);
        BOOST_TEST(!transform.compile(grid, band).first_use);
    }
    // Fields without a sign need the same kernels, wide bands and kept frusta some more.
    {
        Changed nothing;
        const Device device = nothing.device("");
        DistanceTransform transform(device, mesh);
        BOOST_TEST(transform.compile(grid, band).first_use);
        BOOST_TEST(!DistanceTransform(device, mesh, {.sign = SignRule::none}).compile(grid, band).first_use);
        for (const bool first : {true, false}) BOOST_TEST(transform.compile(grid, Band::full()).first_use == first);
        TransformStatistics statistics;
        std::vector<bool> first_uses;
        for (const std::int64_t resolution : {32, 40, 48}) {
            transform.compute(Grid::around(mesh, resolution, band), band, Output::distance, {}, &statistics);
            first_uses.push_back(statistics.first_use);
        }
        BOOST_TEST(first_uses == std::vector<bool>({false, true, false}), boost::test_tools::per_element());
    }
    // Tested again on request.
    Changed nothing;
    const Device device = nothing.device(folder.file("cache"));
    device.forget_records();
    BOOST_TEST(DistanceTransform(device, mesh).compile(grid, band).first_use);
}

BOOST_AUTO_TEST_SUITE_END()
