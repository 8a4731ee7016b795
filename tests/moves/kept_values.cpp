#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/test_meshes.hpp"
#include "support/throws.hpp"

#include "polyhedron.h"

#include <clsdf/tuning.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <thread>
#include <vector>

// The data that a transform keeps between calls change no byte of a field, and vertices can move.

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr std::array both_bodies{KernelBody::by_vector, KernelBody::by_group};

/// Small boxes anywhere in a grid, some of one sample.
std::vector<Grid> small_parts(const Grid& grid, Random& random, int count) {
    std::vector<Grid> parts;
    for (int n = 0; n < count; ++n) {
        Index3 offset{}, size{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto most = std::min<std::int64_t>(grid.size[axis], n % 4 == 0 ? 1 : 24);
            size[axis] = 1 + static_cast<std::int64_t>(random.index(static_cast<std::size_t>(most)));
            offset[axis] =
                static_cast<std::int64_t>(random.index(static_cast<std::size_t>(grid.size[axis] - size[axis] + 1)));
        }
        parts.push_back(grid.part(offset, size));
    }
    return parts;
}

/// Bent around the x axis, more with larger x: no rigid motion.
std::vector<Vec3> twisted(const Mesh& mesh, double angle) {
    std::vector<Vec3> positions = mesh.vertices();
    for (Vec3& p : positions) {
        const double turn = angle * p[0];
        p = {p[0], std::cos(turn) * p[1] - std::sin(turn) * p[2], std::sin(turn) * p[1] + std::cos(turn) * p[2]};
    }
    return positions;
}

}  // namespace

BOOST_AUTO_TEST_CASE(small_boxes_have_the_bytes_of_the_whole) {
    std::uint64_t seed = 20;
    for (const Mesh& mesh : {tilted(make_shape("knot")), make_shape("noisy"), make_shape("sphere5")}) {
        const Grid grid = grid_around(mesh, 150, 4);
        for (const KernelBody body : both_bodies)
            for (const double voxels : {2.0, 30.0, std::numeric_limits<double>::infinity()}) {
                Random random(++seed);
                const Band band = Band::symmetric(voxels * grid.voxel());
                BOOST_TEST_CONTEXT(mesh.name() << ", band of " << voxels << " voxels, seed " << seed) {
                    const Field whole = compute(mesh, grid, band, body);
                    DistanceTransform kept(test_device(), mesh, {.body = body});
                    for (const Grid& part : small_parts(grid, random, 12)) {
                        const Field expected = part_of(whole, part);
                        BOOST_TEST(same_bytes(compute(mesh, part, band, body), expected));
                        BOOST_TEST(same_bytes(kept.compute(part, band, all_outputs()), expected));
                    }
                    BOOST_TEST(same_bytes(kept.compute(grid, band, all_outputs()), whole));
                }
            }
    }
}

BOOST_AUTO_TEST_CASE(what_is_kept_changes_no_byte) {
    const Mesh mesh = tilted(make_shape("knot"));
    const Grid grid = grid_around(mesh, 60, 4), finer = grid_around(mesh, 90, 4);
    const Band band = Band::symmetric(3 * grid.voxel()), wide = Band::symmetric(9 * grid.voxel());
    const Field first = compute(mesh, grid, band), second = compute(mesh, finer, band),
                third = compute(mesh, grid, wide);
    for (const std::size_t budget : {std::size_t{0}, std::size_t{1} << 20, std::size_t{1} << 30}) {
        DistanceTransform transform(test_device(), mesh, {.kept_bytes = budget});
        for (int round = 0; round < 3; ++round) {
            BOOST_TEST(same_bytes(transform.compute(grid, band, all_outputs()), first));
            BOOST_TEST(same_bytes(transform.compute(finer, band, all_outputs()), second));
            BOOST_TEST(same_bytes(transform.compute(grid, wide, all_outputs()), third));
            BOOST_TEST((bits_of(transform.compute(grid, band).distance()) == bits_of(first.distance())));
        }
    }
}

BOOST_AUTO_TEST_CASE(what_does_not_fit_in_the_budget_drives_out_nothing_that_does) {
    const Mesh mesh = make_shape("knot");
    const Grid grid = grid_around(mesh, 60, 4);
    const Band band = Band::symmetric(3 * grid.voxel());
    const std::size_t records = 280 * mesh.triangles().size(), tree = 550 * mesh.triangles().size();
    DistanceTransform transform(test_device(), mesh, {.kept_bytes = (records + tree) / 2});
    std::vector<float> distance(mesh.vertices().size());
    transform.compute(grid, band);
    transform.query(mesh.vertices(), 1.0, distance);
    BOOST_TEST(transform.memory().device_bytes >= records);
    BOOST_TEST(transform.memory().device_bytes < tree);
}

BOOST_AUTO_TEST_CASE(nothing_is_kept_if_nothing_may_be) {
    const Mesh mesh = tilted(make_shape("knot"));
    const Grid grid = grid_around(mesh, 40, 4);
    const Band band = Band::symmetric(3 * grid.voxel());
    DistanceTransform transform(test_device(), mesh, {.kept_bytes = 0});
    const auto kept = [&] { return transform.memory().device_bytes; };
    std::vector<BoxPlace> places(1);
    transform.classify(std::vector<Box>{grid.box()}, band.widest(), places);
    BOOST_TEST(kept() == 0U);
    const Plan plan = transform.plan(grid, band);
    BOOST_TEST(kept() == 0U);
    transform.compute(grid, band);
    BOOST_TEST(kept() == 0U);
    CallOptions call;
    call.should_stop = [calls = 0]() mutable { return ++calls > 3; };
    BOOST_CHECK_THROW(transform.compute(grid, band, Output::distance, call), Error);
    BOOST_TEST(kept() == 0U);
}

BOOST_AUTO_TEST_CASE(records_that_only_plans_of_small_grids_hold_count_as_kept) {
    const Mesh mesh = tilted(make_shape("knot"));
    const Grid grid = grid_around(mesh, 40, 4);
    const Grid small = grid.part({0, 0, 0}, {20, 20, 20});
    const DistanceTransform transform(test_device(), mesh);
    const Field field = transform.compute(small, Band::symmetric(3 * grid.voxel()));
    BOOST_TEST(transform.memory().device_bytes > 280 * mesh.triangles().size() / 20);
}

BOOST_AUTO_TEST_CASE(memory_that_is_only_kept_is_given_up_for_a_plan) {
    const Mesh mesh = make_shape("sphere5");
    const Grid grid = grid_around(mesh, 100, 4);
    const Band band = Band::symmetric(3 * grid.voxel());
    std::size_t needed = 0;
    {
        const DistanceTransform fresh(test_device(), mesh);
        needed = fresh.plan(grid, band).statistics().device_bytes + fresh.memory().device_bytes;
    }
    const DistanceTransform transform(test_device().limited({.memory = 4 * needed}), mesh);
    for (const int resolution : {95, 90, 85, 80, 75, 70}) {
        const Grid other = grid_around(mesh, resolution, 4);
        transform.compute(other, Band::symmetric(3 * other.voxel()));
    }
    BOOST_TEST(transform.plan(grid, band).statistics().device_bytes > 0U);
    std::vector<float> distance(20000);
    const std::vector<Vec3> points(distance.size());
    transform.query(points, 0.1, distance);
}

BOOST_AUTO_TEST_CASE(a_plan_of_a_small_box_holds_what_is_near_it) {
    const Mesh mesh = make_shape("sphere7");
    const Grid grid = grid_around(mesh, 256, 4);
    DistanceTransform transform(test_device(), mesh);
    const Band band = Band::symmetric(3 * grid.voxel());
    const Plan small = transform.plan(grid.part({0, 120, 120}, {16, 16, 16}), band);
    BOOST_TEST(small.statistics().work->coarse_pairs > 0U);
    BOOST_TEST(small.statistics().device_bytes < 4U << 20);
    // The plan has the polyhedra near it. A GPU also keeps the faces that all polyhedra are made of.
    const std::size_t of_faces = is_processor() ? 0 : 52 * mesh.triangles().size();
    BOOST_TEST(transform.memory().device_bytes < of_faces + (1U << 20));
    BOOST_TEST(small.statistics().device_bytes > 280 * mesh.triangles().size() / 1000);
    const Plan whole = transform.plan(grid, band);
    BOOST_TEST(whole.statistics().device_bytes < 16 * mesh.triangles().size() + (5U << 20));
    BOOST_TEST(transform.memory().device_bytes > 280 * mesh.triangles().size());  // which all plans share
    const DistanceTransform forgetful(test_device(), mesh, {.kept_bytes = 0});
    const Plan owner = forgetful.plan(grid, band);
    BOOST_TEST(forgetful.memory().device_bytes == 0U);
    BOOST_TEST(owner.statistics().device_bytes > whole.statistics().device_bytes + 280 * mesh.triangles().size());
}

BOOST_AUTO_TEST_CASE(moved_vertices_have_an_exact_field) {
    const Mesh first = tilted(make_shape("knot"));
    const Grid grid = grid_around(first, 60, 8);
    const Band band = Band::symmetric(3 * grid.voxel());
    for (const KernelBody body : both_bodies) {
        DistanceTransform transform(test_device(), first, {.body = body});
        const Field before = transform.compute(grid, band, all_outputs());
        for (const double angle : {0.2, -0.4}) {
            const Mesh moved(twisted(first, angle), first.triangles(), first.name());
            transform.set_positions(moved.vertices());
            const Field field = transform.compute(grid, band, all_outputs());
            BOOST_TEST(!same_bytes(field, before));
            BOOST_TEST(check_exact(moved, field).band_samples > 0U);
            // A box of the moved part, without the rest.
            const Grid part = grid.part({20, 20, 20}, {9, 9, 9});
            BOOST_TEST(same_bytes(transform.compute(part, band, all_outputs()), part_of(field, part)));
        }
        transform.set_positions(first.vertices());
        BOOST_TEST(same_bytes(transform.compute(grid, band, all_outputs()), before));
    }
}

BOOST_AUTO_TEST_CASE(bytes_after_a_move_depend_on_the_first_and_the_last_positions) {
    const Mesh first = make_shape("noisy");
    const Grid grid = grid_around(first, 50, 6);
    const Band band = Band::symmetric(4 * grid.voxel());
    const std::vector<Vec3> last = twisted(first, 0.3);
    DistanceTransform at_once(test_device(), first), by_way(test_device(), first);
    at_once.set_positions(last);
    by_way.compute(grid, band);
    const std::vector<Vec3> far = twisted(first, -1), near = twisted(first, 0.1);
    by_way.set_positions(far);
    by_way.compute(grid.part({3, 4, 5}, {7, 7, 7}), band);
    by_way.set_positions(near);
    by_way.set_positions(last);
    BOOST_TEST(same_bytes(at_once.compute(grid, band, all_outputs()), by_way.compute(grid, band, all_outputs())));
}

/// About the axis (1, 2, 2) / 3.
std::array<Vec3, 3> rotation_by(double angle) {
    const Vec3 n{1.0 / 3, 2.0 / 3, 2.0 / 3};
    const double c = std::cos(angle), s = std::sin(angle);
    std::array<Vec3, 3> rows{};
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = 0; b < 3; ++b) rows[a][b] = (1 - c) * n[a] * n[b] + (a == b ? c : 0);
    for (std::size_t a = 0; a < 3; ++a) {
        rows[a][(a + 1) % 3] -= s * n[(a + 2) % 3];
        rows[a][(a + 2) % 3] += s * n[(a + 1) % 3];
    }
    return rows;
}

// Each motion is one of the first positions: a thousand steps leave no trace.
BOOST_AUTO_TEST_CASE(rigid_motions_do_not_drift) {
    for (const Mesh& first : {make_shape("knot"), unwelded(make_shape("cube"))}) {
        const Grid grid = grid_around(first, 40, 10);
        const Band band = Band::symmetric(3 * grid.voxel());
        DistanceTransform transform(test_device(), first);
        const Field before = transform.compute(grid, band, all_outputs());
        for (int step = 1; step < 1000; ++step) transform.set_motion(rotation_by(0.01 * step), {0.001 * step, 0, 0});
        const std::array<Vec3, 3> rotation = rotation_by(0.3);
        const Vec3 translation{0.01, -0.02, 0.03};
        transform.set_motion(rotation, translation);
        std::vector<Vec3> expected = first.vertices();
        for (Vec3& x : expected) {
            const Vec3 from = x;
            for (std::size_t a = 0; a < 3; ++a)
                x[a] = std::fma(rotation[a][0], from[0],
                                std::fma(rotation[a][1], from[1], std::fma(rotation[a][2], from[2], translation[a])));
        }
        const Field field = transform.compute(grid, band, all_outputs());
        BOOST_TEST(check_exact(Mesh(expected, first.triangles(), first.name()), field).band_samples > 0U);
        DistanceTransform other(test_device(), first);
        other.set_positions(expected);
        BOOST_TEST(same_bytes(other.compute(grid, band, all_outputs()), field));
        transform.set_motion(rotation_by(0), {0, 0, 0});
        BOOST_TEST(same_bytes(transform.compute(grid, band, all_outputs()), before));
    }
}

BOOST_AUTO_TEST_CASE(what_is_no_rotation_is_refused) {
    const Mesh mesh = make_shape("sphere2");
    DistanceTransform transform(test_device(), mesh);
    const Vec3 none{0, 0, 0};
    check_throws(ErrorCode::invalid_argument, {"rows 0 and 0 is 4"}, [&] {
        transform.set_motion({Vec3{2, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}, none);
    });
    check_throws(ErrorCode::invalid_argument, {"rows 0 and 1", "1e-12"}, [&] {
        transform.set_motion({Vec3{1, 0, 0}, Vec3{1e-11, 1, 0}, Vec3{0, 0, 1}}, none);
    });
    check_throws(ErrorCode::invalid_argument, {"reflection"}, [&] {
        transform.set_motion({Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, -1}}, none);
    });
    constexpr double infinite = std::numeric_limits<double>::infinity();
    check_throws(ErrorCode::invalid_argument, {"translation", "x is inf"}, [&] {
        transform.set_motion(rotation_by(0.1), {infinite, 0, 0});
    });
    const Grid grid = grid_around(mesh, 20, 3);
    check_exact(mesh, transform.compute(grid, Band::symmetric(0.2), all_outputs()));  // where it was
}

BOOST_AUTO_TEST_CASE(faces_lose_their_area_and_regain_it) {
    const Mesh mesh = make_shape("sphere3");
    const Grid grid = grid_around(mesh, 40, 6);
    const Band band = Band::symmetric(3 * grid.voxel());
    DistanceTransform transform(test_device(), mesh);
    const Field before = transform.compute(grid, band, all_outputs());
    std::vector<Vec3> flat = mesh.vertices();
    for (Vec3& position : flat) position[2] = 0;
    transform.set_positions(flat);
    check_exact(Mesh(flat, mesh.triangles(), "flat"), transform.compute(grid, band, all_outputs()));
    const std::vector<Vec3> one_point(flat.size(), Vec3{0.01, 0.02, 0.03});
    transform.set_positions(one_point);
    BOOST_TEST(std::isfinite(transform.compute(grid, band).distance()[0]));
    transform.set_positions(mesh.vertices());
    BOOST_TEST(same_bytes(transform.compute(grid, band, all_outputs()), before));
}

BOOST_AUTO_TEST_CASE(vertices_that_are_one_move_together) {
    // Two triangles of an open box's corner, each with vertices of its own: 1 equals 3, and 2 equals 5.
    const Mesh mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 1}, {0, 1, 0}, {9, 9, 9}},
                    {{0, 1, 2}, {3, 4, 5}}, "hinge");
    const Grid grid = grid_around(mesh, 30, 3);
    const Band band = Band::symmetric(3 * grid.voxel());
    DistanceTransform transform(test_device(), mesh);
    std::vector<Vec3> apart = mesh.vertices();
    apart[5] = {0, 1, 0.5};
    check_throws(ErrorCode::invalid_argument, {"vertices 2 and 5 of hinge", "(0, 1, 0.5)"},
                 [&] { transform.set_positions(apart); });
    check_exact(mesh, transform.compute(grid, band, all_outputs()));  // at the first positions
    apart[2] = apart[5] = {std::numeric_limits<double>::quiet_NaN(), 0, 0};
    check_throws(ErrorCode::invalid_mesh, {"not finite"}, [&] { transform.set_positions(apart); });
    apart[2] = {0, 1, 0};
    check_throws(ErrorCode::invalid_mesh, {"not finite"}, [&] { transform.set_positions(apart); });
    apart[5] = {0, 1, 0.5};
    std::vector<Vec3> together = apart;
    together[2] = together[5];
    together[6] = {std::numeric_limits<double>::quiet_NaN(), 0, 0};  // which no triangle uses
    transform.set_positions(together);
    together[6] = {9, 9, 9};
    check_exact(Mesh(together, mesh.triangles(), "moved hinge"), transform.compute(grid, band, all_outputs()));
}

BOOST_AUTO_TEST_CASE(what_cannot_be_moved_to_is_refused_and_the_mesh_stays) {
    const Mesh mesh = make_shape("sphere3");
    const Grid grid = grid_around(mesh, 30, 3);
    const Band band = Band::symmetric(3 * grid.voxel());
    DistanceTransform transform(test_device(), mesh);
    const Field before = transform.compute(grid, band);
    std::vector<Vec3> positions = mesh.vertices();
    positions[7][1] = std::numeric_limits<double>::infinity();
    check_throws(ErrorCode::invalid_mesh, {"vertex 7", "inf"}, [&] { transform.set_positions(positions); });
    positions.pop_back();
    check_throws(ErrorCode::invalid_argument, {"positions", std::to_string(positions.size())},
                 [&] { transform.set_positions(positions); });
    BOOST_TEST(same_bytes(transform.compute(grid, band), before));
}

// If the call forgot data that the plan holds, no memory would be freed, and the next call would allocate it again.
BOOST_AUTO_TEST_CASE(a_call_that_was_short_of_memory_can_be_repeated_beside_a_plan) {
    const Mesh mesh = make_shape("sphere4");
    const Grid grid = grid_around(mesh, 64, 4);
    const Band band = Band::symmetric(4 * grid.voxel());
    const Field expected = compute(mesh, grid, band);
    const std::size_t records = mesh.triangles().size() * sizeof(Polyhedron);
    std::size_t divided = 0;
    for (std::size_t memory = 9 * records; memory > 2 * records && divided < 4; memory -= records / 4) {
        const DistanceTransform transform(test_device().limited({.memory = memory}), mesh);
        std::optional<Plan> plan;
        TransformStatistics statistics;
        try {
            plan = transform.plan(grid, band);
            BOOST_TEST(same_bytes(transform.compute(grid, band, all_outputs(), {}, &statistics), expected));
        } catch (const Error& error) {
            BOOST_TEST((error.code() == ErrorCode::out_of_memory));
            continue;
        }
        BOOST_TEST_CONTEXT(memory << " bytes, " << statistics.slabs << " slabs")
        for (int call = 0; call < 2; ++call)
            BOOST_TEST(same_bytes(transform.compute(grid, band, all_outputs()), expected));
        divided += statistics.slabs > 1 ? 1 : 0;
    }
    BOOST_TEST(divided > 0U);
}

namespace {

/// Two threads compute on one transform, each with a lattice of its own and boxes of it.
void compute_at_once(const DistanceTransform& transform, const Mesh& mesh, const std::array<Grid, 2>& grids) {
    std::array<std::size_t, 2> wrong{};
    std::vector<std::thread> threads;
    for (std::size_t n = 0; n < grids.size(); ++n)
        threads.emplace_back([&, n] {
            const Grid& grid = grids[n];
            const Band band = Band::symmetric(3 * grid.voxel());
            const Field expected = compute(mesh, grid, band);
            Random random(n + 1);
            for (const Grid& part : small_parts(grid, random, 8)) {
                TransformStatistics statistics;
                double done = 0;
                const Field field = transform.compute(
                    part, band, all_outputs(), {.progress = when_computing([&](double fraction) { done = fraction; })},
                    &statistics);
                wrong[n] += same_bytes(field, part_of(expected, part)) && done == 1 && statistics.slabs == 1 ? 0U : 1U;
                wrong[n] += same_bytes(transform.compute(grid, band, all_outputs()), expected) ? 0U : 1U;
            }
        });
    for (std::thread& thread : threads) thread.join();
    for (const std::size_t count : wrong) BOOST_TEST(count == 0U);
}

}  // namespace

BOOST_AUTO_TEST_CASE(several_threads_compute_at_once) {
    const Mesh mesh = tilted(make_shape("knot"));
    const std::array grids{grid_around(mesh, 50, 4), grid_around(mesh, 70, 4)};
    const DistanceTransform transform(test_device(), mesh);
    compute_at_once(transform, mesh, grids);
    // With memory for the records of one lattice, 280 bytes a triangle, each thread drives out what the other one uses.
    const std::size_t triangles = mesh.triangles().size(), budget = 450 * triangles;
    BOOST_TEST(transform.memory().device_bytes > 560 * triangles);
    const DistanceTransform forgetful(test_device(), mesh, {.kept_bytes = budget});
    compute_at_once(forgetful, mesh, grids);
    BOOST_TEST(forgetful.memory().device_bytes <= budget);
    BOOST_TEST(forgetful.memory().device_bytes > 280 * triangles);
}
