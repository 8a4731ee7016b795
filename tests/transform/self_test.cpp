#include "support/exact_field.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/papers.hpp>
#include <clsdf/tuning.hpp>

#include "core/outputs.hpp"
#include "device/context.hpp"
#include "papers/scans.hpp"
#include "self_test/known_field.hpp"
#include "self_test/self_test.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;
using transform::KnownField;
using transform::KnownFieldKind;
using transform::PointTestCase;
using transform::TestCase;

namespace {

constexpr KernelBody vector_body = KernelBody::by_vector, group_body = KernelBody::by_group;

TestCase bricks(KernelBody body, bool triangle, bool count, bool long_bricks = false) {
    TestCase test_case;
    test_case.body = body;
    test_case.variant = {triangle, count, long_bricks};
    return test_case;
}

TestCase slices(KernelBody body, bool triangle, bool count, bool key_64) {
    TestCase test_case = bricks(body, triangle, count);
    test_case.method = papers::method_of(
        {.scan = Scan::slices, .slice_minimum = key_64 ? SliceMinimum::one_pass : SliceMinimum::two_passes});
    return test_case;
}

TestCase wide(TestCase test_case) {
    test_case.is_wide = true;
    return test_case;
}
TestCase later(TestCase test_case) {
    test_case.is_later = true;
    return test_case;
}
TestCase without_sign(TestCase test_case) {
    test_case.is_signed = false;
    return test_case;
}

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

/// A field as packed arrays.
scan::HostArrays arrays_of(Field& field) {
    scan::HostArrays arrays;
    for (const OutputInfo& info : output_table()) {
        const std::span<std::byte> bytes = field.bytes(info.output);
        arrays[info.output] = {!bytes.empty(), info.type == ElementType::float64, bytes.data()};
    }
    return arrays;
}

/// The message of the error that test() throws; it must be of wrong results.
template <typename Test>
std::string message_of(const Test& test) {
    try {
        test();
    } catch (const Error& error) {
        BOOST_TEST((error.code() == ErrorCode::wrong_results));
        return error.what();
    }
    return {};
}

std::string message_of_test(const Device& device, const TestCase& test_case) {
    return message_of([&] {
        const scan::Programs programs(device::context_of(device), test_case.body);
        transform::ensure_tested(device, programs, test_case);
    });
}

std::string message_of_point_test(const Device& device, KernelBody body, const PointTestCase& test_case) {
    return message_of([&] {
        const scan::Programs programs(device::context_of(device), body);
        transform::ensure_points_tested(device, programs, test_case);
    });
}

/// A device with the changed kernel is refused: by the first use, and by the next one.
template <typename MessageOfTest>
void check_refusal(const char* what, Changed& changed, const std::string& folder,
                   const MessageOfTest& message_of_test) {
    const Device device = changed.device(folder);
    const std::string message = message_of_test(device);
    BOOST_TEST_CONTEXT(what << " in " << changed.file) {
        BOOST_TEST(changed.is_found, "the text to be changed is no longer there");
        BOOST_TEST_MESSAGE(message);
        for (const std::string& part : {device.name(), device.platform(), std::string("driver"), std::string("sample"),
                                        std::string("clsdf devices")})
            BOOST_TEST(message.find(part) != std::string::npos, "no '" << part << "' in '" << message << "'");
        // Neither a second computation nor a second process takes it.
        BOOST_TEST(!message_of_test(device).empty());
    }
}

}  // namespace

BOOST_AUTO_TEST_SUITE(the_known_field)

BOOST_AUTO_TEST_CASE(is_the_reference_s_field) {
    for (const KnownFieldKind& kind :
         {KnownFieldKind{}, KnownFieldKind{.long_bricks = true}, KnownFieldKind{.wide = true},
          KnownFieldKind{.later = true}, KnownFieldKind{.wide = true, .later = true},
          KnownFieldKind{.long_bricks = true, .later = true}}) {
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
        BOOST_TEST((sites_on_surface(0, 6) > 0) == kind.later);
        if (kind.wide) continue;
        BOOST_TEST(has([&](float d) { return d == static_cast<float>(known.band().outside); }));
        BOOST_TEST(has([&](float d) { return d == -static_cast<float>(known.band().inside); }));
        BOOST_TEST(has([&](float d) { return d > 0 && d < 0.5F; }));
        BOOST_TEST(has([&](float d) { return d < 0 && d > -0.5F; }));
    }
}

BOOST_AUTO_TEST_CASE(has_coarse_bricks_without_polyhedra_inside_and_outside) {
    for (const KernelBody body : {vector_body, group_body})
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

BOOST_AUTO_TEST_CASE(tells_every_kind_of_difference) {
    const KnownField known({});
    DistanceTransform transform(test_device(), known.mesh(), {.sign = SignRule::nonzero});
    const Field right = transform.compute(known.grid(), known.band(), all_outputs());
    const auto differs = [&](auto&& change) {
        Field field = right;
        change(field);
        return known.difference(arrays_of(field)).has_value();
    };
    std::size_t in_band = 0, beyond = 0;
    while (right.triangle()[in_band] == 0xFFFFFFFFU) ++in_band;
    while (right.triangle()[beyond] != 0xFFFFFFFFU) ++beyond;
    BOOST_TEST(!differs([](Field&) {}));
    BOOST_TEST(differs([&](Field& field) { field.distance()[in_band] += 1e-4F; }));
    BOOST_TEST(differs([&](Field& field) { field.distance()[beyond] = -field.distance()[beyond]; }));
    BOOST_TEST(differs([&](Field& field) { field.distance()[0] = std::numeric_limits<float>::quiet_NaN(); }));
    BOOST_TEST(differs([&](Field& field) { field.triangle()[in_band] = 0xFFFFFFFFU; }));
    BOOST_TEST(differs([&](Field& field) { field.triangle()[in_band] = 1000; }));
    BOOST_TEST(differs([&](Field& field) { field.triangle()[beyond] = 0; }));
    for (const unsigned site : {0U, 1U, 2U, 3U, 4U, 5U, 6U, 7U, 255U})
        BOOST_TEST(differs([&](Field& field) { field.site()[in_band] = static_cast<std::uint8_t>(site); }) ==
                   (site != right.site()[in_band]));
    for (std::size_t k = 0; k < 3; ++k) {
        BOOST_TEST(differs([&](Field& field) { field.closest()[3 * in_band + k] += 1e-3; }));
        BOOST_TEST(differs([&](Field& field) { field.gradient()[3 * in_band + k] += 1e-3F; }));
        BOOST_TEST(
            differs([&](Field& field) { field.gradient()[3 * in_band + k] = -field.gradient()[3 * in_band + k]; }));
        BOOST_TEST(differs([&](Field& field) { field.closest()[3 * beyond + k] = 0; }));
        BOOST_TEST(differs([&](Field& field) { field.gradient()[3 * beyond + k] = 0; }));
    }
    for (std::size_t k = 0; k < 2; ++k) {
        BOOST_TEST(differs([&](Field& field) { field.barycentric()[2 * in_band + k] += 1e-3F; }));
        BOOST_TEST(differs([&](Field& field) { field.barycentric()[2 * beyond + k] = 0; }));
    }
    BOOST_TEST(differs([&](Field& field) { field.site()[beyond] = 6; }));
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(the_self_test)

BOOST_AUTO_TEST_CASE(passes_with_every_program_and_launch_of_real_calls) {
    for (const TestCase& test_case :
         {bricks(vector_body, false, false), bricks(vector_body, true, true), bricks(vector_body, true, false, true),
          bricks(group_body, true, true), bricks(group_body, false, false, true), slices(vector_body, true, true, true),
          slices(vector_body, true, false, false), slices(group_body, false, false, false),
          wide(bricks(vector_body, false, false)), wide(bricks(group_body, true, true)),
          later(bricks(vector_body, false, false)), later(bricks(group_body, true, true)),
          without_sign(bricks(vector_body, false, false))}) {
        const scan::Programs programs(device::context_of(test_device()), test_case.body);
        const auto difference = transform::run_self_test(test_device(), programs, test_case);
        BOOST_TEST(!difference.has_value(), test_case.name() << ": " << difference.value_or(""));
    }
}

BOOST_AUTO_TEST_CASE(passes_with_every_query_of_points) {
    for (const KernelBody body : {vector_body, group_body})
        for (const PointTestCase& test_case : {PointTestCase{}, PointTestCase{.are_scanned = true},
                                               PointTestCase{.are_scanned = true, .is_later = true}}) {
            if (test_case.are_scanned && body == group_body) continue;  // which looks up all points one by one
            Changed nothing;
            BOOST_TEST(message_of_point_test(nothing.device(""), body, test_case) == "");
        }
}

// Each changed line of a kernel stands for wrong code that a compiler makes of a right line.
BOOST_AUTO_TEST_CASE(refuses_a_device_that_computes_something_else) {
    const TemporaryFolder folder;
    struct Mutation {
        const char* what;
        TestCase test_case;
        Changed changed;
    };
    const std::string vector_file = "bricks_by_vector.cl", group_file = "bricks_by_group.cl";
    std::vector<Mutation> mutations{
        {"wrong distance at the face",
         bricks(vector_body, false, false),
         {vector_file, "outward = GREATER(r, zero)", "outward = GREATER(r, (Real)0.01f)"}},
        {"wrong sign",
         bricks(vector_body, false, false),
         {vector_file, "(length != 0.0f)) ? -length : length)", "(length != 0.0f)) ? length : length)"}},
        {"a missed brick",
         bricks(vector_body, false, false),
         {vector_file, "used |= (ulong)has_distances(minima + b) << b",
          "used |= (ulong)(b && has_distances(minima + b)) << b"}},
        {"the polyhedron of the lane beside it",
         bricks(vector_body, true, false, true),
         {vector_file, "polyhedra + queue->numbers[n];", "polyhedra + queue->numbers[n == 5 ? 4 : n];"}},
        {"a crossing of the surface too few",
         bricks(vector_body, false, false),
         {"sign_sweep.cl", "if (orientation == 0)", "if (orientation == 0 || rows.begin_z == rows.end_z)"}},
        {"a slice of a large triangle's rows too few",
         bricks(vector_body, false, false),
         {"sign_sweep.cl", "begin_z + slices * strip / strips;", "begin_z + slices * strip / strips + 1;"}},
        {"a triangle beside its place",
         bricks(vector_body, false, false),
         {"mesh_records.cl", "to_foot = is_right ? f.right : -f.left;", "to_foot = is_right ? f.right : f.left;"}},
        {"a missed brick",
         bricks(group_body, true, false),
         {group_file, "if (any(relative_brick < 0)", "if (b == 0 || any(relative_brick < 0)"}},
        {"the lane beside it",
         bricks(group_body, true, false),
         {group_file, "sample_of(b, number % SMALL_SUBBLOCK_SAMPLES)) - BRICK_CENTRE",
          "sample_of(b, (number + 1) % SMALL_SUBBLOCK_SAMPLES)) - BRICK_CENTRE"}},
        {"a wrong triangle",
         bricks(group_body, true, false),
         {group_file, "nearest = better ? chosen[n] : nearest",
          "nearest = better ? chosen[n] + (chosen[n] % 8 == 3) : nearest"}},
        {"a row too few",
         slices(vector_body, false, false, false),
         {"slices.cl", "int end = layout.first[1] + (int)(LESSER(high, last) - first) + 1",
          "int end = layout.first[1] + (int)(LESSER(high, last) - first)"}},
        {"a wrong counter",
         bricks(vector_body, true, true),
         {vector_file, "counters[CLSDF_COUNT_BAND] += popcount", "counters[CLSDF_COUNT_BAND] += 1 + popcount"}},
    };
    for (Mutation& mutation : mutations)
        check_refusal(mutation.what, mutation.changed, folder.file("cache"),
                      [&](const Device& device) { return message_of_test(device, mutation.test_case); });
}

BOOST_AUTO_TEST_CASE(refuses_wrong_distances_of_slender_and_of_other_polyhedra_in_narrow_and_wide_bands) {
    const TemporaryFolder folder;
    const std::string file = "bricks_by_vector.cl";
    const TestCase plain = bricks(vector_body, false, false);
    for (const TestCase& test_case : {plain, wide(plain)})
        for (Changed changed : {Changed{file, "sample_i = samples & 31u", "sample_i = (samples + 1u) & 31u"},
                                Changed{file, "displacements->x + lane", "displacements->x + (lane ^ 1u)"}})
            check_refusal(test_case.name().c_str(), changed, folder.file("cache"),
                          [&](const Device& device) { return message_of_test(device, test_case); });
}

// The group body leaves to the fill only coarse bricks that no polyhedron overlaps.
BOOST_AUTO_TEST_CASE(refuses_a_wrong_fill_inside_and_outside_of_either_body) {
    const TemporaryFolder folder;
    const std::string right = "inside ? inside_fill : outside_fill";
    for (const KernelBody body : {vector_body, group_body}) {
        for (const char* wrong : {"inside_fill", "outside_fill"}) {
            Changed changed{"fill.cl", right, wrong};
            check_refusal(wrong, changed, folder.file("cache"),
                          [&](const Device& device) { return message_of_test(device, bricks(body, false, false)); });
        }
        Changed changed{"fill.cl", "store_ones(run_begin, run_end);\n}", "}"};
        check_refusal("outputs that are not left out", changed, folder.file("cache"),
                      [&](const Device& device) { return message_of_test(device, bricks(body, true, false)); });
    }
}

BOOST_AUTO_TEST_CASE(refuses_wrong_records_of_a_later_lattice) {
    const TemporaryFolder folder;
    for (const KernelBody body : {vector_body, group_body}) {
        Changed changed{"mesh_records.cl", "groups[n / CLSDF_RECORD_GROUP]", "groups[0]"};
        check_refusal("records of other faces", changed, folder.file("cache"),
                      [&](const Device& device) { return message_of_test(device, later(bricks(body, false, false))); });
    }
}

// Drivers compile a kernel at its first launch.
BOOST_AUTO_TEST_CASE(runs_the_kernel_of_later_lattices_only_if_they_are_tested) {
    const TemporaryFolder folder;
    for (const KernelBody body : {vector_body, group_body}) {
        Changed changed{"mesh_records.cl", "faces[lane] = min(face + lane, face_count - 1)", "faces[lane] = 0"};
        BOOST_TEST(message_of_test(changed.device(folder.file("cache")), bricks(body, false, false)) == "");
        BOOST_TEST(changed.is_found);
    }
}

BOOST_AUTO_TEST_CASE(refuses_wrong_outputs) {
    const TemporaryFolder folder;
    const std::string vector_file = "bricks_by_vector.cl", group_file = "bricks_by_group.cl";
    struct Mutation {
        const char* what;
        KernelBody body;
        Changed changed;
    };
    std::vector<Mutation> mutations{
        {"a gradient without the sign",
         group_body,
         {group_file, "nearest->sign / sqrt(squared)", "1.0 / sqrt(squared)"}},
        {"a closest point in double on the other side",
         group_body,
         {group_file, "nearest->position - offset", "nearest->position + offset"}},
        {"a distance in double with the digits of a float",
         group_body,
         {group_file, "const double length = LESSER(root, most);", "const double length = (float)LESSER(root, most);"}},
        {"a distance in double with the digits of a float",
         vector_body,
         {vector_file, "sqrt(rows->squared) * how.unit", "TO_DOUBLES(TO_FLOATS(sqrt(rows->squared))) * how.unit"}},
        {"barycentric coordinates of the other way along an edge",
         group_body,
         {group_file, "named.is_reversed ? 1.0 - first : first", "first"}},
        {"a gradient without the sign",
         vector_body,
         {vector_file, "select((doubleL)1.0, (doubleL)-1.0, TO_LONGS(inside))", "(doubleL)1.0"}},
        {"a gradient on the surface of another site",
         vector_body,
         {vector_file, "6 * (size_t)p->triangle + site_of_triangle(p, nearest->frame_site)",
          "6 * (size_t)p->triangle"}},
        {"another site",
         vector_body,
         {vector_file, "(uchar)named.site", "(uchar)(named.site == 4u ? 5u : named.site)"}},
        {"coordinates of the sample beside it",
         vector_body,
         {vector_file, "store(EIGHT_OF(high, z, Order, 3, 13, 4, 5, 14, 6, 7, 15), 2, to)",
          "store(EIGHT_OF(high, z, Order, 3, 13, 4, 5, 14, 6, 7, 14), 2, to)"}},
    };
    for (Mutation& mutation : mutations)
        check_refusal(mutation.what, mutation.changed, folder.file("cache"), [&](const Device& device) {
            return message_of_test(device, bricks(mutation.body, true, false));
        });
}

BOOST_AUTO_TEST_CASE(refuses_wrong_points) {
    const TemporaryFolder folder;
    struct Mutation {
        const char* what;
        KernelBody body;
        PointTestCase test_case;
        Changed changed;
    };
    const Changed sign{"points.cl", "sides & (outward > 0.0 ?", "sides & (outward < 0.0 ?"},
        gradient{"points.cl", "nearest->sign / sqrt(squared)", "1.0 / sqrt(squared)"},
        frames{"mesh_records.cl", "to_foot = is_right ? f.right : -f.left;", "to_foot = is_right ? f.right : f.left;"},
        doubles{"points.cl", "length > 0.0 ? length :", "length > 0.0 ? (float)length :"},
        groups{"mesh_records.cl", "groups[n / CLSDF_RECORD_GROUP]", "groups[0]"};
    std::vector<Mutation> mutations{
        {"signs of the other side", vector_body, {}, sign},
        {"signs of the other side", vector_body, {.are_scanned = true}, sign},
        {"signs of the other side", group_body, {}, sign},
        {"a gradient without the sign", vector_body, {}, gradient},
        {"a distance in double with the digits of a float", vector_body, {}, doubles},
        {"a triangle beside its place", vector_body, {.are_scanned = true}, frames},
        {"records of other faces", vector_body, {.are_scanned = true, .is_later = true}, groups},
    };
    for (Mutation& mutation : mutations)
        check_refusal(mutation.what, mutation.changed, folder.file("cache"), [&](const Device& device) {
            return message_of_point_test(device, mutation.body, mutation.test_case);
        });
}

BOOST_AUTO_TEST_CASE(stops_a_computation_before_it_begins) {
    Changed changed{"mesh_records.cl", "to_foot = is_right ? f.right : -f.left;",
                    "to_foot = is_right ? f.right : f.left;"};
    const Device device = changed.device("");
    const Mesh mesh = make_shape("cube");
    const Band band = Band::symmetric(0.1);
    DistanceTransform transform(device, mesh);
    const auto message = [&](auto&& call) {
        try {
            call();
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    const Grid grid = Grid::around(mesh, 16, band);
    BOOST_TEST(message([&] { transform.compute(grid, band); }).find("computes wrong fields") != std::string::npos);
    BOOST_TEST(message([&] { transform.plan(grid, band); }).find("computes wrong fields") != std::string::npos);
    BOOST_TEST(message([&] { transform.compile(grid, band); }).find("computes wrong fields") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(stops_a_computation_on_a_later_lattice) {
    Changed changed{"mesh_records.cl", "groups[n / CLSDF_RECORD_GROUP]", "groups[0]"};
    const Device device = changed.device("");
    const Mesh mesh = make_shape("sphere3");
    const Band band = Band::symmetric(0.1);
    DistanceTransform transform(device, mesh);
    transform.compute(Grid::around(mesh, 16, band), band);
    const auto is_refusal = [](const Error& error) {
        return std::string_view(error.what()).find("computes wrong fields") != std::string_view::npos;
    };
    for (int i = 0; i < 2; ++i)
        BOOST_CHECK_EXCEPTION(transform.compute(Grid::around(mesh, 20, band), band), Error, is_refusal);
    transform.compute(Grid::around(mesh, 16, band), band);
}

BOOST_AUTO_TEST_CASE(stops_a_query_of_many_points_after_a_field) {
    Changed changed{"mesh_records.cl", "groups[n / CLSDF_RECORD_GROUP]", "groups[0]"};
    const Device device = changed.device("");
    const Mesh mesh = make_shape("sphere3");
    const Band band = Band::symmetric(0.1);
    DistanceTransform transform(device, mesh, {.body = vector_body});
    const Grid grid = Grid::around(mesh, 32, band);
    transform.compute(grid, band);
    std::vector<Vec3> points;
    for (std::int64_t i = 0; i < 16384; ++i) points.push_back(grid.position(i % 32, i / 32 % 32, i / 1024));
    const auto is_refusal = [](const Error& error) {
        return std::string_view(error.what()).find("computes wrong fields") != std::string_view::npos;
    };
    std::vector<float> distance(points.size());
    for (int i = 0; i < 2; ++i) BOOST_CHECK_EXCEPTION(transform.query(points, 1, distance), Error, is_refusal);
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
    // Tested again on request.
    Changed nothing;
    const Device device = nothing.device(folder.file("cache"));
    device.forget_records();
    BOOST_TEST(DistanceTransform(device, mesh).compile(grid, band).first_use);
}

BOOST_AUTO_TEST_SUITE_END()
