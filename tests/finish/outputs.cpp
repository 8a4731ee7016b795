#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include <clsdf/papers.hpp>
#include <clsdf/tuning.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <random>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr std::array both_bodies{KernelBody::by_vector, KernelBody::by_group};

Mesh needle() {
    return Mesh(std::vector<Vec3>{{0, 0, 0}, {10, 0.01, 0}, {10, 0, 0.013}, {10.02, -0.011, -0.009}},
                std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}, "needle");
}

std::vector<Mesh> meshes() {
    return {cube(1), reversed(cube(1)),  without_triangle(cube(1), 3), sliver(), needle(),
            fins(),  make_shape("knot"), tilted(make_shape("noisy"))};
}

/// Samples on the faces, edges and vertices of a cube of half side 1, and beside them.
Grid through_the_surface() {
    return grid_at({0, 0, 0}, 0.125, 11);
}

Vec3 vector_at(const auto& values, std::size_t sample) {
    return {static_cast<double>(values[3 * sample]), static_cast<double>(values[3 * sample + 1]),
            static_cast<double>(values[3 * sample + 2])};
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_output_of_every_sample_keeps_its_contract) {
    for (const Mesh& mesh : meshes()) {
        const Grid around = grid_around(mesh, 26, 4);
        for (const KernelBody body : both_bodies) {
            check_exact(mesh, compute(mesh, around, Band::symmetric(3 * around.voxel()), body), guaranteed);
            check_exact(mesh, compute(mesh, grid_around(mesh, 12, 2), Band::full(), body), guaranteed);
        }
    }
}

// The reference names the lowest triangle, and smaller sites before larger ones, as the contract asks for.
BOOST_AUTO_TEST_CASE(on_a_cube_the_outputs_are_those_of_the_reference) {
    for (const Mesh& mesh : {cube(1), reversed(cube(1)), unwelded(cube(1))}) {
        const Grid grid = through_the_surface();
        const Band band{0.4, 0.5};  // no sample is near a medial plane
        const Field expected = reference::reference_field(mesh, grid, band);
        for (const KernelBody body : both_bodies) {
            const Field field = compute(mesh, grid, band, body);
            std::size_t on_surface = 0;
            for (std::size_t sample = 0; sample < field.distance().size(); ++sample) {
                BOOST_REQUIRE_SMALL(field.distance()[sample] - expected.distance()[sample], 1.2e-7F);  // 2 ulp
                if (expected.distance()[sample] < 0) continue;  // there several faces may be as near
                BOOST_REQUIRE(field.triangle()[sample] == expected.triangle()[sample]);
                BOOST_REQUIRE(field.site()[sample] == expected.site()[sample]);
                on_surface += expected.distance()[sample] == 0 ? 1U : 0U;
                if (field.triangle()[sample] == no_triangle) {
                    BOOST_REQUIRE(std::isnan(field.closest()[3 * sample]) &&
                                  std::isnan(field.gradient()[3 * sample + 2]));
                    continue;
                }
                const auto is_near = [&](const Vec3& one, const Vec3& other, double tolerance) {
                    return std::hypot(one[0] - other[0], one[1] - other[1], one[2] - other[2]) <= tolerance;
                };
                BOOST_REQUIRE(
                    is_near(vector_at(field.closest(), sample), vector_at(expected.closest(), sample), 1e-12));
                BOOST_REQUIRE(
                    is_near(vector_at(field.gradient(), sample), vector_at(expected.gradient(), sample), 1e-6));
            }
            BOOST_TEST(on_surface == 17U * 17U * 17U - 15U * 15U * 15U);
        }
    }
}

// Turned inside out, a mesh has the same field, and so the same gradient, also on the surface.
BOOST_AUTO_TEST_CASE(on_the_surface_the_gradient_points_outside_however_the_faces_look) {
    const Grid grid = through_the_surface();
    for (const KernelBody body : both_bodies) {
        const Field field = compute(reversed(cube(1)), grid, Band::symmetric(0.3), body);
        const std::size_t on_face = grid.offset(11 + 8, 11, 13), on_edge = grid.offset(11 + 8, 11 + 8, 13);
        BOOST_TEST(field.distance()[on_face] == 0);
        BOOST_TEST(field.gradient()[3 * on_face] == 1.0F);
        BOOST_TEST(field.gradient()[3 * on_edge] == std::sqrt(0.5F), boost::test_tools::tolerance(1e-6F));
        BOOST_TEST(field.gradient()[3 * on_edge + 1] == std::sqrt(0.5F), boost::test_tools::tolerance(1e-6F));
    }
}

// Pseudonormals are made only for lattices with a sample on an edge or a vertex.
BOOST_AUTO_TEST_CASE(on_one_edge_or_vertex_of_many_the_gradient_is_the_pseudonormal) {
    constexpr unsigned seed = 5;
    BOOST_TEST_INFO("seed " << seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(0.1, 0.9);
    const Mesh mesh = tilted(make_shape("sphere3"));
    const DistanceTransform transform(test_device(), mesh);
    for (std::size_t n = 0; n < 24; ++n) {
        const Triangle& triangle = mesh.triangles()[random() % mesh.triangles().size()];
        const Vec3 &a = mesh.vertices()[triangle[n % 3]], &b = mesh.vertices()[triangle[(n + 1) % 3]];
        const double part = n % 4 == 0 ? 0 : any(random);
        Vec3 point{};
        for (std::size_t axis = 0; axis < 3; ++axis) point[axis] = std::lerp(a[axis], b[axis], part);
        const double length = std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
        const double samples = n % 5 == 0 ? 300 : 1 + 2 * any(random);  // on the edge
        const Grid grid = grid_at(point, length / samples, 2);
        const Field field = transform.compute(grid, Band::symmetric(2 * grid.voxel()), all_outputs());
        const std::uint8_t site = field.site()[grid.offset(2, 2, 2)];
        BOOST_TEST((part == 0 ? site < 3 : site >= 3 && site < 6));
        check_exact(mesh, field, guaranteed);
    }
}

// A face's longest edge runs through its third corner, or two corners lie at one place.
BOOST_AUTO_TEST_CASE(at_a_vertex_of_a_face_without_area_the_site_is_the_vertex) {
    for (const double x : {1.0, 0.5, 0.0, 2.0})
        for (std::uint32_t first = 0; first < 3; ++first)
            for (const std::array<std::uint32_t, 3> turn : {std::array{0U, 1U, 2U}, std::array{0U, 2U, 1U}}) {
                const Triangle flat{(first + turn[0]) % 3, (first + turn[1]) % 3, (first + turn[2]) % 3};
                const Mesh mesh({{0, 0, 0}, {x, 0, 0}, {2, 0, 0}, {5, 5, 5}, {6, 5, 5}, {5, 6, 5}}, {flat, {3, 4, 5}},
                                "flat");
                const Grid grid = grid_at({x, 0, 0}, 0.25, 1);
                for (const KernelBody body : both_bodies) {
                    const DistanceTransform transform(test_device(), mesh, {.sign = SignRule::none, .body = body});
                    const Field field = transform.compute(grid, Band::full(), Output::site | Output::closest);
                    for (std::size_t at = 0; at < field.site().size(); ++at) {
                        const bool is_vertex = std::abs(field.closest()[3 * at] - x) < 1e-12 ||
                                               std::abs(field.closest()[3 * at]) < 1e-12 ||
                                               std::abs(field.closest()[3 * at] - 2) < 1e-12;
                        if (is_vertex) BOOST_TEST(field.site()[at] < 3);
                    }
                    const std::vector<Vec3> points{{x, 0, 0}, {0, 0, 0}, {2, 0, 0}, {-1, 0.3, 0}, {2.5, 0, 0.2}};
                    const Field at_points = query(transform, points);
                    for (const std::uint8_t site : at_points.site()) BOOST_TEST(site < 3);
                }
            }
}

BOOST_AUTO_TEST_CASE(at_a_vertex_of_a_sliver_the_site_is_the_vertex) {
    const std::vector<Vec3> vertices{{0, 0, 0}, {1, 1e-9, 0}, {2, 0, 0}, {5, 5, 5}, {6, 5, 5}, {5, 6, 5}};
    const Mesh mesh(vertices, {{0, 1, 2}, {3, 4, 5}}, "sliver");
    for (const KernelBody body : both_bodies) {
        const DistanceTransform transform(test_device(), mesh, {.sign = SignRule::none, .body = body});
        const Field field = query(transform, vertices);
        for (std::size_t n = 0; n < vertices.size(); ++n) BOOST_TEST(field.site()[n] == n % 3);
    }
}

// The walls of a thin plate are slivers whose apex lies over an end of the base.
BOOST_AUTO_TEST_CASE(on_a_short_edge_of_a_sliver_the_site_is_the_edge) {
    for (const double height : {4e-8, 1.6e-8, 1e-8, 1e-9, 1e-10, 1e-11}) {
        BOOST_TEST_CONTEXT("a plate of 2 x 2 x " << 2 * height) {
            std::vector<Vec3> vertices;
            for (std::size_t n = 0; n < 8; ++n)
                vertices.push_back({n & 1 ? 1.0 : -1.0, n & 2 ? 1.0 : -1.0, n & 4 ? height : -height});
            const std::vector<Triangle> faces{{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                              {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
            // Of the corner with the number n: the lowest face with the edge from vertex n to vertex n + 4.
            const std::array<std::uint32_t, 4> lowest{5, 4, 6, 7};
            const Mesh mesh(vertices, faces, "plate");
            std::vector<Vec3> points;
            for (int k = 40; k <= 360; ++k)
                for (std::size_t n = 0; n < 4; ++n)
                    points.push_back({vertices[n][0], vertices[n][1], height * (k / 200.0 - 1)});
            const auto is_named = [&](const Field& field, std::size_t at, std::size_t corner) {
                return field.triangle()[at] == lowest[corner] && field.site()[at] >= 3 && field.site()[at] <= 5;
            };
            const auto is_right = [&](const Field& field, std::size_t at, std::size_t corner) {
                if (field.distance()[at] != 0 || !is_named(field, at, corner)) return false;
                for (std::size_t axis = 0; axis < 2; ++axis)
                    if (std::abs(static_cast<double>(field.gradient()[3 * at + axis]) -
                                 vertices[corner][axis] * std::sqrt(0.5)) > 1e-6)
                        return false;
                return true;
            };
            for (const KernelBody body : both_bodies) {
                const DistanceTransform transform(test_device(), mesh, {.body = body});
                for (const std::size_t count : {std::size_t{40}, points.size()}) {
                    const Field found = query(transform, std::span(points).first(count));
                    std::size_t wrong = 0;
                    for (std::size_t i = 0; i < count; ++i) wrong += is_right(found, i, i % 4) ? 0U : 1U;
                    BOOST_TEST(wrong == 0U, wrong << " of " << count << " points");
                }
                if (height < 1e-9) continue;
                for (std::size_t n = 0; n < 4; ++n) {
                    const double step = height / 10;
                    const Grid grid{vertices[n], {step, step, step}, {1, 1, 21}, {}};
                    const Field field = transform.compute(grid, Band::full(), all_outputs());
                    std::size_t wrong = 0;
                    for (std::size_t at = 1; at < 20; ++at) {
                        const bool is_near = std::abs(static_cast<double>(field.distance()[at])) <= 1e-5 * step;
                        wrong += is_near && is_named(field, at, n) ? 0U : 1U;
                    }
                    BOOST_TEST(wrong == 0U, wrong << " samples of corner " << n);
                }
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(an_output_is_the_same_whatever_else_is_asked_for) {
    const Mesh mesh = tilted(make_shape("noisy"));
    const Grid grid = grid_around(mesh, 40, 4);
    const Band band = Band::symmetric(3 * grid.voxel());
    for (const KernelBody body : both_bodies) {
        DistanceTransform transform(test_device(), mesh, {.body = body});
        const Field all = transform.compute(grid, band, all_outputs());
        BOOST_TEST((bits_of(transform.compute(grid, band).distance()) == bits_of(all.distance())));
        for (const OutputInfo& info : output_table()) {
            Field expected = all;
            for (const OutputInfo& other : output_table())
                if (other.output != info.output && other.output != Output::distance) expected.erase(other.output);
            BOOST_TEST(same_bytes(expected, transform.compute(grid, band, info.output)), info.name);
        }
    }
}

BOOST_AUTO_TEST_CASE(a_part_of_a_grid_has_the_outputs_of_the_whole) {
    const Mesh mesh = tilted(make_shape("noisy"));
    const Grid grid = grid_around(mesh, 40, 4);
    const Band band = Band::symmetric(3 * grid.voxel());
    const Index3 offset{5, 9, 13}, size{21, 17, 19};
    for (const KernelBody body : both_bodies) {
        const Field whole = compute(mesh, grid, band, body), part = compute(mesh, grid.part(offset, size), band, body);
        const Field expected = part_of(whole, part.grid);
        for (const OutputInfo& info : output_table())
            BOOST_TEST(same_bytes(expected.slab(), part.slab(), info.output), info.name);
    }
}

BOOST_AUTO_TEST_CASE(closest_points_in_floats_are_refused_and_offsets_are_named_as_the_remedy) {
    const Mesh mesh = make_shape("cube");
    const Grid grid = grid_around(mesh, 8, 1);
    std::vector<float> distance(grid.sample_count()), closest(3 * grid.sample_count());
    const DistanceTransform transform(test_device(), mesh);
    const OutputTargets targets{{Output::distance, distance}, {Output::closest, closest}};
    const std::vector<std::string> words{"closest", "float", "double", "offset"};
    check_throws(ErrorCode::unsupported, words, [&] { transform.compute(grid, Band::full(), targets); });
    const std::vector<Vec3> points(grid.sample_count());
    check_throws(ErrorCode::unsupported, words, [&] { transform.query(points, 1, targets); });
}

// 6 is a number without an output.
BOOST_AUTO_TEST_CASE(numbers_without_an_output_are_refused) {
    const DistanceTransform transform(test_device(), make_shape("cube"));
    const Grid grid{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
    for (const int number : {-1, 6, 9, 31}) {
        BOOST_TEST_CONTEXT("number " << number) {
            check_throws(ErrorCode::invalid_argument, {}, [&] { info_of(static_cast<Output>(number)); });
            if (number < 0) continue;
            check_throws(ErrorCode::invalid_argument, {},
                         [&] { transform.compute(grid, Band::full(), OutputSet::from_bits(1U << number)); });
        }
    }
    BOOST_TEST(static_cast<int>(info_of(Output::offset).output) == 7);
    BOOST_TEST(static_cast<int>(info_of(Output::body).output) == 8);
}

BOOST_AUTO_TEST_CASE(the_offset_leads_from_the_sample_to_the_closest_point) {
    const Mesh mesh = shifted(make_shape("torus"), {1e6, -1e6, 1e6});
    const Grid grid = grid_around(mesh, 20, 3);
    const Band band = Band::symmetric(3 * grid.voxel());
    const Field field = compute(mesh, grid, band);
    std::vector<float> distance(grid.sample_count()), offset(3 * grid.sample_count());
    DistanceTransform transform(test_device(), mesh);
    transform.compute(grid, band, {{Output::distance, distance}, {Output::offset, offset}});
    std::size_t in_band = 0;
    for (std::int64_t k = 0; k < grid.size[2]; ++k)
        for (std::int64_t j = 0; j < grid.size[1]; ++j)
            for (std::int64_t i = 0; i < grid.size[0]; ++i) {
                const std::size_t sample = grid.offset(i, j, k);
                if (field.triangle()[sample] == no_triangle) {
                    BOOST_REQUIRE(std::isnan(offset[3 * sample]));
                    continue;
                }
                ++in_band;
                const Vec3 position = grid.position(i, j, k);
                for (std::size_t axis = 0; axis < 3; ++axis)
                    BOOST_REQUIRE(std::abs(position[axis] + static_cast<double>(offset[3 * sample + axis]) -
                                           field.closest()[3 * sample + axis]) <= 1e-6 * grid.voxel() + 1e-9);
            }
    BOOST_TEST(in_band > 100U);
}

BOOST_AUTO_TEST_CASE(a_plan_writes_every_output_into_the_callers_buffers_from_an_offset_on) {
    const Mesh mesh = make_shape("torus");
    const Grid grid = grid_around(mesh, 20, 3);
    const Band band = Band::symmetric(3 * grid.voxel());
    const Field expected = compute(mesh, grid, band);
    const std::size_t count = grid.sample_count();
    constexpr std::size_t offset = 4096;  // bytes
    const cl::CommandQueue queue(cl::Context(test_device().context(), true), cl::Device(test_device().id(), true));
    DistanceTransform transform(test_device(), mesh);
    Plan plan = transform.plan(grid, band, Output::triangle | Output::closest | Output::gradient);
    const DeviceMemory distance(test_device().context(), count + offset / 4), triangle(test_device().context(), count),
        closest(test_device().context(), 6 * count + offset / 4), gradient(test_device().context(), 3 * count);
    OutputTargets targets{{Output::distance, distance.handle()},
                          {Output::triangle, triangle.handle()},
                          {Output::closest, closest.handle()},
                          {Output::gradient, gradient.handle()}};
    targets[Output::distance].offset = targets[Output::closest].offset = offset;
    enqueue(plan, queue(), targets).wait();
    const auto check = [&](const char* name, const DeviceMemory& memory, const auto& values, std::size_t begin) {
        const std::vector<std::uint32_t> words = memory.read(queue);
        BOOST_TEST(std::memcmp(words.data() + begin / 4, values.data(), values.size() * sizeof(values[0])) == 0, name);
        BOOST_TEST(static_cast<std::size_t>(std::count(
                       words.begin(), words.begin() + static_cast<std::ptrdiff_t>(begin / 4), untouched)) == begin / 4);
    };
    check("distance", distance, expected.distance(), offset);
    check("triangle", triangle, expected.triangle(), 0);
    check("closest", closest, expected.closest(), offset);
    check("gradient", gradient, expected.gradient(), 0);
}

BOOST_AUTO_TEST_CASE(targets_that_there_is_no_way_to_are_refused_by_name) {
    const Mesh mesh = cube(1);
    const Grid grid = grid_around(mesh, 8, 2);
    const Band band = Band::full();
    DistanceTransform transform(test_device(), mesh);
    std::vector<float> distance(grid.sample_count());
    std::vector<std::uint32_t> integers(3 * grid.sample_count());
    check_throws(ErrorCode::unsupported, {"output distance", "uint32", "float or double"},
                 [&] { transform.compute(grid, band, std::span(integers).first(grid.sample_count())); });
    check_throws(ErrorCode::unsupported, {"output gradient", "uint32", "float or double"}, [&] {
        transform.compute(grid, band, {{Output::distance, distance}, {Output::gradient, integers}});
    });
    check_throws(ErrorCode::unsupported, {"output site", "float", "uint8"}, [&] {
        transform.compute(grid, band, {{Output::distance, distance}, {Output::site, distance}});
    });
    OutputArray beyond = distance;
    beyond.strides = {8, 8, 8};
    beyond.offset = sizeof(float) * (grid.sample_count() - 1);
    check_throws(ErrorCode::invalid_argument, {"output distance", "offset and strides"},
                 [&] { transform.compute(grid, band, beyond); });
    Plan plan = transform.plan(grid, band);
    check_throws(ErrorCode::unsupported, {"output distance", "memory of the host"},
                 [&] { plan.enqueue(nullptr, distance); });
    const DeviceMemory memory(test_device().context(), grid.sample_count());
    OutputTargets mixed = distance;
    mixed[Output::triangle] = memory.handle();
    check_throws(ErrorCode::unsupported, {"host", "device"}, [&] { transform.compute(grid, band, mixed); });
    OutputArray uneven = memory.handle();
    uneven.offset = 4;
    check_throws(ErrorCode::invalid_argument, {"output distance", "from byte 4"},
                 [&] { plan.enqueue(nullptr, uneven); });
    const DistanceTransform slices = make_transform(test_device(), mesh, {.scan = Scan::slices});
    check_throws(ErrorCode::unsupported, {"slices", "site"}, [&] { slices.compute(grid, band, Output::site); });
}
