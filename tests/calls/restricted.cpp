#include "calls/regions.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/throws.hpp"

#include <clsdf/tuning.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <vector>

// A transform that is restricted to a box gives the bytes of the whole one there.

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr std::array both_bodies{KernelBody::by_vector, KernelBody::by_group};

/// The group body, which a processor takes long for, gets two of them.
std::vector<Mesh> meshes(KernelBody body) {
    Random random(17);
    if (body == KernelBody::by_group) return {tilted(make_shape("knot")), random_slivers(random, 300)};
    return {
        tilted(make_shape("noisy")), make_shape("sphere5"), without_triangle(make_shape("knot"), 7),
        together({cube(1), shifted(make_shape("sphere4"), {0.7, 0.6, 0.5}), reversed(shifted(cube(0.3), {9, 0, 0}))},
                 "overlapping"),
        random_slivers(random, 400)};
}

}  // namespace

BOOST_AUTO_TEST_CASE(grids_in_the_box_have_the_bytes_of_the_whole) {
    for (const KernelBody body : both_bodies)
        for (const Mesh& mesh : meshes(body)) {
            const double side = mesh.box().longest_side();
            const DistanceTransform whole(test_device(), mesh, {.body = body});
            for (const Box& box : boxes_about(mesh)) {
                const double h = side / 40;
                const double half_width = 9 * h;
                const DistanceTransform part = whole.restrict_to({box, half_width, h});
                for (const double spacing : {h, 0.43 * h})
                    for (const double voxels : {2.5, 9.0}) {
                        const Grid grid = samples_in(box, spacing, {0.1 * side, -0.3 * side, 0.2 * side});
                        if (!is_inside(grid, box)) continue;
                        const Band band{0.7 * voxels * spacing, voxels * spacing};
                        BOOST_TEST_CONTEXT(mesh.name()
                                           << ", spacing " << spacing << ", band of " << voxels << " voxels, box from "
                                           << box.lower[0] << ", " << box.lower[1] << ", " << box.lower[2])
                        check_same(whole.compute(grid, band, all_outputs()), part.compute(grid, band, all_outputs()));
                    }
            }
        }
}

// The box ends almost a half width before the surface, which is finer than the other meshes.
BOOST_AUTO_TEST_CASE(a_part_has_all_that_is_within_the_half_width_of_its_box) {
    const Mesh mesh = make_shape("sphere6");
    const double h = 0.004, half_width = 0.4;
    const Box box{{-1.45, -0.1, -0.1}, {-1.39, 0.1, 0.1}};
    const Grid grid = samples_in(box, h, {0.001, 0.002, 0.003});
    for (const KernelBody body : both_bodies) {
        const DistanceTransform whole(test_device(), mesh, {.body = body});
        const Field expected = whole.compute(grid, Band::symmetric(half_width), all_outputs());
        BOOST_TEST(static_cast<double>(std::ranges::min(expected.distance())) < half_width);
        check_same(expected,
                   whole.restrict_to({box, half_width, h}).compute(grid, Band::symmetric(half_width), all_outputs()));
    }
}

BOOST_AUTO_TEST_CASE(points_and_boxes_in_the_box_have_the_answers_of_the_whole) {
    for (const KernelBody body : both_bodies)
        for (const Mesh& mesh : meshes(body)) {
            const double side = mesh.box().longest_side(), half_width = 0.1 * side;
            const DistanceTransform whole(test_device(), mesh, {.body = body});
            Random random(3);
            for (const Box& box : boxes_about(mesh)) {
                const DistanceTransform part = whole.restrict_to({box, half_width, side / 100});
                std::vector<Vec3> points(2000);
                std::vector<Box> boxes(500);
                const auto place = [&] {
                    Vec3 p{};
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        p[axis] =
                            std::clamp(box.lower[axis] + random.uniform(0, 1) * (box.upper[axis] - box.lower[axis]),
                                       box.lower[axis], box.upper[axis]);
                    return p;
                };
                for (Vec3& p : points) p = place();
                for (Box& b : boxes) {
                    const Vec3 p = place(), q = place();
                    for (std::size_t axis = 0; axis < 3; ++axis) {
                        b.lower[axis] = std::min(p[axis], 0.9 * p[axis] + 0.1 * q[axis]);
                        b.upper[axis] = std::max(p[axis], 0.9 * p[axis] + 0.1 * q[axis]);
                    }
                }
                BOOST_TEST_CONTEXT(mesh.name()
                                   << ", box from " << box.lower[0] << ", " << box.lower[1] << ", " << box.lower[2]) {
                    check_same(query(whole, points, half_width), query(part, points, half_width));
                    const std::span<const Vec3> few = std::span(points).first(300);
                    check_same(query(whole, few, 0.5 * half_width), query(part, few, 0.5 * half_width));
                    std::vector<BoxPlace> of_whole(boxes.size()), of_part(boxes.size());
                    whole.classify(boxes, half_width, of_whole);
                    part.classify(boxes, half_width, of_part);
                    BOOST_TEST((of_whole == of_part));
                }
            }
        }
}

// Cubes in a diagonal row: neighbours share an edge of four faces, of which a part may have one or two.
BOOST_AUTO_TEST_CASE(a_part_with_some_faces_of_an_edge_has_the_names_of_the_whole) {
    std::vector<Mesh> cubes;
    for (int i = 0; i < 100; ++i) cubes.push_back(shifted(cube(0.5), {i + 0.5, i + 0.5, 0.5}));
    const Mesh mesh = weld(together(cubes, "cubes"));
    for (const SignRule sign : {SignRule::automatic, SignRule::none}) {
        const DistanceTransform whole(test_device(), mesh, {.sign = sign});
        for (int i = 0; i < 100; i += 7) {
            const Vec3 top{i + 0.5, i + 0.5, 0.95};
            const Box box{{top[0] - 0.02, top[1] - 0.02, 0.93}, {top[0] + 0.02, top[1] + 0.02, 0.97}};
            const DistanceTransform part = whole.restrict_to({box, 0.1, 0.01});
            const Grid grid = samples_in(box, 0.01, {0, 0, 0});
            check_same(whole.compute(grid, Band::symmetric(0.1), all_outputs()),
                       part.compute(grid, Band::symmetric(0.1), all_outputs()));
            const std::array<Vec3, 1> points{top};
            check_same(query(whole, points, 0.1), query(part, points, 0.1));
        }
    }
}

BOOST_AUTO_TEST_CASE(a_part_outlives_the_whole_and_takes_a_part_of_its_memory) {
    const Mesh mesh = make_shape("sphere7");
    const Box eighth{{0, 0, 0}, {1.1, 1.1, 1.1}};
    const double h = 0.002;
    const Grid grid = samples_in({{0.5, 0.5, 0.5}, {0.6, 0.6, 0.7}}, h, {0, 0, 0});
    std::optional<DistanceTransform> whole(std::in_place, test_device(), mesh);
    const DistanceTransform part = whole->restrict_to({eighth, 3 * h, h});
    const Field expected = whole->compute(grid, Band::symmetric(3 * h));
    const KeptMemory of_whole = whole->memory();
    whole.reset();
    check_same(expected, part.compute(grid, Band::symmetric(3 * h)));
    // It keeps the octant and the octant before it, a fourth of the sphere, and a seam.
    BOOST_TEST(part.memory().host_bytes < of_whole.host_bytes * 4 / 10);
}

// First some that are small beside the part, each with records of its own, then the others with a selection of those
// that the part keeps.
BOOST_AUTO_TEST_CASE(grids_of_a_part_share_records_of_what_is_near_it) {
    const Mesh mesh = make_shape("sphere7");
    const double h = 0.01;
    const Box eighth{{0, 0, 0}, {1.1, 1.1, 1.1}};
    const Band band = Band::symmetric(3 * h);
    const DistanceTransform whole(test_device(), mesh, {.kept_bytes = std::size_t{1} << 30});
    const DistanceTransform part = whole.restrict_to({eighth, 3 * h, h});
    const Grid all = samples_in(eighth, h, {0.003, 0.003, 0.003});
    std::size_t most = 0;
    for (std::int64_t z = 0; z < all.size[2]; z += 28)
        for (std::int64_t y = 0; y < all.size[1]; y += 28)
            for (std::int64_t x = 0; x < all.size[0]; x += 28) {
                const Grid grid = all.part({x, y, z}, {std::min<std::int64_t>(28, all.size[0] - x),
                                                       std::min<std::int64_t>(28, all.size[1] - y),
                                                       std::min<std::int64_t>(28, all.size[2] - z)});
                check_same(whole.compute(grid, band), part.compute(grid, band));
                most = std::max(most, part.memory().device_bytes);
            }
    check_same(whole.compute(all, band), part.compute(all, band));
    // A record has 280 bytes; a GPU has 52 more of each face. Bricks and the band reach a tenth of a radius beyond the
    // octant: near them is a fifth of the sphere, and for the sign the part has half of it.
    const double records = 280 * static_cast<double>(mesh.triangles().size());
    const double of_faces = is_processor() ? 0 : 52 * static_cast<double>(mesh.triangles().size());
    BOOST_TEST(static_cast<double>(part.memory().device_bytes) < 0.35 * (records + of_faces));
    BOOST_TEST(static_cast<double>(most) > 0.1 * records);
}

BOOST_AUTO_TEST_CASE(many_boxes_of_a_part_go_into_one_call) {
    const Mesh mesh = tilted(make_shape("knot"));
    const double h = mesh.box().longest_side() / 80;
    const Box box = boxes_about(mesh).front();
    const DistanceTransform whole(test_device(), mesh);
    const DistanceTransform part = whole.restrict_to({box, 4 * h, h});
    const Grid all = samples_in(box, h, mesh.box().lower);
    const Grid outside = all.grown(2);
    std::vector<float> first(all.sample_count()), second(all.sample_count()), third(outside.sample_count());
    const Band band = Band::symmetric(4 * h);
    const std::array<Request, 2> right{Request{all, band, first}, Request{all, band, second}};
    part.compute(right);
    const Field expected = whole.compute(all, band);
    BOOST_TEST((bits_of(first) == bits_of(expected.distance())));
    BOOST_TEST((bits_of(second) == bits_of(expected.distance())));
    const std::array<Request, 2> wrong{right[0], Request{outside, band, third}};
    check_throws(ErrorCode::invalid_argument,
                 {"request 1 of 2", "reach from", "the nearest of its 1 regions is the box from"},
                 [&] { part.compute(wrong); });
}

BOOST_AUTO_TEST_CASE(what_a_part_cannot_answer_is_an_error_that_names_it) {
    const Mesh mesh = cube(1);
    const DistanceTransform whole(test_device(), mesh);
    const Box box{{0, 0, 0}, {1, 1, 1}};
    DistanceTransform part = whole.restrict_to({box, 0.3, 0.1});
    const Grid inside = samples_in(box, 0.1, {0, 0, 0});
    const char* const named =
        "the nearest of its 1 regions is the box from (0, 0, 0) to (1, 1, 1), for half widths up to 0.3";
    const auto refused = [&](const char* what, const auto& call) {
        check_throws(ErrorCode::invalid_argument, {what, named, "restrict the whole"}, call);
    };
    refused("samples reach from", [&] { part.compute(inside.grown(1), Band::symmetric(0.3)); });
    refused("half width 0.31", [&] { part.compute(inside, Band::symmetric(0.31)); });
    refused("half width inf", [&] { part.compute(inside, Band::full()); });
    refused("spacing is 0.2", [&] { part.compute(samples_in(box, 0.2, {0, 0, 0}), Band::symmetric(0.3)); });
    refused("samples reach from", [&] { part.plan(inside.grown(1), Band::symmetric(0.3)); });
    std::vector<float> distance(2);
    const std::vector<Vec3> points{{0.5, 0.5, 0.5}, {0.5, 1.5, 0.5}};
    refused("point 1 lies at (0.5, 1.5, 0.5)", [&] { part.query(points, 0.3, distance); });
    refused("within inf", [&] { part.query(points, std::numeric_limits<double>::infinity(), distance); });
    std::vector<BoxPlace> places(1);
    const std::vector<Box> outside{{{0, 0, 0}, {2, 1, 1}}};
    refused("box 0 reaches", [&] { part.classify(outside, 0.3, places); });
    check_throws(ErrorCode::unsupported, {"set the positions of the whole one"},
                 [&] { part.set_positions(mesh.vertices()); });
    check_throws(ErrorCode::unsupported, {"restrict the whole one"}, [&] { part.restrict_to({box, 0.1, 0.1}); });
    const double inf = std::numeric_limits<double>::infinity();
    for (const double wrong : {0.0, -0.1, inf, std::numeric_limits<double>::quiet_NaN()})
        check_throws(ErrorCode::invalid_argument, {"region 0 of 1", "half width", fmt::format("{}", wrong)}, [&] {
            whole.restrict_to({box, wrong, 0.1});
        });
    for (const double wrong : {-0.1, inf, std::numeric_limits<double>::quiet_NaN()})
        check_throws(ErrorCode::invalid_argument, {"region 0 of 1", "spacing", fmt::format("{}", wrong)}, [&] {
            whole.restrict_to({box, 0.1, wrong});
        });
    check_throws(ErrorCode::invalid_argument, {"corners exchanged"}, [&] {
        whole.restrict_to({{{1, 0, 0}, {0, 1, 1}}, 0.1, 0.1});
    });
}

// Of different boxes, half widths and spacings; two of them overlap.
BOOST_AUTO_TEST_CASE(each_of_several_regions_has_the_bytes_of_the_whole) {
    for (const KernelBody body : both_bodies)
        for (const Mesh& mesh : meshes(body)) {
            const double side = mesh.box().longest_side(), h = side / 60;
            const DistanceTransform whole(test_device(), mesh, {.body = body});
            std::vector<Region> regions;
            for (const Box& box : boxes_about(mesh)) {
                const auto n = static_cast<double>(regions.size());
                regions.push_back({box, (3 + n) * h, (0.4 + 0.2 * n) * h});
                if (regions.size() == 5) break;
            }
            const DistanceTransform part = whole.restrict_to(regions);
            Random random(9);
            for (const auto& [box, half_width, spacing] : regions)
                BOOST_TEST_CONTEXT(mesh.name() << ", half width " << half_width / h) {
                    for (const double fraction : {1.0, 0.6}) {
                        const Grid grid = samples_in(box, fraction * spacing, {0.1 * side, -0.3 * side, 0.2 * side});
                        if (!is_inside(grid, box)) continue;
                        const Band band{0.4 * half_width, fraction * half_width};
                        check_same(whole.compute(grid, band, all_outputs()), part.compute(grid, band, all_outputs()));
                    }
                    std::vector<Vec3> points(500);
                    std::vector<Box> boxes(100);
                    const auto place = [&, &box = box] {
                        Vec3 p{};
                        for (std::size_t axis = 0; axis < 3; ++axis)
                            p[axis] = std::clamp(random.uniform(box.lower[axis], box.upper[axis]), box.lower[axis],
                                                 box.upper[axis]);
                        return p;
                    };
                    for (Vec3& p : points) p = place();
                    for (Box& b : boxes) {
                        const Vec3 p = place(), q = place();
                        for (std::size_t axis = 0; axis < 3; ++axis)
                            b.lower[axis] = std::min(p[axis], q[axis]), b.upper[axis] = std::max(p[axis], q[axis]);
                    }
                    check_same(query(whole, points, half_width), query(part, points, half_width));
                    std::vector<BoxPlace> of_whole(boxes.size()), of_part(boxes.size());
                    whole.classify(boxes, half_width, of_whole);
                    part.classify(boxes, half_width, of_part);
                    BOOST_TEST((of_whole == of_part));
                }
        }
}

// As the leaves of a forest are: small boxes beside each other, and so many that none may look at all of them.
namespace {

/// A cube of 256 units, its sides divided into cells, below y = 0, and a tetrahedron above, so that the mesh's box has
/// room beside the cube's upper side.
Mesh cube_below_a_tetrahedron() {
    constexpr std::uint32_t cells = 64;
    constexpr double half = 128;
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    const auto add_side = [&](const auto& place) {
        const auto first = static_cast<std::uint32_t>(vertices.size());
        const auto at = [](std::uint32_t i) { return half * (2.0 * i / cells - 1); };
        for (std::uint32_t j = 0; j <= cells; ++j)
            for (std::uint32_t i = 0; i <= cells; ++i) vertices.push_back(place(at(i), at(j)));
        for (std::uint32_t j = 0; j < cells; ++j)
            for (std::uint32_t i = 0; i < cells; ++i) {
                const std::uint32_t a = first + j * (cells + 1) + i, d = a + cells + 1;
                triangles.push_back({a, a + 1, d + 1});
                triangles.push_back({a, d + 1, d});
            }
    };
    add_side([](double u, double v) { return Vec3{u, 0, -v}; });
    add_side([](double u, double v) { return Vec3{u, -2 * half, v}; });
    add_side([](double u, double v) { return Vec3{u, v - half, half}; });
    add_side([](double u, double v) { return Vec3{-u, v - half, -half}; });
    add_side([](double u, double v) { return Vec3{half, v - half, -u}; });
    add_side([](double u, double v) { return Vec3{-half, v - half, u}; });
    const auto first = static_cast<std::uint32_t>(vertices.size());
    for (const Vec3& v : {Vec3{0, 100, 0}, Vec3{1, 100, 0}, Vec3{0, 101, 0}, Vec3{0, 100, 1}}) vertices.push_back(v);
    for (const Triangle& t : {Triangle{0, 2, 1}, Triangle{0, 1, 3}, Triangle{0, 3, 2}, Triangle{1, 2, 3}})
        triangles.push_back({first + t[0], first + t[1], first + t[2]});
    return Mesh(vertices, triangles, "cube below a tetrahedron");
}

}  // namespace

// The surface between two regions is not in the part.
BOOST_AUTO_TEST_CASE(points_and_boxes_of_regions_on_both_sides_of_a_surface_have_their_own_signs) {
    const DistanceTransform whole(test_device(), cube_below_a_tetrahedron());
    const std::array regions{Region{{{-1, -6.5, -1}, {1, -6, 1}}, 0.5, 0}, Region{{{-1, 6, -1}, {1, 6.5, 1}}, 0.5, 0}};
    const DistanceTransform part = whole.restrict_to(regions);
    const auto distances = [](const DistanceTransform& transform, const std::vector<Vec3>& points) {
        std::vector<float> values(points.size());
        transform.query(points, 0.5, {{Output::distance, values}});
        return values;
    };
    std::vector<Vec3> points;
    for (int i = 0; i < 100; ++i)  // more than few
        for (const double y : {-6.2, 6.2}) points.push_back({0.01 * i, y, 0.2});
    for (const std::size_t count : {std::size_t{2}, points.size()}) {
        std::vector<Vec3> some(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(count));
        for (int way = 0; way < 2; ++way, std::ranges::reverse(some))
            BOOST_TEST(distances(part, some) == distances(whole, some), boost::test_tools::per_element());
    }
    BOOST_TEST(distances(part, points)[0] == -0.5F);
    BOOST_TEST(distances(part, points)[1] == 0.5F);
    std::vector<Box> boxes{{{0, -6.3, 0}, {0.1, -6.2, 0.1}}, {{0, 6.2, 0}, {0.1, 6.3, 0.1}}};
    for (int way = 0; way < 2; ++way, std::ranges::reverse(boxes)) {
        std::array<BoxPlace, 2> of_part{}, of_whole{};
        part.classify(boxes, 0.5, of_part);
        whole.classify(boxes, 0.5, of_whole);
        BOOST_TEST((of_part == of_whole));
        BOOST_TEST((of_part[0] == (way == 0 ? BoxPlace::inside : BoxPlace::outside)));
    }
}

BOOST_AUTO_TEST_CASE(a_hundred_thousand_regions_have_the_bytes_of_the_whole) {
    const Mesh mesh = make_shape("sphere4");
    const DistanceTransform whole(test_device(), mesh);
    constexpr std::int64_t samples = 8, leaves = 48;
    const double h = mesh.box().longest_side() / static_cast<double>(samples * leaves);
    Grid lattice;
    lattice.origin = mesh.box().lower;
    lattice.spacing = {h, h, h};
    std::vector<Region> regions;
    std::vector<Index3> firsts;
    for (std::int64_t k = 0; k < leaves; ++k)
        for (std::int64_t j = 0; j < leaves; ++j)
            for (std::int64_t i = 0; i < leaves - 4; ++i) {
                const Grid leaf = lattice.block({samples * i, samples * j, samples * k}, {samples, samples, samples});
                regions.push_back(
                    {{leaf.position(0, 0, 0), leaf.position(samples - 1, samples - 1, samples - 1)}, 4 * h, h});
                firsts.push_back(leaf.first);
            }
    BOOST_REQUIRE(regions.size() > 100'000U);
    const DistanceTransform part = whole.restrict_to(regions);
    const Band band = Band::symmetric(4 * h);
    // One leaf of a hundred.
    std::vector<Index3> some;
    for (std::size_t n = 0; n < firsts.size(); n += 100) some.push_back(firsts[n]);
    std::vector<float> of_whole(some.size() * samples * samples * samples), of_part(of_whole.size());
    const Index3 size{samples, samples, samples};
    whole.compute({lattice, band, size, some, of_whole});
    part.compute({lattice, band, size, some, of_part});
    BOOST_TEST(std::memcmp(of_whole.data(), of_part.data(), of_whole.size() * sizeof(float)) == 0);
    const Grid between = lattice.block({samples - 1, 0, 0}, {2, 1, 1});
    check_throws(ErrorCode::invalid_argument, {"the nearest of its"},
                 [&] { static_cast<void>(part.compute(between, band)); });
}

BOOST_AUTO_TEST_CASE(what_lies_in_no_region_is_refused_with_the_nearest_one) {
    const Mesh mesh = cube(1);
    const DistanceTransform whole(test_device(), mesh);
    const std::array regions{Region{{{-1.2, -1, -1}, {-0.2, 1, 1}}, 0.5, 0.1},
                             Region{{{-0.2, -1, -1}, {1.2, 1, 1}}, 0.3, 0.2}};
    const DistanceTransform part = whole.restrict_to(regions);
    const char* const first =
        "the nearest of its 2 regions is the box from (-1.2, -1, -1) to (-0.2, 1, 1), for half "
        "widths up to 0.5 and spacings up to 0.1";
    const char* const second =
        "the nearest of its 2 regions is the box from (-0.2, -1, -1) to (1.2, 1, 1), for half "
        "widths up to 0.3 and spacings up to 0.2";
    const auto refused = [&](const char* nearest, const auto& call) {
        check_throws(ErrorCode::invalid_argument, {nearest}, call);
    };
    std::vector<float> distance(2);
    std::vector<Vec3> points{{-1, 0, 0}, {1.1, 0, 0}};
    part.query(points, 0.3, distance);
    // Within the half width of one region only.
    check_throws(ErrorCode::invalid_argument, {"point 1 ", second}, [&] { part.query(points, 0.4, distance); });
    points[0][0] = -1.3;
    check_throws(ErrorCode::invalid_argument, {"point 0 ", first}, [&] { part.query(points, 0.3, distance); });
    // Each sample lies in a region, and not all of them in one.
    refused(first, [&] { part.compute(grid_at({-0.25, 0, 0}, 0.1, 2), Band::symmetric(0.3)); });
    refused(second, [&] { part.compute(grid_at({0, 0, 0}, 0.1, 3), Band::symmetric(0.3)); });
    // Too wide a spacing for the first, too wide a band for the second.
    refused(first, [&] { part.compute(grid_at({-0.7, 0, 0}, 0.2, 2), Band::symmetric(0.3)); });
    refused(second, [&] { part.compute(grid_at({0.5, 0, 0}, 0.1, 2), Band::symmetric(0.4)); });
    check_same(whole.compute(grid_at({0.5, 0, 0}, 0.2, 2), Band::symmetric(0.3)),
               part.compute(grid_at({0.5, 0, 0}, 0.2, 2), Band::symmetric(0.3)));
    std::vector<BoxPlace> places(1);
    const std::vector<Box> across{{{-0.4, 0, 0}, {-0.1, 0.5, 0.5}}};
    refused(first, [&] { part.classify(across, 0.3, places); });
}

BOOST_AUTO_TEST_CASE(a_region_that_makes_no_sense_is_named_by_its_index) {
    const DistanceTransform whole(test_device(), cube(1));
    const Region right{{{0, 0, 0}, {1, 1, 1}}, 0.3, 0.1};
    const double nan = std::numeric_limits<double>::quiet_NaN();
    std::array<Region, 4> wrong;
    wrong.fill(right);
    wrong[0].box.upper[1] = nan;
    wrong[1].box.lower[2] = 2;
    wrong[2].half_width = 0;
    wrong[3].spacing = -1;
    for (const Region& region : wrong) {
        const std::array regions{right, right, region, right};
        check_throws(ErrorCode::invalid_argument, {"region 2 of 4"}, [&] { whole.restrict_to(regions); });
    }
    check_throws(ErrorCode::invalid_argument, {"there is none"}, [&] { whole.restrict_to(std::span<const Region>()); });
}

BOOST_AUTO_TEST_CASE(a_region_without_a_spacing_is_for_points_and_boxes) {
    const Mesh mesh = tilted(make_shape("knot"));
    const DistanceTransform whole(test_device(), mesh);
    const Box box = boxes_about(mesh).front();
    const double half_width = 0.1 * mesh.box().longest_side();
    const DistanceTransform part = whole.restrict_to({box, half_width, 0});
    Random random(21);
    std::vector<Vec3> points(1000);
    for (Vec3& p : points)
        for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = random.uniform(box.lower[axis], box.upper[axis]);
    check_same(query(whole, points, half_width), query(part, points, half_width));
    const std::array boxes{box, Box{points[0], points[0]}};
    std::array<BoxPlace, 2> of_whole{}, of_part{};
    whole.classify(boxes, half_width, of_whole);
    part.classify(boxes, half_width, of_part);
    BOOST_TEST((of_whole == of_part));
    const Grid grid = grid_at(points[0], 1e-6, 0);
    check_throws(ErrorCode::invalid_argument, {"its spacing is 1e-06", "spacings up to 0"},
                 [&] { part.compute(grid, Band::symmetric(half_width)); });
}

BOOST_AUTO_TEST_CASE(a_part_of_a_moved_mesh_has_its_positions) {
    const Mesh mesh = tilted(make_shape("knot"));
    std::vector<Vec3> positions = mesh.vertices();
    for (Vec3& p : positions) p[0] += 0.2 * p[1] * p[1];
    DistanceTransform whole(test_device(), mesh);
    whole.set_positions(positions);
    const Box box = boxes_about(mesh).front();
    const double h = mesh.box().longest_side() / 80;
    const DistanceTransform part = whole.restrict_to({box, 4 * h, h});
    const Grid grid = samples_in(box, h, {0, 0, 0});
    check_same(whole.compute(grid, Band::symmetric(4 * h), all_outputs()),
               part.compute(grid, Band::symmetric(4 * h), all_outputs()));
}
