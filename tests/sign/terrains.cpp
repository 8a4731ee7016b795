// Terrains: the sign rule `below` has the sign of the mesh that close_down() makes, and the terrain's own distance
// (docs/sign.md).

#include "support/exact_field.hpp"
#include "support/open_meshes.hpp"
#include "support/throws.hpp"

#include "device/context.hpp"

#include <clsdf/tuning.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr double floor_z = -3.25;

TransformOptions by_below(double floor = floor_z, KernelBody body = {}) {
    return {.sign = SignRule::below, .body = body, .floor = floor};
}

std::vector<KernelBody> bodies() {
    if (!is_processor()) return {KernelBody::automatic};
    return {KernelBody::by_vector, KernelBody::by_group};
}

/// A graph over the cells of a lattice that `has` chooses, each of two triangles, with corners `at` of (i, j).
Mesh graph(std::uint32_t size, std::string name, const std::function<bool(std::uint32_t, std::uint32_t)>& has,
           const std::function<Vec3(std::uint32_t, std::uint32_t)>& at) {
    std::vector<Vec3> vertices;
    for (std::uint32_t j = 0; j <= size; ++j)
        for (std::uint32_t i = 0; i <= size; ++i) vertices.push_back(at(i, j));
    std::vector<Triangle> triangles;
    for (std::uint32_t j = 0; j < size; ++j)
        for (std::uint32_t i = 0; i < size; ++i) {
            if (!has(i, j)) continue;
            const std::uint32_t a = j * (size + 1) + i, b = a + 1, c = a + size + 1, d = c + 1;
            triangles.push_back({a, b, d});
            triangles.push_back({a, d, c});
        }
    return {std::move(vertices), std::move(triangles), std::move(name)};
}

/// Rough terrains: whole, with a bay, a hole and an island, on lattice positions and shaken ones, and one with cliffs.
std::vector<Mesh> terrains(std::uint64_t seed) {
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    constexpr std::uint32_t size = 8;
    const auto shaken = [&](std::uint32_t i, std::uint32_t j) {
        return Vec3{i + random.uniform(-0.2, 0.2), j + random.uniform(-0.2, 0.2), random.uniform(-1.5, 1.5)};
    };
    const auto everywhere = [](std::uint32_t, std::uint32_t) { return true; };
    const auto with_gaps = [](std::uint32_t i, std::uint32_t j) {
        const bool is_bay = i >= 3 && i <= 4 && j <= 2, is_moat = i >= 2 && i <= 6 && j >= 4 && j <= 6,
                   is_island = i >= 3 && i <= 5 && j == 5, is_corner = i == j && i == 7;
        return !is_bay && (!is_moat || is_island) && !is_corner;
    };
    std::vector<Mesh> meshes;
    meshes.push_back(graph(size, "whole terrain", everywhere, shaken));
    meshes.push_back(graph(size, "terrain with a bay, a moat and an island", with_gaps, shaken));
    meshes.push_back(graph(size, "terrain at samples", with_gaps, [&](std::uint32_t i, std::uint32_t j) {
        return Vec3{static_cast<double>(i), static_cast<double>(j), std::floor(random.uniform(-2, 3))};
    }));
    meshes.push_back(graph(2, "two triangles a side", everywhere, [](std::uint32_t i, std::uint32_t j) {
        return Vec3{4.0 * i - 0.5 * j, 3.5 * j + 0.25 * i, 0.5 * i - 0.25 * j};
    }));
    // Upright faces: columns 2k and 2k + 1 of vertices lie above each other.
    meshes.push_back(graph(size, "cliffs", everywhere, [&](std::uint32_t i, std::uint32_t j) {
        return Vec3{static_cast<double>((i + 1) / 2), static_cast<double>(j), (i + 1) / 2 % 2 + 0.5 * (i % 2)};
    }));
    return meshes;
}

Grid lattice_around(const Vec3& origin, const Vec3& spacing, const Index3& size) {
    Grid grid;
    grid.origin = origin;
    grid.spacing = spacing;
    grid.size = size;
    return grid;
}

std::vector<Vec3> points_around(const Mesh& mesh, Random& random) {
    std::vector<Vec3> points;
    for (int i = 0; i < 400; ++i) points.push_back(random.point(-2, 10));
    for (Vec3& point : points) point[2] = random.uniform(-5, 3);
    for (int i = 0; i < 200; ++i) {  // below and above edges, on walls, beside them, and at the floor
        const Triangle& triangle = mesh.triangles()[random.index(mesh.triangles().size())];
        const Vec3 &a = mesh.vertices()[triangle[0]], &b = mesh.vertices()[triangle[1]];
        const double share = std::round(8 * random.uniform(0, 1)) / 8;
        Vec3 point{};
        for (std::size_t axis = 0; axis < 3; ++axis) point[axis] = a[axis] + share * (b[axis] - a[axis]);
        if (i % 3 == 0) point[2] -= std::pow(10, random.uniform(-9, 0.5));
        if (i % 3 == 1) point[2] = random.uniform(-4, 2);
        if (i % 5 == 0) point[0] += std::pow(10, random.uniform(-9, 0));
        if (i % 7 == 0) point[2] = floor_z + (i % 2 == 0 ? 0 : random.uniform(-1e-9, 1e-9));
        points.push_back(point);
    }
    return points;
}

/// Counts points at which the signs differ; nearer to the closed surface than `least` they may.
std::size_t different_signs(std::span<const float> found, std::span<const float> closed, double least) {
    std::size_t different = 0, inside = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (std::abs(static_cast<double>(closed[i])) <= least) continue;
        if (std::signbit(found[i]) != std::signbit(closed[i]) && different++ < 4)
            BOOST_TEST_MESSAGE("  number " << i << ": " << found[i] << " in place of " << closed[i]);
        inside += std::signbit(found[i]) ? 1U : 0U;
    }
    BOOST_TEST(inside > 0U);
    return different;
}

std::size_t different_magnitudes(std::span<const float> found, std::span<const float> unsigned_ones) {
    std::size_t different = 0;
    for (std::size_t i = 0; i < found.size(); ++i)
        different += std::bit_cast<std::uint32_t>(std::abs(found[i])) != std::bit_cast<std::uint32_t>(unsigned_ones[i])
                         ? 1U
                         : 0U;
    return different;
}

std::string message_of(const Mesh& mesh, const TransformOptions& options) {
    try {
        DistanceTransform(test_device(), mesh, options);
    } catch (const Error& error) {
        return error.what();
    }
    return "nothing was thrown";
}

void check_refused(const Mesh& mesh, const std::string& fragment, ErrorCode code = ErrorCode::invalid_mesh,
                   double floor = floor_z) {
    BOOST_TEST_CONTEXT(mesh.name()) {
        check_throws(code, {fragment}, [&] { DistanceTransform(test_device(), mesh, by_below(floor)); });
        check_throws(code, {fragment}, [&] { close_down(mesh, floor); });
    }
}

Mesh together(const Mesh& a, const Mesh& b, std::string name) {
    std::vector<Vec3> vertices = a.vertices();
    std::vector<Triangle> triangles = a.triangles();
    const auto first = static_cast<std::uint32_t>(vertices.size());
    vertices.insert(vertices.end(), b.vertices().begin(), b.vertices().end());
    for (const auto& [x, y, z] : b.triangles()) triangles.push_back({x + first, y + first, z + first});
    return {std::move(vertices), std::move(triangles), std::move(name)};
}

}  // namespace

BOOST_AUTO_TEST_CASE(samples_have_the_sign_of_the_closed_mesh_and_the_distance_of_the_terrain) {
    for (const KernelBody body : bodies())
        for (const Mesh& mesh : terrains(1)) BOOST_TEST_CONTEXT(mesh.name()) {
                const Mesh closed = close_down(mesh, floor_z);
                const DistanceTransform below(test_device(), mesh, by_below(floor_z, body)),
                    of_closed(test_device(), closed, {.body = body}),
                    of_none(test_device(), mesh, {.sign = SignRule::none, .body = body});
                BOOST_TEST(name_of(of_closed.sign()) == "nonzero");
                BOOST_TEST(name_of(below.sign()) == "below");
                for (const Grid& grid : {lattice_around({-2, -2, -5}, {1, 1, 1}, {12, 12, 9}),
                                         lattice_around({-1.3, -0.7, -4.1}, {0.5, 0.75, 0.25}, {20, 14, 30}),
                                         lattice_around({3, 3, -5.5}, {0.25, 0.25, 0.25}, {9, 10, 40})})
                    for (const Band& band : {Band::full(), Band::symmetric(0.6)}) {
                        const Field found = below.compute(grid, band, all_outputs());
                        const Field expected = of_closed.compute(grid, Band::full());
                        BOOST_TEST(different_signs(found.distance(), expected.distance(), 1e-6 * grid.voxel()) == 0U);
                        const Field plain = of_none.compute(grid, band, all_outputs());
                        BOOST_TEST(different_magnitudes(found.distance(), plain.distance()) == 0U);
                        BOOST_TEST(std::ranges::equal(found.triangle(), plain.triangle()));
                        BOOST_TEST(std::ranges::equal(found.site(), plain.site()));
                    }
            }
}

BOOST_AUTO_TEST_CASE(the_reference_finds_nothing_wrong_with_terrains) {
    for (const Mesh& mesh : terrains(2)) {
        const Grid grid = lattice_around({-1.1, -1.25, -4.3}, {0.8, 0.8, 0.8}, {14, 14, 10});
        check_exact(mesh, compute(mesh, grid, Band::symmetric(1.5), by_below()), guaranteed);
        const Field expected = reference::reference_field(mesh, grid, Band::full(), SignRule::below, floor_z);
        const Field found = compute(mesh, grid, Band::full(), by_below());
        BOOST_TEST(different_signs(found.distance(), expected.distance(), 1e-6 * grid.voxel()) == 0U);
    }
}

BOOST_AUTO_TEST_CASE(points_have_the_sign_of_the_closed_mesh_and_few_the_bytes_of_many) {
    constexpr std::uint64_t seed = 3;
    Random random(seed);
    for (const KernelBody body : bodies())
        for (const Mesh& mesh : terrains(seed)) BOOST_TEST_CONTEXT(mesh.name()) {
                const DistanceTransform below(test_device(), mesh, by_below(floor_z, body)),
                    closed(test_device(), close_down(mesh, floor_z), {.body = body}),
                    of_none(test_device(), mesh, {.sign = SignRule::none, .body = body});
                const std::vector<Vec3> points = points_around(mesh, random);
                const Field many = query(below, points), expected = query(closed, points),
                            plain = query(of_none, points);
                BOOST_TEST(different_signs(many.distance(), expected.distance(), 0) == 0U);
                BOOST_TEST(different_magnitudes(many.distance(), plain.distance()) == 0U);
                std::size_t different = 0;
                for (std::size_t begin = 0; begin < points.size(); begin += 50) {
                    const auto some =
                        std::span(points).subspan(begin, std::min<std::size_t>(50, points.size() - begin));
                    const Field few = query(below, some);
                    for (std::size_t i = 0; i < some.size(); ++i)
                        different += std::bit_cast<std::uint32_t>(few.distance()[i]) !=
                                             std::bit_cast<std::uint32_t>(many.distance()[begin + i])
                                         ? 1U
                                         : 0U;
                }
                BOOST_TEST(different == 0U);
                std::vector<float> winding(points.size()), of_closed(points.size());
                below.winding(points, winding);
                closed.winding(points, of_closed);
                for (std::size_t i = 0; i < points.size(); ++i)
                    if (expected.distance()[i] != 0) different += winding[i] != of_closed[i] ? 1U : 0U;
                BOOST_TEST(different == 0U);
            }
}

BOOST_AUTO_TEST_CASE(samples_and_points_on_walls_and_on_the_floor_have_one_sign) {
    const Mesh mesh = graph(
        4, "terrain", [](std::uint32_t, std::uint32_t) { return true; },
        [](std::uint32_t i, std::uint32_t j) {
            return Vec3{1.0 * i, 1.0 * j, 3.5};
        });
    const DistanceTransform transform(test_device(), mesh, by_below(1));
    const Grid grid = lattice_around({-1, -1, 0}, {1, 1, 1}, {7, 7, 4});
    const Field field = transform.compute(grid, Band::full());
    const std::vector<Vec3> points = samples_of(grid);
    const Field found = query(transform, points);
    // Walls and the floor belong to what lies beyond them on the axes.
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto& [x, y, z] = points[i];
        const bool is_inside = x >= 0 && x < 4 && y >= 0 && y < 4 && z >= 1;
        BOOST_TEST(std::signbit(field.distance()[i]) == is_inside);
        BOOST_TEST(std::signbit(found.distance()[i]) == is_inside);
    }
}

BOOST_AUTO_TEST_CASE(a_terrain_that_moves_has_the_sign_of_its_new_positions_and_stays_above_its_floor) {
    for (const Mesh& mesh : terrains(4)) BOOST_TEST_CONTEXT(mesh.name()) {
            const Mesh moved = test::moved(mesh, [](const Vec3& p) {
                return Vec3{p[0] + 0.3 * p[1] + 0.25, p[1] - 0.5, 0.8 * p[2] + 0.1 * p[0]};
            });
            const Grid grid = lattice_around({-2, -2, -5}, {0.75, 0.75, 0.75}, {18, 16, 12});
            DistanceTransform transform(test_device(), mesh, by_below());
            transform.compute(grid, Band::full());
            query(transform, samples_of(grid));
            transform.set_positions(moved.vertices());
            const DistanceTransform fresh(test_device(), moved, by_below()),
                closed(test_device(), close_down(moved, floor_z));
            const Field field = transform.compute(grid, Band::symmetric(2));
            BOOST_TEST(same_bytes(field, fresh.compute(grid, Band::symmetric(2))));
            BOOST_TEST(different_signs(field.distance(), closed.compute(grid, Band::full()).distance(),
                                       1e-6 * grid.voxel()) == 0U);
            BOOST_TEST(same_bytes(query(transform, samples_of(grid)), query(fresh, samples_of(grid))));
            const Mesh lowered = test::moved(mesh, [](const Vec3& p) { return Vec3{p[0], p[1], p[2] - 4}; });
            check_throws(ErrorCode::invalid_argument, {"the floor is at z = -3.25", "lowest vertex"},
                         [&] { transform.set_positions(lowered.vertices()); });
            check_throws(ErrorCode::invalid_argument, {"the floor is at z = -3.25"}, [&] {
                transform.set_motion({Vec3{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, -10});
            });
            BOOST_TEST(same_bytes(field, transform.compute(grid, Band::symmetric(2))));
        }
}

BOOST_AUTO_TEST_CASE(a_terrain_in_memory_of_the_device_has_the_same_sign_and_stays_above_its_floor) {
    constexpr std::uint64_t seed = 8;
    BOOST_TEST_MESSAGE("seed " << seed);
    Random random(seed);
    const Mesh mesh = graph(  // as many triangles as kernels make the topology of
        24, "terrain", [](std::uint32_t i, std::uint32_t j) { return i != 7 || j < 3; },
        [&](std::uint32_t i, std::uint32_t j) {
            return Vec3{0.5 * i, 0.5 * j, random.uniform(-1, 1)};
        });
    const auto lowered = [&](double by) {
        return test::moved(mesh, [&](const Vec3& p) { return Vec3{p[0], p[1], p[2] - by}; });
    };
    const device::Context& context = device::context_of(test_device());
    const auto in_memory = [&](const auto& values) {
        std::vector<std::byte> bytes(values.size() * sizeof(values[0]));
        std::memcpy(bytes.data(), values.data(), bytes.size());
        return cl::Buffer(context.context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, bytes.size(), bytes.data());
    };
    const cl::Buffer vertices = in_memory(mesh.vertices()), triangles = in_memory(mesh.triangles()),
                     lower = in_memory(lowered(1).vertices()), too_low = in_memory(lowered(9).vertices());
    const auto positions = [&](const cl::Buffer& buffer) {
        return InputArray(buffer(), ElementType::float64, mesh.vertices().size());
    };
    DistanceTransform transform(
        test_device(),
        MeshView(positions(vertices), InputArray(triangles(), ElementType::uint32, mesh.triangles().size())),
        by_below());
    const Grid grid = lattice_around({-1, -1, -4}, {0.5, 0.5, 0.5}, {28, 28, 14});
    const auto check_same_as = [&](const Mesh& expected) {
        const DistanceTransform fresh(test_device(), expected, by_below());
        BOOST_TEST(same_bytes(transform.compute(grid, Band::full()), fresh.compute(grid, Band::full())));
        BOOST_TEST(same_bytes(query(transform, samples_of(grid)), query(fresh, samples_of(grid))));
    };
    check_same_as(mesh);
    transform.set_positions(positions(lower));
    check_same_as(lowered(1));
    check_throws(ErrorCode::invalid_argument, {"the floor is at z = -3.25"},
                 [&] { transform.set_positions(positions(too_low)); });
    check_same_as(lowered(1));
}

BOOST_AUTO_TEST_CASE(a_terrain_of_loose_triangles_with_noise_has_the_sign_of_the_clean_one) {
    constexpr std::uint64_t seed = 9;
    Random random(seed);
    for (const Mesh& mesh : terrains(seed)) BOOST_TEST_CONTEXT(mesh.name()) {
            std::vector<Vec3> vertices;
            std::vector<Triangle> triangles;
            for (const Triangle& triangle : mesh.triangles()) {
                const auto first = static_cast<std::uint32_t>(vertices.size());
                for (const std::uint32_t index : triangle) {
                    vertices.push_back(mesh.vertices()[index]);
                    // Along z: upright faces stay upright.
                    if (random.index(3) == 0) vertices.back()[2] *= 1 + std::numeric_limits<double>::epsilon();
                }
                triangles.push_back({first, first + 1, first + 2});
            }
            triangles.push_back(triangles[3]);  // is there twice
            const Mesh noisy(std::move(vertices), std::move(triangles), "noisy");
            const DistanceTransform below(test_device(), noisy, by_below()),
                closed(test_device(), close_down(mesh, floor_z)), of_noisy(test_device(), close_down(noisy, floor_z));
            const std::vector<Vec3> points = points_around(mesh, random);
            const Field expected = query(closed, points);
            for (const DistanceTransform* one : {&below, &of_noisy}) {
                const Field found = query(*one, points);
                BOOST_TEST(different_signs(found.distance(), expected.distance(), 1e-10) == 0U);
            }
        }
}

BOOST_AUTO_TEST_CASE(parts_sparse_fields_and_boxes_agree_with_the_whole_terrain) {
    constexpr std::uint64_t seed = 5;
    Random random(seed);
    for (const Mesh& mesh : terrains(seed)) BOOST_TEST_CONTEXT(mesh.name()) {
            const DistanceTransform transform(test_device(), mesh, by_below());
            const Grid grid = lattice_around({-2, -2, -5}, {0.5, 0.5, 0.5}, {24, 24, 16});
            const Band band = Band::symmetric(0.75);
            const Field whole = transform.compute(grid, band);
            const Box box{{2, 1, -4}, {5, 6, 0}};
            const DistanceTransform part = transform.restrict_to(Region{box, 0.75, 0.5});
            const Grid small = lattice_around({2, 1, -4}, {0.5, 0.5, 0.5}, {7, 11, 9});
            BOOST_TEST(same_bytes(part.compute(small, band), transform.compute(small, band)));
            std::vector<Vec3> points;
            for (int i = 0; i < 300; ++i)
                points.push_back({random.uniform(2, 5), random.uniform(1, 6), random.uniform(-4, 0)});
            BOOST_TEST(same_bytes(query(part, points, 0.75), query(transform, points, 0.75)));
            std::vector<float> of_part(points.size()), of_whole(points.size());
            part.winding(points, of_part);
            transform.winding(points, of_whole);
            BOOST_TEST(of_part == of_whole, boost::test_tools::per_element());

            const SparseField sparse = transform.compute_sparse(grid, band);
            std::size_t different = 0, n = 0;
            for (std::int64_t k = 0; k < grid.size[2]; ++k)
                for (std::int64_t j = 0; j < grid.size[1]; ++j)
                    for (std::int64_t i = 0; i < grid.size[0]; ++i, ++n)
                        different += std::bit_cast<std::uint32_t>(sparse.distance_at({i, j, k})) !=
                                             std::bit_cast<std::uint32_t>(whole.distance()[n])
                                         ? 1U
                                         : 0U;
            BOOST_TEST(different == 0U);

            std::vector<Box> boxes;
            for (int i = 0; i < 300; ++i) {
                const Vec3 lower{random.uniform(-2, 9), random.uniform(-2, 9), random.uniform(-5, 3)};
                const double side = std::pow(10, random.uniform(-2, 0.3));
                boxes.push_back({lower, {lower[0] + side, lower[1] + side, lower[2] + side}});
            }
            std::vector<BoxPlace> places(boxes.size());
            transform.classify(boxes, 0.1, places);
            std::size_t inside = 0, wrong = 0;
            for (std::size_t i = 0; i < boxes.size(); ++i) {
                inside += places[i] == BoxPlace::inside ? 1U : 0U;
                if (places[i] == BoxPlace::within) continue;
                std::vector<Vec3> in_box;
                for (int k = 0; k < 20; ++k) {
                    Vec3 point{};
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        point[axis] = random.uniform(boxes[i].lower[axis], boxes[i].upper[axis]);
                    in_box.push_back(point);
                }
                const Field found = query(transform, in_box);
                for (const float distance : found.distance())
                    wrong += std::signbit(distance) != (places[i] == BoxPlace::inside) ? 1U : 0U;
            }
            BOOST_TEST(wrong == 0U);
            BOOST_TEST(inside > 0U);
        }
}

BOOST_AUTO_TEST_CASE(close_down_makes_a_closed_mesh_that_begins_with_the_terrain) {
    for (const Mesh& mesh : terrains(6)) BOOST_TEST_CONTEXT(mesh.name()) {
            const Mesh closed = close_down(mesh, floor_z);
            const Topology topology = describe_topology(closed);
            BOOST_TEST(topology.balanced);
            BOOST_TEST(!topology.inside_out);
            BOOST_TEST(topology.repeated_vertex_faces == 0U);
            BOOST_TEST(closed.box().lower[2] == floor_z);
            BOOST_TEST(std::equal(mesh.triangles().begin(), mesh.triangles().end(), closed.triangles().begin()));
            BOOST_TEST(std::equal(mesh.vertices().begin(), mesh.vertices().end(), closed.vertices().begin()));
        }
}

BOOST_AUTO_TEST_CASE(what_is_no_terrain_is_refused_with_a_remedy) {
    const auto everywhere = [](std::uint32_t, std::uint32_t) { return true; };
    const auto flat = [](std::uint32_t i, std::uint32_t j) { return Vec3{1.0 * i, 1.0 * j, 0.125 * i}; };
    const Mesh mesh = graph(4, "plane", everywhere, flat);
    check_refused(mesh, "the floor is at z = 0, and the lowest vertex of plane at z = 0", ErrorCode::invalid_argument,
                  0);
    check_refused(mesh, "needs a finite floor", ErrorCode::invalid_argument, -std::numeric_limits<double>::infinity());
    check_refused(make_shape("sphere2"), "this mesh is closed");
    check_refused(without_triangle(make_shape("sphere2"), 3), "look down (the first is triangle");
    std::vector<Triangle> turned = mesh.triangles();
    std::swap(turned[5][0], turned[5][1]);
    check_refused({mesh.vertices(), turned, "one turned"}, "1 face of this mesh looks down (the first is triangle 5)");
    check_refused(graph(3, "upright", everywhere,
                        [](std::uint32_t i, std::uint32_t j) {
                            return Vec3{1.0 * i, 0, 1.0 * j};
                        }),
                  "no face of this mesh looks up");
    const auto at = [&](double x, double y, double z) {
        return test::moved(mesh, [&](const Vec3& p) { return Vec3{p[0] + x, p[1] + y, p[2] + z}; });
    };
    const char* const overlap = "rim does not overlap itself, seen from above";
    check_refused(together(mesh, at(2.5, 1.5, 1), "crossing layers"), overlap);
    check_refused(together(mesh, at(2, 1, 1), "layers that cross at vertices"), overlap);
    check_refused(together(mesh, at(0, 0, 1), "layers above each other"), overlap);
    check_refused(together(mesh, at(0, 2, 1), "layers with common lines"), overlap);
    check_refused(together(mesh,
                           test::moved(mesh,
                                       [](const Vec3& p) {
                                           return Vec3{0.25 * p[0] + 1.3, 0.25 * p[1] + 1.4, p[2] + 1};
                                       }),
                           "a layer above"),
                  overlap);
    // A ramp that goes around one and a half times.
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i <= 18; ++i)
        for (const double radius : {1.0, 2.0})
            vertices.push_back({radius * std::cos(i * 0.5236), radius * std::sin(i * 0.5236), 0.2 * i});
    for (std::uint32_t i = 0; i < 18; ++i) {
        triangles.push_back({2 * i, 2 * i + 1, 2 * i + 3});
        triangles.push_back({2 * i, 2 * i + 3, 2 * i + 2});
    }
    check_refused({vertices, triangles, "ramp"}, overlap);
    // Beside each other, at a common line, corner or in a hole, terrains are taken.
    BOOST_TEST(message_of(together(mesh, at(4, 0.5, 1), "beside"), by_below()) == "nothing was thrown");
    BOOST_TEST(message_of(together(mesh, at(4, 4, 0), "at a corner"), by_below()) == "nothing was thrown");

    BOOST_TEST(message_of(mesh, {.sign = SignRule::below}).find("needs a floor") != std::string::npos);
    BOOST_TEST(message_of(mesh, {.floor = -1}).find("is for the sign rule below") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(the_rule_auto_names_the_rule_below_for_terrains_alone) {
    const auto warning_of = [](const Mesh& mesh) {
        return resolve_sign_rule(SignRule::automatic, describe_topology(mesh)).warning;
    };
    for (const Mesh& mesh : terrains(7)) BOOST_TEST_CONTEXT(mesh.name() << ": " << warning_of(mesh))
    BOOST_TEST(warning_of(mesh).find("the sign rule below with a floor Z") != std::string::npos);
    const Mesh bowl = open_box({0, 0, 0}, {1, 1, 1}, 5);
    BOOST_TEST(warning_of(bowl).find("sign rule below") == std::string::npos, warning_of(bowl));
}
