// Transforms of the outer surface: what they tell of the faces as given, and that they are those of outer()'s mesh.

#include "core/vectors.hpp"
#include "support/box_unions.hpp"
#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/queries.hpp"
#include "support/random_meshes.hpp"
#include "support/throws.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/outer.hpp>
#include <clsdf/papers.hpp>

#include <boost/test/unit_test.hpp>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr TransformOptions of_outer{.surface = Surface::outer};
constexpr std::uint8_t in_face = 6, on_cut = 7;

/// Two boxes that overlap at a corner, without faces in one plane.
const Box first_box{{0, 0, 0}, {1, 1, 1}}, second_box{{0.3, 0.4, 0.5}, {1.5, 1.6, 1.7}};
Mesh two_boxes() {
    return together({test::box(first_box.lower, first_box.upper), test::box(second_box.lower, second_box.upper)},
                    "two boxes");
}

bool is_on(const Box& box, const Vec3& point) {
    bool is_within = true, is_at_side = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double low = point[axis] - box.lower[axis], high = box.upper[axis] - point[axis];
        is_within = is_within && low >= -1e-9 && high >= -1e-9;
        is_at_side = is_at_side || std::abs(low) <= 1e-9 || std::abs(high) <= 1e-9;
    }
    return is_within && is_at_side;
}

Vec3 point_of(const Mesh& mesh, std::uint32_t triangle, double w1, double w2) {
    return on_triangle(mesh, triangle, 1 - w1 - w2, w1);
}

double apart(const Vec3& a, const Vec3& b) {
    return length(difference(a, b));
}

/// A grid whose samples lie on no plane of the boxes.
Grid grid_of_boxes(std::int64_t size = 25) {
    Grid grid;
    const double h = 2.6 / static_cast<double>(size);
    grid.origin = {-0.4217, -0.4291, -0.4359};
    grid.spacing = {h, h, h};
    grid.size = {size, size, size};
    return grid;
}

/// That triangles, sites and barycentric coordinates of two_boxes() name the closest point.
void check_names(const Mesh& mesh, const Field& field, std::size_t count) {
    std::array<std::size_t, 8> found{};
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t triangle = field.triangle()[i];
        const std::uint8_t site = field.site()[i];
        const Vec3 closest{field.closest()[3 * i], field.closest()[3 * i + 1], field.closest()[3 * i + 2]};
        const auto w1 = static_cast<double>(field.barycentric()[2 * i]),
                   w2 = static_cast<double>(field.barycentric()[2 * i + 1]);
        const std::array<double, 3> weights{1 - w1 - w2, w1, w2};
        std::size_t zeros = 0, ones = 0;
        for (const double weight : weights) {
            zeros += std::abs(weight) < 1e-6 ? 1U : 0U;
            ones += std::abs(weight - 1) < 1e-6 ? 1U : 0U;
        }
        bool is_right = site <= on_cut && triangle < mesh.triangles().size() &&
                        apart(point_of(mesh, triangle, w1, w2), closest) < 1e-6;
        const bool is_cut = is_on(first_box, closest) && is_on(second_box, closest);
        is_right = is_right && (site == on_cut) == is_cut;
        if (site < 3)
            is_right = is_right && ones == 1 && std::abs(weights[site] - 1) < 1e-6;
        else if (site < in_face)
            is_right = is_right && zeros == 1 && std::abs(weights[(site - 1U) % 3]) < 1e-6;
        else if (site == in_face)
            is_right = is_right && zeros == 0;
        else
            is_right = is_right && triangle < 12;  // of the first box
        ++found[std::min<std::size_t>(site, on_cut)];
        if (!is_right && wrong++ == 0)
            BOOST_TEST_MESSAGE("sample " << i << ": triangle " << triangle << ", site " << int{site} << ", weights "
                                         << w1 << ", " << w2 << ", closest " << closest[0] << ", " << closest[1] << ", "
                                         << closest[2]);
    }
    BOOST_TEST(wrong == 0U);
    BOOST_TEST(found[in_face] > 100U);
    BOOST_TEST(found[on_cut] > 20U);
    BOOST_TEST(found[3] + found[4] + found[5] > 20U);
    BOOST_TEST(found[0] + found[1] + found[2] > 5U);
}

/// An icosahedron in the unit sphere whose faces are divided into four, so many times.
Mesh icosphere(int divisions) {
    const double golden = (1 + std::sqrt(5.0)) / 2;
    std::vector<Vec3> vertices;
    for (const double one : {-1.0, 1.0})
        for (const double other : {-golden, golden})
            for (std::size_t axis = 0; axis < 3; ++axis) {
                Vec3 vertex{};
                vertex[axis] = one;
                vertex[(axis + 1) % 3] = other;
                vertices.push_back(vertex);
            }
    std::vector<Triangle> triangles;
    for (std::uint32_t a = 0; a < 12; ++a)
        for (std::uint32_t b = a + 1; b < 12; ++b)
            for (std::uint32_t c = b + 1; c < 12; ++c) {
                const Vec3 &p = vertices[a], &q = vertices[b], &r = vertices[c];
                if (apart(p, q) > 2.1 || apart(q, r) > 2.1 || apart(p, r) > 2.1) continue;
                const bool is_outwards = dot(cross(difference(q, p), difference(r, p)), p) > 0;
                triangles.push_back(is_outwards ? Triangle{a, b, c} : Triangle{a, c, b});
            }
    for (int division = 0; division < divisions; ++division) {
        std::vector<Triangle> divided;
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [place, is_new] =
                middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(vertices.size()));
            if (is_new) {
                Vec3 sum{};
                for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] = vertices[a][axis] + vertices[b][axis];
                const double scale = std::sqrt(1 + golden * golden) / length(sum);
                vertices.push_back({scale * sum[0], scale * sum[1], scale * sum[2]});
            }
            return place->second;
        };
        for (const auto& [a, b, c] : triangles) {
            const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            divided.insert(divided.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
        }
        triangles = std::move(divided);
    }
    return scaled({std::move(vertices), std::move(triangles), "icosphere"}, 1 / std::sqrt(1 + golden * golden));
}

Field of_points(const DistanceTransform& transform, const Grid& grid) {
    return query(transform, samples_of(grid));
}

/// All outputs but those that tell triangles.
void check_same_places(const FieldSlab& one, const FieldSlab& other) {
    for (const Output output : {Output::distance, Output::closest, Output::gradient, Output::offset})
        BOOST_TEST(same_bytes(one, other, output), info_of(output).name << " differs");
}

}  // namespace

BOOST_AUTO_TEST_CASE(fields_and_points_of_two_boxes) {
    const Mesh mesh = two_boxes();
    const Cells cells({first_box, second_box});
    const Grid grid = grid_of_boxes();
    for (const KernelBody body : both_bodies) {
        const DistanceTransform transform(test_device(), mesh, {.body = body, .surface = Surface::outer});
        const Field field = transform.compute(grid, Band::full(), all_outputs()), points = of_points(transform, grid);
        const std::vector<Vec3> samples = samples_of(grid);
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < samples.size(); ++i) {
            bool is_inside = false;
            for (const Box& box : {first_box, second_box}) {
                bool is_in_box = true;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    is_in_box = is_in_box && samples[i][axis] > box.lower[axis] && samples[i][axis] < box.upper[axis];
                is_inside = is_inside || is_in_box;
            }
            const double expected = (is_inside ? -1 : 1) * cells.distance(samples[i]);
            for (const Field* found : {&field, &points})
                if (std::abs(static_cast<double>(found->distance()[i]) - expected) > 2e-6 * std::abs(expected) + 1e-7)
                    ++wrong;
        }
        BOOST_TEST(wrong == 0U);
        check_names(mesh, field, samples.size());
        check_names(mesh, points, samples.size());
    }
}

BOOST_AUTO_TEST_CASE(they_are_those_of_its_mesh) {
    Random random(5);
    const Mesh mesh = together({two_boxes(), shifted(make_shape("sphere3"), {0.8, 0.1, 0.2})}, "three bodies");
    const OuterSurface surface = outer(mesh);
    const DistanceTransform transform(test_device(), mesh, of_outer), plain(test_device(), surface.mesh);
    BOOST_TEST(transform.topology().partial_faces == surface.partial_faces);
    BOOST_TEST(transform.topology().hidden_faces == surface.hidden_faces);
    BOOST_TEST(transform.topology().parts == 3U);
    BOOST_TEST(plain.topology().hidden_faces == 0U);
    const auto told = [&](std::uint32_t triangle) {
        return triangle == no_triangle ? triangle : surface.faces[triangle];
    };
    const Grid grid = grid_around(mesh, 30, 3);
    const Band band = Band::symmetric(3 * grid.voxel());

    const Field field = transform.compute(grid, band, all_outputs()), other = plain.compute(grid, band, all_outputs());
    check_same_places(field.slab(), other.slab());
    bool are_same = true;
    for (std::size_t i = 0; i < field.triangle().size(); ++i)
        are_same = are_same && field.triangle()[i] == told(other.triangle()[i]);
    BOOST_TEST(are_same);

    // A part of it, and its bricks.
    const Grid part = grid.part({4, 5, 6}, {9, 8, 10});
    Region region;
    region.box = part.box();
    region.half_width = band.outside;
    region.spacing = grid.voxel();
    const DistanceTransform restricted = transform.restrict_to(region);
    BOOST_TEST(same_bytes(restricted.compute(part, band, all_outputs()), part_of(field, part)));
    const SparseField sparse = transform.compute_sparse(grid, band, all_outputs());
    are_same = true;
    for (std::int64_t k = 0; k < grid.size[2]; ++k)
        for (std::int64_t j = 0; j < grid.size[1]; ++j)
            for (std::int64_t i = 0; i < grid.size[0]; ++i)
                if (const auto brick = sparse.find({grid.first[0] + i, grid.first[1] + j, grid.first[2] + k})) {
                    const std::size_t in_field = grid.offset(i, j, k);
                    const auto in_brick = [&](std::size_t axis, std::int64_t n) {
                        return static_cast<std::size_t>((grid.first[axis] + n) & 7);
                    };
                    const std::size_t at = 512 * *brick + in_brick(0, i) + 8 * in_brick(1, j) + 64 * in_brick(2, k);
                    are_same = are_same && sparse.triangle()[at] == field.triangle()[in_field] &&
                               sparse.site()[at] == field.site()[in_field];
                }
    BOOST_TEST(are_same);

    // Links, crossings and rays.
    const std::vector<LinkDirection> directions = stencil("D3Q19");
    const Links links = transform.links(grid, directions), of_plain = plain.links(grid, directions);
    BOOST_TEST((links.q == of_plain.q));
    are_same = links.size() == of_plain.size() && links.size() > 100;
    for (std::size_t n = 0; n < links.size() && are_same; ++n)
        are_same = links.triangles[n] == told(of_plain.triangles[n]);
    BOOST_TEST(are_same);
    const Links of_part = restricted.links(part.part({2, 2, 2}, {4, 4, 4}), directions),
                of_whole = transform.links(part.part({2, 2, 2}, {4, 4, 4}), directions);
    BOOST_TEST((of_part.triangles == of_whole.triangles));
    const std::size_t count = 200;
    std::vector<Vec3> origins, along;
    for (std::size_t i = 0; i < count; ++i) {
        origins.push_back(random.point(-1, 2.5));
        along.push_back(difference(random.point(0, 1.5), origins.back()));
    }
    std::vector<double> t(2 * count), t_of_plain(2 * count);
    std::vector<std::uint32_t> hit(2 * count), hit_of_plain(2 * count);
    transform.rays(origins, along, {}, {.most = 2, .t = t, .triangles = hit});
    plain.rays(origins, along, {}, {.most = 2, .t = t_of_plain, .triangles = hit_of_plain});
    BOOST_TEST((t == t_of_plain));
    for (std::uint32_t& triangle : hit_of_plain) triangle = told(triangle);
    BOOST_TEST((hit == hit_of_plain));
    BOOST_TEST(std::ranges::count(hit, no_triangle) < std::ptrdiff_t(count));
}

// Box and sphere of 1,280 faces: cubic millimetres within 2 mm inside, by samples 1 mm apart.
BOOST_AUTO_TEST_CASE(a_sphere_sunken_in_a_box) {
    const Mesh sphere = icosphere(3);
    BOOST_REQUIRE(sphere.triangles().size() == 1280U);
    Grid grid;
    grid.origin = {-30.487, -20.487, -10.487};
    grid.size = {62, 42, 56};
    for (const auto& [z, expected, as_given] : {std::array{10, 17713, 27844}, {20, 20409, 25351}, {24, 21775, 23846}}) {
        const Mesh mesh = together(
            {test::box({-30, -20, -10}, {30, 20, 10}), shifted(scaled(sphere, 18), {0, 0, static_cast<double>(z)})},
            "sunken sphere");
        const auto volume = [&](Surface surface) {
            const Field field =
                DistanceTransform(test_device(), mesh, {.surface = surface}).compute(grid, Band::symmetric(3));
            return std::ranges::count_if(field.distance(), [](float d) { return d < 0 && d > -2; });
        };
        BOOST_TEST(volume(Surface::outer) == expected);
        BOOST_TEST(volume(Surface::given) == as_given);
    }
}

BOOST_AUTO_TEST_CASE(a_mesh_that_is_its_outer_surface_has_the_same_bytes) {
    for (const Mesh& mesh : {make_shape("sphere2"), unwelded(make_shape("torus")),
                             together({cube(1), shifted(cube(1), {3, 0, 0})}, "two cubes")}) {
        const DistanceTransform given(test_device(), mesh), outer(test_device(), mesh, of_outer);
        const Grid grid = grid_around(mesh, 20, 2);
        const Band band = Band::symmetric(3 * grid.voxel());
        BOOST_TEST(same_bytes(given.compute(grid, band, all_outputs()), outer.compute(grid, band, all_outputs())));
        BOOST_TEST(same_bytes(of_points(given, grid), of_points(outer, grid)));
        BOOST_TEST(outer.topology().partial_faces == 0U);
        BOOST_TEST(outer.topology().hidden_faces == 0U);
    }
}

BOOST_AUTO_TEST_CASE(one_that_moves_is_cut_anew) {
    const Mesh mesh = two_boxes();
    const Grid grid = grid_of_boxes(12);
    const auto field_of = [&](const DistanceTransform& transform) {
        return transform.compute(grid, Band::full(), all_outputs());
    };
    DistanceTransform transform(test_device(), mesh, of_outer);
    const Field first = field_of(transform);
    std::vector<Vec3> moved = mesh.vertices();
    for (std::size_t v = 8; v < 16; ++v) moved[v][0] += 0.15;
    transform.set_positions(moved);
    const DistanceTransform again(test_device(), {moved, mesh.triangles(), "two boxes"}, of_outer);
    BOOST_TEST(same_bytes(field_of(transform), field_of(again)));
    BOOST_TEST(same_bytes(of_points(transform, grid), of_points(again, grid)));
    BOOST_TEST(!same_bytes(field_of(transform), first));

    // Errors leave it as it was.
    const std::vector<Vec3> too_few(15), at_one_point(16, Vec3{1, 2, 3});
    check_throws(ErrorCode::invalid_argument, {"16 vertices"}, [&] { transform.set_positions(too_few); });
    BOOST_CHECK_THROW(transform.set_positions(at_one_point), Error);
    BOOST_TEST(same_bytes(field_of(transform), field_of(again)));

    // A motion is one of the first positions.
    const std::array<Vec3, 3> turn{{{0.6, -0.8, 0}, {0.8, 0.6, 0}, {0, 0, 1}}};
    transform.set_motion(turn, {0.1, 0.2, 0.3});
    DistanceTransform turned(test_device(), outer(mesh).mesh);
    turned.set_motion(turn, {0.1, 0.2, 0.3});
    check_same_places(field_of(transform).slab(), field_of(turned).slab());
    BOOST_TEST((transform.box().lower == turned.box().lower));
    // And back.
    transform.set_positions(mesh.vertices());
    BOOST_TEST(same_bytes(field_of(transform), first));
}

BOOST_AUTO_TEST_CASE(plans_keep_the_surface_that_they_were_made_of) {
    const Mesh mesh = two_boxes();
    const Grid grid = grid_of_boxes(12);
    const Band band = Band::symmetric(4 * grid.voxel());
    DistanceTransform transform(test_device(), mesh, of_outer);
    const Field first = transform.compute(grid, band);
    const DeviceMemory memory(test_device().context(), grid.sample_count());
    const Request request{grid, band, memory.handle()};
    Plan plan = transform.plan({&request, 1});
    std::vector<Vec3> moved = mesh.vertices();
    for (std::size_t v = 8; v < 16; ++v) moved[v][0] += 0.15;
    transform.set_positions(moved);
    const device::Context& context = device::context_of(test_device());
    const cl::CommandQueue queue(context.context(), context.device());
    plan.enqueue(queue());
    queue.finish();
    BOOST_TEST((memory.read(queue) == bits_of(first.distance())));
    plan.update(transform);
    plan.enqueue(queue());
    queue.finish();
    BOOST_TEST((memory.read(queue) == bits_of(transform.compute(grid, band).distance())));
}

BOOST_AUTO_TEST_CASE(coinciding_faces_are_told_by_the_lowest) {
    const Mesh mesh = together({cube(1), cube(1)}, "twice");
    std::vector<std::string> said;
    const CallOptions call{.log = [&](const std::string& message) { said.push_back(message); }};
    const DistanceTransform transform(test_device(), mesh, of_outer, call);
    BOOST_TEST(transform.topology().hidden_faces == 12U);
    BOOST_REQUIRE(said.size() == 1U);
    BOOST_TEST(said[0].find("12 of 24 faces are not on the outer surface") != std::string::npos, said[0]);
    const Field field = of_points(transform, grid_around(mesh, 8, 2));
    BOOST_TEST(*std::ranges::max_element(field.triangle()) < 12U);
    BOOST_TEST(*std::ranges::max_element(field.site()) == in_face);
}

BOOST_AUTO_TEST_CASE(closed_edges_are_told_as_edges_of_the_faces_as_given) {
    // A box whose bottom is two rectangles: corners lie in the edges of the sides across y. Faces may look either way.
    std::vector<Vec3> vertices;
    for (unsigned i = 0; i < 8; ++i) vertices.push_back({(i & 1U) * 1.0, (i >> 1 & 1U) * 1.0, (i >> 2 & 1U) * 1.0});
    vertices.insert(vertices.end(), {{0.5, 0, 0}, {0.5, 1, 0}});
    // The sides come first, so that what is nearest in an edge is told of them.
    const std::vector<Triangle> box{{0, 1, 5}, {2, 7, 3}, {0, 5, 4}, {2, 6, 7}, {0, 2, 9}, {0, 9, 8}, {8, 9, 3},
                                    {8, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    // Tilted, the triangles that close the edges have an area by rounding.
    for (const double angle : {0.0, 0.6, 0.9, 1.1})
        for (const bool is_turned : {false, true}) {
            std::vector<Triangle> triangles = box;
            for (const std::size_t face : {0U, 1U})  // those with the edges
                if (is_turned) std::swap(triangles[face][1], triangles[face][2]);
            const Mesh plain(vertices, triangles, "box"), mesh = angle == 0 ? plain : tilted(plain, angle);
            const DistanceTransform transform(test_device(), mesh, of_outer);
            std::vector<Vec3> points;
            for (const std::uint32_t from : {0U, 2U})
                for (const double along : {0.05, 0.1, 0.2, 0.3, 0.4, 0.45, 0.55, 0.6, 0.7, 0.8, 0.9, 0.95}) {
                    const Vec3 &a = mesh.vertices()[from], &b = mesh.vertices()[from + 1],
                               &across = mesh.vertices()[from == 0 ? 7 : 5];
                    Vec3 point{};
                    for (std::size_t k = 0; k < 3; ++k)
                        point[k] = a[k] + along * (b[k] - a[k]) + 0.2 * (b[k] - across[k]);
                    points.push_back(point);
                }
            const Field found = query(transform, points);
            for (std::size_t i = 0; i < points.size(); ++i) {
                const Vec3 closest{found.closest()[3 * i], found.closest()[3 * i + 1], found.closest()[3 * i + 2]};
                const Vec3 told = point_of(mesh, found.triangle()[i], static_cast<double>(found.barycentric()[2 * i]),
                                           static_cast<double>(found.barycentric()[2 * i + 1]));
                BOOST_TEST(apart(told, closest) < 1e-6, "angle " << angle << ", point " << i);
            }
        }
}

BOOST_AUTO_TEST_CASE(what_has_no_outer_surface_is_refused) {
    const Mesh open = without_triangle(cube(1), 3);
    const auto make = [](const Mesh& mesh, SignRule sign) {
        return DistanceTransform(test_device(), mesh, {.sign = sign, .surface = Surface::outer});
    };
    check_throws(ErrorCode::unsupported, {"nonzero or parity", "none"}, [&] { make(cube(1), SignRule::none); });
    check_throws(ErrorCode::unsupported, {"nonzero or parity", "close_down"}, [&] { make(open, SignRule::automatic); });
    check_throws(ErrorCode::invalid_mesh, {"nonzero"}, [&] { make(open, SignRule::nonzero); });
    check_throws(ErrorCode::unsupported, {"clsdf::papers", "outer()"},
                 [&] { make_transform(test_device(), cube(1), {.polyhedra = Polyhedra::mauch}, of_outer); });
    BOOST_TEST(std::string(name_of(Surface::outer)) == "outer");
    BOOST_TEST((make(two_boxes(), SignRule::parity).sign() == SignRule::parity));
}
