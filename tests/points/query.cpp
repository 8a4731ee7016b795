#include "points/joined_faces.hpp"
#include "support/queries.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include "device/context.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

using namespace clsdf;
using namespace clsdf::test;

BOOST_AUTO_TEST_CASE(every_output_of_every_point_keeps_its_contract) {
    for (const Mesh& mesh : meshes()) {
        const double voxel = voxel_of(mesh);
        std::mt19937_64 generator(11);
        for (const KernelBody body : both_bodies) {
            const DistanceTransform transform(test_device(), mesh, {.body = body});
            const Grid around = grid_around(mesh, 14, 3);
            check_points(transform, mesh, around);
            check_points(transform, mesh, around, 2.5 * around.voxel());
            // Beside vertices and faces, at distances of voxels, and on them.
            for (int place = 0; place < 6; ++place) {
                const std::size_t triangle = generator() % mesh.triangles().size();
                const Vec3 centre = place % 2 == 0 ? corner(mesh, triangle, 0) : on_triangle(mesh, triangle, 0.3, 0.4);
                check_points(transform, mesh, grid_at(centre, (place < 3 ? 1 : 0.01) * voxel, 2), 3 * voxel);
            }
        }
    }
}

// So far away that a float cannot tell one triangle from another.
BOOST_AUTO_TEST_CASE(far_away_every_output_keeps_its_contract) {
    for (const Mesh& mesh : {tilted(make_shape("noisy")), shifted(make_shape("torus"), {3, -5, 7}), overlapping_cubes(),
                             without_triangle(make_shape("knot"), 7), reversed(tilted(cube(1)))}) {
        const double voxel = voxel_of(mesh);
        Random random(17);
        std::vector<Vec3> points;
        for (const double far : {1e3, 1e4, 1e6, 1e9, 1e11, 1e13})
            for (const Vec3& direction :
                 {Vec3{1, 0, 0}, Vec3{0, 0, -1}, Vec3{-0.6, 0.8, 0.01}, random.direction(), random.direction()})
                points.push_back(along(corner(mesh, random.index(mesh.triangles().size()), 0), far * voxel, direction));
        const std::size_t far_points = points.size();
        for (const KernelBody body : both_bodies) {
            const DistanceTransform transform(test_device(), mesh, {.body = body});
            const PointContract contract(mesh, transform.sign(), no_limit);
            const Field field = query(transform, points);
            for (std::size_t i = 0; i < far_points; ++i) {
                const std::string fault = contract.fault(points[i], field, i);
                BOOST_TEST(fault.empty(), mesh.name() << ", point " << i << ": " << fault);
                check_points(transform, mesh, grid_at(points[i], voxel, 0));
            }
            // Among so many that they are scanned in groups.
            std::vector<Vec3> many = points;
            for (const Vec3& p : points_around(mesh, 20000, 19)) many.push_back(p);
            const Field of_many = query(transform, many);
            for (const OutputInfo& info : output_table())
                BOOST_TEST(differences(field, 0, of_many, 0, far_points, info).count == 0U,
                           mesh.name() << ", " << info.name << " differs");
        }
    }
}

BOOST_AUTO_TEST_CASE(on_the_surface_the_distance_is_zero_and_positive) {
    for (const Mesh& mesh : {cube(1), reversed(cube(1)), without_triangle(cube(1), 3)})
        for (const KernelBody body : both_bodies) {
            const DistanceTransform transform(test_device(), mesh, {.body = body});
            const std::vector<Vec3> points{{1, 0.3, -0.2}, {-1, -1, 0.1}, {1, 1, 1}, {0.1, -1, 0.7}, {0.125, 0.5, 1}};
            const Field field = query(transform, points, 0);
            for (std::size_t i = 0; i < points.size(); ++i) {
                if (field.triangle()[i] == no_triangle) continue;  // the hole
                BOOST_TEST(field.distance()[i] == 0);
                BOOST_TEST(!std::signbit(field.distance()[i]));
                const Vec3 gradient{field.gradient()[3 * i], field.gradient()[3 * i + 1], field.gradient()[3 * i + 2]};
                BOOST_TEST(std::hypot(gradient[0], gradient[1], gradient[2]) == 1.0,
                           boost::test_tools::tolerance(1e-6));
            }
            BOOST_TEST(std::ranges::count(field.triangle(), no_triangle) <= 1);
        }
}

// Every triangle of a sphere is as near to its centre, and all corners of a cube to the middle.
BOOST_AUTO_TEST_CASE(on_the_medial_axis_one_of_the_nearest_triangles_is_named) {
    for (const Mesh& mesh : {make_shape("sphere4"), cube(1), make_shape("torus")})
        for (const KernelBody body : both_bodies) {
            const DistanceTransform transform(test_device(), mesh, {.body = body});
            check_points(transform, mesh, grid_at({0, 0, 0}, voxel_of(mesh) / 16, 1));
        }
}

// Many points are scanned in groups, few are looked up one by one; many have signs by the sides of faces, few by
// crossings. On a grid around a symmetric mesh many triangles are equally near.
BOOST_AUTO_TEST_CASE(many_points_give_the_bytes_of_few) {
    std::vector<Mesh> all = meshes();
    for (const char* shape : {"sphere4", "torus"}) all.push_back(make_shape(shape));
    for (Mesh& mesh : meshes_with_near_sides()) all.push_back(std::move(mesh));
    all.push_back(box_with_fillers());
    for (const Mesh& mesh : all)
        for (const double half_width : {no_limit, 0.05 * mesh.box().longest_side()}) {
            std::vector<Vec3> points = samples_of(grid_around(mesh, 24, 2));
            for (const Vec3& p : points_around(mesh, 20011, 71)) points.push_back(p);
            points.push_back({1e9, -1e7, 3});
            std::mt19937_64 generator(73);
            for (const double distance : {1e-3, 1e-6, 1e-9, 1e-12, 1e-15})
                for (int i = 0; i < 200; ++i) {
                    Vec3 p = points[generator() % points.size()];
                    for (double& x : p) x += distance * (std::uniform_real_distribution<double>(-1, 1)(generator));
                    points.push_back(p);
                }
            const Field many = query(DistanceTransform(test_device(), mesh), points, half_width);
            std::optional<DistanceTransform> transform;
            constexpr std::size_t few = 1511;
            for (std::size_t begin = 0; begin < points.size(); begin += few) {
                // A transform that has had few points counts crossings for their signs.
                if (begin / few % 8 == 0) transform.emplace(test_device(), mesh);
                const std::size_t count = std::min(few, points.size() - begin);
                const Field some = query(*transform, std::span(points).subspan(begin, count), half_width);
                for (const OutputInfo& info : output_table()) {
                    const Differences found = differences(many, begin, some, 0, count, info);
                    BOOST_TEST(found.count == 0U, mesh.name() << ", " << info.name << ": " << found.count
                                                              << " points differ, first " << begin + found.first);
                }
            }
        }
}

BOOST_AUTO_TEST_CASE(the_sign_follows_the_rule_at_the_very_point) {
    const Mesh mesh = overlapping_cubes();
    const reference::Oracle oracle(mesh);
    const std::vector<Vec3> points = points_around(mesh, 4000, 31);
    for (const SignRule rule : {SignRule::nonzero, SignRule::parity, SignRule::none}) {
        const DistanceTransform transform(test_device(), mesh, {.sign = rule});
        const Field field = query(transform, points, 0.2);
        std::size_t wrong = 0, inside = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const std::optional<int> winding = oracle.winding_number(points[i]);
            const bool is_inside = winding && (rule == SignRule::nonzero  ? *winding != 0
                                               : rule == SignRule::parity ? *oracle.crossings(points[i]) % 2 != 0
                                                                          : false);
            // Exactly on the surface it is +0.
            wrong += std::signbit(field.distance()[i]) != is_inside || (!winding && field.distance()[i] != 0) ? 1U : 0U;
            inside += is_inside ? 1U : 0U;
        }
        BOOST_TEST(wrong == 0U);
        BOOST_TEST((inside > 300U || rule == SignRule::none));
    }
}

// The lower corner of the mesh's box is the origin of its points. The sign of a zero there must not depend on the order
// of vertices.
// Of joined vertices those with the least position count, so the surface that decides the sign may go through a point
// that is not on the mesh. Both signs are right there, and each call has the same.
BOOST_AUTO_TEST_CASE(a_point_on_joined_faces_has_the_same_sign_in_each_call) {
    std::vector<Triangle> triangles;
    for (std::uint32_t first = 0; first < corners_with_noise.size(); first += 3)
        triangles.push_back({first, first + 1, first + 2});
    const DistanceTransform transform(
        test_device(), Mesh({corners_with_noise.begin(), corners_with_noise.end()}, std::move(triangles)));
    BOOST_TEST(transform.topology().joined_vertices > 0U);
    BOOST_TEST((transform.sign() == SignRule::nonzero));
    // So many that they are scanned together.
    std::vector<Vec3> points(points_on_joined_faces.begin(), points_on_joined_faces.end());
    points.insert(points.end(), points_on_joined_faces.begin(), points_on_joined_faces.end());
    const Field together = query(transform, points);
    for (std::size_t i = 0; i < points_on_joined_faces.size(); ++i) {
        const Field alone = query(transform, std::span(&points[i], 1));
        BOOST_TEST(differences(together, i, alone, 0, 1, output_table()[0]).count == 0U,
                   "point " << i << ": " << together.distance()[i] << ", " << alone.distance()[0] << " alone");
    }
}

BOOST_AUTO_TEST_CASE(a_move_to_the_same_positions_changes_nothing) {
    std::vector<Vec3> points;
    for (int i = -4; i < 12; ++i)
        for (int j = -4; j < 12; ++j)
            for (const double z : {0.0, -0.0}) points.push_back({0.13 * i, 0.11 * j, z});
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        Random random(seed);
        const Mesh flat = reordered(moved(random_soup(random, 6, 8),
                                          [&](const Vec3& p) {
                                              return Vec3{p[0], p[1], random.uniform(0, 1) < 0.5 ? -0.0 : 0.0};
                                          }),
                                    random);
        DistanceTransform transform(test_device(), flat, {.sign = SignRule::none});
        const Field first = query(transform, points);
        transform.set_positions(flat.vertices());
        BOOST_TEST(same_bytes(first, query(transform, points)), "seed " << seed);
    }
}

BOOST_AUTO_TEST_CASE(moved_vertices_give_what_a_new_mesh_gives) {
    const Mesh first = make_shape("knot");
    const Mesh last = moved(first, [](const Vec3& p) {
        return Vec3{p[0] + 0.2 * p[1] * p[1], 1.3 * p[1], p[2] - p[0]};
    });
    const std::vector<Vec3> points = points_around(last, 2000, 41);
    DistanceTransform transform(test_device(), first);
    query(transform, points);
    transform.set_positions(last.vertices());
    BOOST_TEST(same_bytes(query(transform, points), query(DistanceTransform(test_device(), last), points)));
}

BOOST_AUTO_TEST_CASE(targets_have_strides_and_some_or_all_outputs) {
    const Mesh mesh = make_shape("torus");
    const DistanceTransform transform(test_device(), mesh);
    const std::vector<Vec3> points = points_around(mesh, 700, 61);
    const Field all = query(transform, points);
    struct Particle {
        double position[3];
        float distance;
        float offset[3];
        std::uint32_t triangle;
    };
    std::vector<Particle> particles(points.size(), {{}, 7, {7, 7, 7}, 7});
    const auto target = [&](auto& member, ElementType element) {
        OutputArray result;
        result.host = &particles[0];
        result.bytes = particles.size() * sizeof(Particle);
        result.offset =
            static_cast<std::size_t>(reinterpret_cast<char*>(&member) - reinterpret_cast<char*>(&particles[0]));
        result.type = element;
        result.strides[0] = sizeof(Particle);
        return result;
    };
    OutputTargets targets;
    targets[Output::distance] = target(particles[0].distance, ElementType::float32);
    targets[Output::offset] = target(particles[0].offset, ElementType::float32);
    transform.query(points, no_limit, targets);
    for (std::size_t i = 0; i < points.size(); ++i) {
        BOOST_REQUIRE(particles[i].distance == all.distance()[i]);
        for (std::size_t axis = 0; axis < 3; ++axis)
            BOOST_REQUIRE_SMALL(
                static_cast<double>(particles[i].offset[axis]) - (all.closest()[3 * i + axis] - points[i][axis]), 1e-6);
        BOOST_REQUIRE(particles[i].triangle == 7U);
    }
    std::vector<float> distance(points.size());
    double latest = 0;
    const TransformStatistics statistics = transform.query(
        points, no_limit, distance, {.progress = when_computing([&](double fraction) { latest = fraction; })});
    BOOST_TEST(std::ranges::equal(distance, all.distance()));
    BOOST_TEST(latest == 1.0);
    BOOST_TEST(statistics.work->triangles == mesh.triangles().size());
    BOOST_TEST(transform.memory().device_bytes > 0U);
    transform.query({}, 1, std::span(distance).first(0));
    std::vector<float> nothing;
    const std::vector<Vec3> no_points;
    transform.query(no_points, 1, {{Output::distance, nothing}, {Output::gradient, nothing}});
}

// Each changed line stands for wrong code that a compiler makes of a right one.
BOOST_AUTO_TEST_CASE(a_device_that_finds_wrong_triangles_is_refused) {
    struct Change {
        const char* file;
        const char* from;
        const char* to;
        std::vector<KernelBody> bodies{both_bodies.begin(), both_bodies.end()};
    };
    const std::vector<Change> changes{
        {"points.cl", "(y - altitude) - o.across * o.away", "(y - altitude) + o.across * o.away", {by_vector}},
        {"points.cl", "return most * most", "return 0.9f * most * most", {by_vector}},
        {"points.cl", "((1u << children) - 1u)", "((1u << children) - 2u)", {by_vector}},
        {"nearest_by_group.cl", "(y - altitude) - o.across * o.away", "(y - altitude) + o.across * o.away", {by_group}},
        {"nearest_by_group.cl", "farther <= bound_of(query)", "farther <= 0.9f * bound_of(query)", {by_group}},
        {"nearest_by_group.cl", "if (upper < found->low)", "if (upper < found->low + 1.0f)", {by_group}},
        {"point_signs.cl", "entry >> CLSDF_PLACE_SHIFT != 0", "entry >> CLSDF_PLACE_SHIFT > 1u", {by_group}},
        {"binary_tree.cl", "(end - 1u - i) <<", "(end - 1u - i) / 2u <<", {by_group}},
        {"binary_tree.cl", "GREATER(other->upper[axis], box->upper[axis])", "box->upper[axis]", {by_group}},
        {"points.cl", "inside ? -rounded : rounded", "rounded"},
        {"point_scan.cl", "chosen[length] = list ? list[k] : k", "chosen[length] = list ? list[i] : i", {by_vector}},
        {"point_scan.cl", "outward * outward + z * z", "outward * outward", {by_vector}},
        {"point_scan.cl",
         "lowest_face(all_faces, brick->face[i])",
         "lowest_face(all_faces, brick->face[0])",
         {by_vector}},
        {"point_scan.cl", "o.across * o.beyond - o.along * y", "o.across * o.beyond + o.along * y", {by_vector}}};
    for (const auto& [file, from, to, bodies] : changes)
        for (const KernelBody body : bodies) {
            const TemporaryFolder folder;
            const Device device = Device::strongest();
            device.keep_records(folder.file("cache"));
            bool is_found = false;
            device::context_of(device).set_text_edit([&](std::string_view name, std::string& text) {
                const std::size_t at = text.find(from);
                if (name != file || at == std::string::npos) return;
                is_found = true;
                text.replace(at, std::strlen(from), to);
            });
            const DistanceTransform transform(device, cube(1), {.body = body});
            const bool are_many = std::string(file) == "point_scan.cl";
            const std::vector<Vec3> points(are_many ? 20000 : 500, {0.5, 0, 0});
            std::vector<float> distance(points.size());
            BOOST_TEST_CONTEXT(file << ": " << to)
            check_throws(ErrorCode::wrong_results, {"computes wrong fields", "points"},
                         [&] { transform.query(points, 1, distance); });
            BOOST_TEST(is_found, from);
        }
}
