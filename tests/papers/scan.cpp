#include "papers/scanned.hpp"
#include "support/device_memory.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include "device/context.hpp"

#include <clsdf/tuning.hpp>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <thread>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr std::array all_kinds{Polyhedra::leaned, Polyhedra::peikert_sigg, Polyhedra::mauch};

const Mesh& noisy() {
    static const Mesh mesh = [] {
        Random random(11);
        return random_sphere(random, "sphere3", 0.15);
    }();
    return mesh;
}

/// Its first sample is negative on two axes and on no brick's corner.
Grid around(const Mesh& mesh, std::int64_t size) {
    Grid grid = grid_around(mesh, size, 4);
    grid.first = {-21, 3, -37};
    for (std::size_t axis = 0; axis < 3; ++axis)
        grid.origin[axis] -= static_cast<double>(grid.first[axis]) * grid.spacing[axis];
    return grid;
}

Field compute_on(const Device& device, const Grid& grid, const Band& band, const PapersOptions& options,
                 const CallOptions& call = {}, TransformStatistics* statistics = nullptr) {
    return make_transform(device, noisy(), options).compute(grid, band, Output::triangle, call, statistics);
}

}  // namespace

BOOST_AUTO_TEST_CASE(both_minima_and_every_run_give_the_same_bytes) {
    const Grid grid = around(noisy(), 48);
    for (const Polyhedra kind : all_kinds)
        for (const KernelBody body : both_bodies) {
            const Band band = Band::symmetric(4 * grid.voxel());
            const Scanned first =
                scan_slices(noisy(), grid, band, {.polyhedra = kind, .slice_minimum = SliceMinimum::one_pass}, body);
            const Scanned second =
                scan_slices(noisy(), grid, band, {.polyhedra = kind, .slice_minimum = SliceMinimum::two_passes}, body);
            check_intersections(first.statistics);
            check_intersections(second.statistics, 2);
            BOOST_TEST(same_bytes(first.field, second.field));
            const DistanceTransform transform =
                make_transform(test_device(), noisy(), {.polyhedra = kind, .scan = Scan::slices}, {.body = body});
            for (int run = 0; run < 3; ++run)
                BOOST_TEST(same_bytes(first.field, transform.compute(grid, band, Output::triangle)));
            // Without triangles there is no key but the distance.
            BOOST_TEST((bits_of(first.field.distance()) == bits_of(transform.compute(grid, band).distance())));
        }
}

// Inside a cube many samples are as near to several triangles, to the last bit.
BOOST_AUTO_TEST_CASE(the_lowest_of_the_nearest_triangles_is_named) {
    const Grid grid = grid_at({0, 0, 0}, 0.125, 9);
    for (std::uint64_t seed = 1; seed <= 3; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const Mesh mesh = reordered(cube(1), random);
            const Field expected = reference::reference_field(mesh, grid, Band::symmetric(2));
            for (const KernelBody body : both_bodies)
                for (const SliceMinimum minimum : both_minima) {
                    const Field field =
                        scan_slices(mesh, grid, Band::symmetric(2), {.slice_minimum = minimum}, body).field;
                    std::size_t inside = 0;
                    for (std::size_t at = 0; at < field.distance().size(); ++at)
                        if (expected.distance()[at] < 0) {
                            ++inside;
                            BOOST_REQUIRE(field.distance()[at] == expected.distance()[at]);
                            BOOST_REQUIRE(field.triangle()[at] == expected.triangle()[at]);
                        }
                    BOOST_TEST(inside == 15U * 15U * 15U);
                }
        }
}

BOOST_AUTO_TEST_CASE(any_number_of_threads_gives_the_same_bytes) {
    const Device one = one_compute_unit();
    const Grid grid = around(noisy(), 40);
    const Band band = Band::symmetric(4 * grid.voxel());
    for (const Polyhedra kind : all_kinds)
        for (const SliceMinimum minimum : both_minima) {
            const PapersOptions options{.polyhedra = kind, .scan = Scan::slices, .slice_minimum = minimum};
            BOOST_TEST(
                same_bytes(compute_on(test_device(), grid, band, options), compute_on(one, grid, band, options)));
        }
}

BOOST_AUTO_TEST_CASE(a_part_has_the_bytes_of_the_whole) {
    const Grid grid = around(noisy(), 56);
    const Band band{2 * grid.voxel(), 6 * grid.voxel()};
    for (const Polyhedra kind : all_kinds) {
        const PapersOptions options{.polyhedra = kind, .scan = Scan::slices};
        const Field whole = compute_on(test_device(), grid, band, options);
        for (const auto& [first, size] : {std::pair<Index3, Index3>{{5, 5, 5}, {32, 24, 40}},
                                          {{21, 29, 5}, {9, 11, 32}},
                                          {{0, 0, 0}, {33, 41, 17}},
                                          {{13, 17, 30}, {1, 30, 1}},
                                          {{20, 28, 36}, {7, 11, 13}}}) {
            const Grid part = grid.part(first, size);
            const Field alone = compute_on(test_device(), part, band, options);
            const Field expected = part_of(whole, part);
            BOOST_TEST(same_bytes(alone, expected));
        }
    }
}

// Slabs of several slices and of one; keys of 64 bits no longer fit in the smallest.
BOOST_AUTO_TEST_CASE(slabs_have_the_bytes_of_the_whole) {
    const Grid grid = grid_around(noisy(), 130, 4);
    const Band band = Band::symmetric(4 * grid.voxel());
    const std::size_t slice_bytes = static_cast<std::size_t>(grid.size[0] * grid.size[1]) * sizeof(float);
    // The mesh itself needs some memory in one piece.
    for (const Polyhedra kind : all_kinds) {
        const PapersOptions options{.polyhedra = kind, .scan = Scan::slices};
        TransformStatistics of_whole, of_slabs;
        const Field whole = compute_on(test_device(), grid, band, options, {}, &of_whole);
        for (const std::size_t bytes : {20 * slice_bytes, 13 * slice_bytes}) {
            std::size_t calls = 0;
            const CallOptions watched{.progress = when_computing([&](double) { ++calls; })};
            BOOST_TEST(
                same_bytes(whole, compute_on(with_largest_allocation(bytes), grid, band, options, watched, &of_slabs)));
            BOOST_TEST(calls > 4U);
            // Counts of the mesh are taken once, counts of slabs are added up.
            BOOST_TEST(of_slabs.slabs > 1U);
            BOOST_TEST(count_of(of_slabs, "active_pieces") == count_of(of_whole, "active_pieces"));
            BOOST_TEST(count_of(of_slabs, "closed_gaps") == count_of(of_whole, "closed_gaps"));
        }
    }
}

BOOST_AUTO_TEST_CASE(a_slice_of_64_bit_keys_that_does_not_fit_takes_two_passes) {
    const Grid grid = grid_at({0, 0, 0}, 0.01, 150);
    const Grid flat = grid.part({0, 0, 140}, {301, 301, 9});
    const Mesh mesh = cube(1);
    const std::size_t slice_bytes = std::size_t{301} * 301 * sizeof(float);
    const Field expected = make_transform(test_device(), mesh, {.scan = Scan::slices})
                               .compute(flat, Band::symmetric(0.1), Output::triangle);
    // One byte less than a slice of 64-bit keys: everything else fits, also the counts of a device with many groups.
    const Device small = with_largest_allocation(2 * slice_bytes - 1);
    const DistanceTransform transform = make_transform(small, mesh, {.scan = Scan::slices});
    TransformStatistics statistics;
    BOOST_TEST(same_bytes(
        expected, transform.compute(flat, Band::symmetric(0.1), Output::triangle, {.count_work = true}, &statistics)));
    check_intersections(statistics, 2);
    const DistanceTransform one_pass =
        make_transform(small, mesh, {.scan = Scan::slices, .slice_minimum = SliceMinimum::one_pass});
    check_throws(ErrorCode::out_of_memory, {"least distances"},
                 [&] { one_pass.compute(flat, Band::symmetric(0.1), Output::triangle); });
}

BOOST_AUTO_TEST_CASE(a_plan_neither_blocks_nor_depends_on_the_queue) {
    const Grid grid = around(noisy(), 32);
    const Band band = Band::symmetric(3 * grid.voxel());
    for (const SliceMinimum minimum : both_minima) {
        const PapersOptions options{.polyhedra = Polyhedra::peikert_sigg, .slice_minimum = minimum};
        const Field expected = compute_on(test_device(), grid, band, options);
        std::optional<DistanceTransform> transform = make_transform(test_device(), noisy(), options);
        Plan plan = transform->plan(grid, band, Output::triangle);
        transform.reset();
        const device::Context& context = device::context_of(test_device());
        for (const cl_command_queue_properties properties :
             {cl_command_queue_properties{0}, cl_command_queue_properties{CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE}}) {
            const cl::CommandQueue queue(context.context(), context.device(), properties);
            for (int run = 0; run < 2; ++run) {
                const DeviceMemory distance(test_device().context(), grid.sample_count());
                const DeviceMemory triangle(test_device().context(), grid.sample_count());
                cl::UserEvent begin(context.context());
                const cl_event wait_list[] = {begin()};
                const OutputTargets targets{{Output::distance, distance.handle()},
                                            {Output::triangle, triangle.handle()}};
                const cl::Event end = enqueue(plan, queue(), targets, wait_list);
                std::this_thread::sleep_for(std::chrono::milliseconds(50));
                BOOST_TEST(end.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() > CL_COMPLETE);
                begin.setStatus(CL_COMPLETE);
                end.wait();
                BOOST_TEST((distance.read(queue) == bits_of(expected.distance())));
                BOOST_TEST(std::ranges::equal(triangle.read(queue), expected.triangle()));
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(progress_is_told_and_a_stop_is_heard_between_launches) {
    // A launch on a GPU does more.
    const Mesh mesh = make_shape(is_processor() ? "sphere3" : "sphere5");
    const Grid grid = grid_around(mesh, 110, 2);
    bool stop = false;
    std::vector<double> seen;
    const DistanceTransform transform = make_transform(one_compute_unit(), mesh, {.scan = Scan::slices});
    const CallOptions call{.progress = when_computing([&](double fraction) {
                               seen.push_back(fraction);
                               if (fraction > 0) stop = true;
                           }),
                           .should_stop = [&] { return stop; }};
    check_throws(ErrorCode::cancelled, {"cancelled"},
                 [&] { transform.compute(grid, Band::full(), Output::distance, call); });
    BOOST_REQUIRE(seen.size() == 2U);
    BOOST_TEST(seen[0] == 0);
    BOOST_TEST(seen[1] < 0.5);
}

BOOST_AUTO_TEST_CASE(a_mesh_beside_the_grid_leaves_the_fill) {
    const Mesh mesh = make_shape("sphere1");
    Grid grid = grid_at({50, 0, 0}, 0.1, 6);
    for (const Polyhedra kind : all_kinds) {
        const Scanned scanned = scan_slices(mesh, grid, Band::symmetric(0.5), {.polyhedra = kind});
        BOOST_TEST(count_of(scanned.statistics, "active_pieces") == 0U);
        for (std::size_t at = 0; at < grid.sample_count(); ++at) {
            BOOST_REQUIRE(scanned.field.distance()[at] == 0.5F);
            BOOST_REQUIRE(scanned.field.triangle()[at] == no_triangle);
        }
    }
}

BOOST_AUTO_TEST_CASE(bricks_of_the_papers_polyhedra_are_refused) {
    check_throws(ErrorCode::unsupported, {"bricks", "peikert-sigg", "slices"}, [] {
        make_transform(test_device(), cube(1), {.polyhedra = Polyhedra::peikert_sigg, .scan = Scan::bricks});
    });
}

// Only the slices of a piece are looked at, whatever its shape.
BOOST_AUTO_TEST_CASE(no_empty_intersection_is_visited) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            for (const Mesh& mesh : {random_soup(random, 12, 60), random_slivers(random, 60), random_closed(random, 3),
                                     random_flap(random), random_sphere(random, "sphere1", 0.9),
                                     random_lattice_tetrahedron(random, 0.5)}) {
                if (!(mesh.box().longest_side() > 0)) continue;
                // A grid that cuts through, so that polyhedra leave it on all sides.
                const Grid whole = grid_around(mesh, 30, 2);
                const Grid grid = whole.part({0, 0, 0}, {whole.size[0], (whole.size[1] + 1) / 2, whole.size[2]});
                for (const Polyhedra kind : all_kinds)
                    for (const Band& band : {Band::symmetric(0.2 * grid.voxel()), Band::symmetric(5 * grid.voxel()),
                                             Band::symmetric(100 * grid.voxel())}) {
                        const TransformStatistics statistics =
                            scan_slices(mesh, grid, band, {.polyhedra = kind}).statistics;
                        check_intersections(statistics);
                    }
            }
        }
}
