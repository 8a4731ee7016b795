// Fields and points of meshes that are not balanced, and whose sign another surface decides (docs/sign.md).

#include "support/doubtful_meshes.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/throws.hpp"

#include <clsdf/tuning.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

std::vector<KernelBody> bodies() {
    if (!is_processor()) return {KernelBody::automatic};
    return {KernelBody::by_vector, KernelBody::by_group};
}

/// The winding number by solid angles, in double: far from the surface a whole number.
double solid_angles(const Mesh& mesh, const Vec3& p) {
    double sum = 0;
    for (const Triangle& triangle : mesh.triangles()) {
        std::array<Vec3, 3> at{};
        std::array<double, 3> length{};
        for (std::size_t k = 0; k < 3; ++k) {
            for (std::size_t axis = 0; axis < 3; ++axis) at[k][axis] = mesh.vertices()[triangle[k]][axis] - p[axis];
            length[k] = std::hypot(at[k][0], at[k][1], at[k][2]);
        }
        const auto dot = [&](std::size_t a, std::size_t b) {
            return at[a][0] * at[b][0] + at[a][1] * at[b][1] + at[a][2] * at[b][2];
        };
        const double volume = at[0][0] * (at[1][1] * at[2][2] - at[1][2] * at[2][1]) +
                              at[0][1] * (at[1][2] * at[2][0] - at[1][0] * at[2][2]) +
                              at[0][2] * (at[1][0] * at[2][1] - at[1][1] * at[2][0]);
        sum += 2 * std::atan2(volume, length[0] * length[1] * length[2] + dot(0, 1) * length[2] +
                                          dot(1, 2) * length[0] + dot(2, 0) * length[1]);
    }
    return sum / (4 * std::numbers::pi);
}

std::vector<Vec3> points_about(const Mesh& mesh, std::size_t count, std::uint64_t seed) {
    Random random(seed);
    std::vector<Vec3> points(count);
    for (Vec3& point : points)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double side = mesh.box().upper[axis] - mesh.box().lower[axis];
            point[axis] = random.uniform(mesh.box().lower[axis] - 0.1 * side, mesh.box().upper[axis] + 0.1 * side);
        }
    return points;
}

void check_same(const Field& one, const Field& other) {
    for (const OutputInfo& info : output_table())
        BOOST_TEST(same_bytes(one.slab(), other.slab(), info.output), info.name << " differs");
}

}  // namespace

BOOST_AUTO_TEST_CASE(fields_are_exact_and_have_the_sign_that_is_meant) {
    for (const KernelBody body : bodies())
        for (const auto& [mesh, meant] : doubtful_meshes()) {
            BOOST_TEST_CONTEXT(mesh.name()) {
                const Grid grid = grid_around(mesh, 30, 4);
                const Band band = Band::symmetric(3 * grid.voxel());
                const Field field = compute(mesh, grid, band, body);
                check_exact(mesh, field, guaranteed);
                BOOST_TEST(name_of(field.sign) == "nonzero");
                const Field right = compute(meant, grid, band, body);
                std::size_t different = 0;
                for (std::size_t i = 0; i < field.distance().size(); ++i)
                    different += std::signbit(field.distance()[i]) != std::signbit(right.distance()[i]) &&
                                         std::abs(right.distance()[i]) > 1e-6F && std::abs(field.distance()[i]) > 1e-6F
                                     ? 1U
                                     : 0U;
                BOOST_TEST(different == 0U);
            }
        }
}

BOOST_AUTO_TEST_CASE(few_and_many_points_have_the_sign_of_the_solid_angle_with_the_same_bytes) {
    for (const KernelBody body : bodies())
        for (const auto& [mesh, meant] : doubtful_meshes()) {
            BOOST_TEST_CONTEXT(mesh.name()) {
                const DistanceTransform transform(test_device(), mesh, {.body = body});
                // Enough that crossings decide the sides of faces, and the points are scanned.
                const std::vector<Vec3> points = points_about(mesh, 20000, 7);
                const Field first = query(transform, points), many = query(transform, points);
                BOOST_TEST(same_bytes(first, many));
                std::size_t wrong = 0, inside = 0;
                for (std::size_t i = 0; i < points.size(); i += 7) {
                    const bool is_inside = std::round(solid_angles(meant, points[i])) != 0;
                    inside += is_inside ? 1U : 0U;
                    wrong += is_inside != std::signbit(many.distance()[i]) ? 1U : 0U;
                }
                BOOST_TEST(wrong == 0U);
                BOOST_TEST(inside > 100U);
                for (std::size_t begin = 0; begin < 960; begin += 96) {
                    const Field few = query(transform, std::span(points).subspan(begin, 96));
                    for (const OutputInfo& info : output_table())
                        BOOST_TEST(
                            std::ranges::equal(
                                few.bytes(info.output),
                                many.bytes(info.output).subspan(begin * info.sample_bytes(), 96 * info.sample_bytes())),
                            info.name << " differs from point " << begin << " on");
                }
            }
        }
}

// Beside the joined vertices, too: farther than 1e-12 of the side the sign is right.
BOOST_AUTO_TEST_CASE(points_beside_a_seam_have_the_right_sign) {
    const Mesh mesh = seamed_torus(), meant = weld(mesh, 1e-9);
    const DistanceTransform transform(test_device(), mesh), right(test_device(), meant);
    std::vector<Vec3> points;
    Random random(11);
    for (const double distance : {3e-12, 1e-10, 1e-8, 1e-4})
        for (int i = 0; i < 400; ++i) {
            const Vec3& corner = mesh.vertices()[random.index(4 * 12)];  // of the seam
            points.push_back(along(corner, distance * mesh.box().longest_side(), random.direction()));
        }
    for (std::size_t size : {std::size_t{80}, points.size()})
        for (std::size_t begin = 0; begin < points.size(); begin += size) {
            const auto part = std::span(points).subspan(begin, size);
            const Field found = query(transform, part), expected = query(right, part);
            for (std::size_t i = 0; i < part.size(); ++i) {
                // Faces that meet flatly may lie nearer than the vertex.
                if (std::abs(static_cast<double>(expected.distance()[i])) < 1e-12 * mesh.box().longest_side()) continue;
                BOOST_TEST(std::signbit(found.distance()[i]) == std::signbit(expected.distance()[i]),
                           "point " << begin + i << " at " << expected.distance()[i]);
            }
        }
}

BOOST_AUTO_TEST_CASE(parts_slabs_and_plans_have_the_bytes_of_the_whole) {
    for (const KernelBody body : bodies())
        for (const auto& [mesh, meant] : doubtful_meshes()) {
            BOOST_TEST_CONTEXT(mesh.name()) {
                const DistanceTransform whole(test_device(), mesh, {.body = body});
                const double side = mesh.box().longest_side(), h = side / 40;
                for (const Vec3& at : {Vec3{0.9, 0.45, 0.4}, Vec3{0.3, 0.3, 0.3}, Vec3{0.95, 0.48, 0.45}}) {
                    Grid grid = grid_around(mesh, 44, 2);
                    Grid part = grid;
                    for (std::size_t axis = 0; axis < 3; ++axis) {
                        const auto middle = static_cast<std::int64_t>(at[axis] * static_cast<double>(grid.size[axis]));
                        part.first[axis] = std::clamp<std::int64_t>(middle - 3, 0, grid.size[axis] - 6);
                        part.size[axis] = 6;
                    }
                    Box box{part.position(0, 0, 0), part.position(5, 5, 5)};
                    const Band band = Band::symmetric(3 * grid.voxel());
                    const Field all = whole.compute(grid, band, all_outputs());
                    const Field expected = part_of(all, part);
                    check_same(whole.compute(part, band, all_outputs()), expected);
                    const DistanceTransform restricted =
                        whole.restrict_to({box, 4 * grid.voxel(), 1.01 * grid.voxel()});
                    check_same(restricted.compute(part, band, all_outputs()), expected);
                    std::vector<Vec3> points;
                    Random random(3);
                    for (int i = 0; i < 500; ++i)
                        points.push_back({random.uniform(box.lower[0], box.upper[0]),
                                          random.uniform(box.lower[1], box.upper[1]),
                                          random.uniform(box.lower[2], box.upper[2])});
                    points.push_back(box.lower);
                    check_same(query(restricted, points, 3 * h), query(whole, points, 3 * h));
                    const std::span<const Vec3> few = std::span(points).first(90);
                    check_same(query(restricted, few, 3 * h), query(whole, few, 3 * h));
                }
            }
        }
}

BOOST_AUTO_TEST_CASE(slabs_have_the_sign_of_the_whole) {
    for (const auto& [mesh, meant] : doubtful_meshes()) {
        const DistanceTransform transform(test_device(), mesh);
        const Grid grid = grid_around(mesh, 40, 2);
        const Band band = Band::symmetric(3 * grid.voxel());
        const Field whole = transform.compute(grid, band);
        std::size_t wrong = 0;
        transform.compute(grid, band, {}, [&](const Grid& part, const FieldSlab& slab) {
            const Field expected = part_of(whole, part);
            wrong += same_bytes(slab, expected.slab(), Output::distance) ? 0U : 1U;
        });
        BOOST_TEST(wrong == 0U);
    }
}

BOOST_AUTO_TEST_CASE(gradients_on_the_surface_point_outside) {
    // Samples on faces, edges and vertices of a cube, some of whose faces are turned or doubled.
    const Mesh solid = cube(1);
    const Triangle face = solid.triangles()[3];
    for (const Mesh& mesh :
         {with_turned(solid, {0, 5, 6}, "turned faces"), with_faces(solid, {face, turned(face), face}, "doubled faces"),
          with_faces(solid, {turned(face), face, turned(face), face, face}, "more doubled faces")})
        for (const KernelBody body : bodies()) {
            BOOST_TEST_CONTEXT(mesh.name()) {
                const Grid grid = grid_at({0, 0, 0}, 0.25, 6);
                const Band band = Band::symmetric(1);
                check_exact(mesh, compute(mesh, grid, band, body));
                const Field found = compute(mesh, grid, band, body), right = compute(solid, grid, band, body);
                std::size_t on_surface = 0, wrong = 0;
                for (std::size_t i = 0; i < right.distance().size(); ++i) {
                    if (right.distance()[i] != 0) continue;
                    ++on_surface;
                    double product = 0;
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        product += static_cast<double>(found.gradient()[3 * i + axis] * right.gradient()[3 * i + axis]);
                    wrong += product > 0.999 ? 0U : 1U;
                }
                BOOST_TEST(on_surface > 300U);
                BOOST_TEST(wrong == 0U);
                const std::vector<Vec3> points = samples_of(grid);
                const Field at_points = query(DistanceTransform(test_device(), mesh, {.body = body}), points);
                for (std::size_t i = 0; i < right.distance().size(); ++i) {
                    if (right.distance()[i] != 0) continue;
                    double product = 0;
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        product +=
                            static_cast<double>(at_points.gradient()[3 * i + axis] * right.gradient()[3 * i + axis]);
                    BOOST_TEST(product > 0.999);
                }
            }
        }
}

BOOST_AUTO_TEST_CASE(a_moved_mesh_keeps_its_surface) {
    for (const auto& [mesh, meant] : doubtful_meshes()) {
        BOOST_TEST_CONTEXT(mesh.name()) {
            DistanceTransform transform(test_device(), mesh);
            std::vector<Vec3> positions = mesh.vertices();
            for (Vec3& p : positions) p = {0.8 * p[0] + 0.2 * p[2] + 5, 0.9 * p[1] - 0.3 * p[2] - 2, 1.1 * p[2] + 0.1};
            transform.set_positions(positions);
            const Mesh moved(positions, mesh.triangles(), mesh.name());
            std::vector<Vec3> of_meant = meant.vertices();
            for (Vec3& p : of_meant) p = {0.8 * p[0] + 0.2 * p[2] + 5, 0.9 * p[1] - 0.3 * p[2] - 2, 1.1 * p[2] + 0.1};
            const Mesh right(of_meant, meant.triangles(), meant.name());
            const Grid grid = grid_around(moved, 30, 3);
            const Band band = Band::symmetric(3 * grid.voxel());
            const Field field = transform.compute(grid, band, all_outputs());
            const Field expected = compute(right, grid, band);
            for (std::size_t i = 0; i < field.distance().size(); ++i)
                if (std::abs(expected.distance()[i]) > 1e-6F &&
                    std::signbit(field.distance()[i]) != std::signbit(expected.distance()[i]))
                    BOOST_ERROR("sample " << i << " has the wrong sign");
            const std::vector<Vec3> points = points_about(moved, 2000, 13);
            const Field found = query(transform, points);
            for (std::size_t i = 0; i < points.size(); ++i)
                if ((std::round(solid_angles(right, points[i])) != 0) != std::signbit(found.distance()[i]))
                    BOOST_ERROR("point " << i << " has the wrong sign");
            const double s = std::sin(0.7), c = std::cos(0.7);
            transform.set_motion({Vec3{c, -s, 0}, Vec3{s, c, 0}, Vec3{0, 0, 1}}, {3, 2, 1});
            BOOST_TEST(
                static_cast<std::size_t>(std::ranges::count_if(
                    transform.compute(grid_at({3, 2, 1}, mesh.box().longest_side() / 20, 12), Band::full()).distance(),
                    [](float distance) { return std::signbit(distance); })) > 20U);
        }
    }
}

BOOST_AUTO_TEST_CASE(joined_vertices_must_move_together) {
    const Mesh mesh = seamed_torus();
    std::vector<Vec3> positions = mesh.vertices();
    // The seam is where u is 0 and 2 pi.
    const auto last = static_cast<std::size_t>(
        std::ranges::find_if(positions, [](const Vec3& p) { return p[1] < 0 && p[1] > -1e-12 && p[0] > 1.3; }) -
        positions.begin());
    BOOST_REQUIRE(last < positions.size());
    positions[last][2] += 1e-6;
    DistanceTransform transform(test_device(), mesh);
    const Grid grid = grid_around(mesh, 20, 2);
    const Field before = transform.compute(grid, Band::full());
    check_throws(ErrorCode::invalid_argument, {"vertices", "rounding", "move apart", "make a new transform"},
                 [&] { transform.set_positions(positions); });
    BOOST_TEST(same_bytes(before, transform.compute(grid, Band::full())));
    DistanceTransform(test_device(), mesh, {.sign = SignRule::none}).set_positions(positions);
}

BOOST_AUTO_TEST_CASE(boxes_have_their_places) {
    for (const auto& [mesh, meant] : doubtful_meshes()) {
        BOOST_TEST_CONTEXT(mesh.name()) {
            const DistanceTransform transform(test_device(), mesh), right(test_device(), meant);
            std::vector<Box> boxes;
            const double side = mesh.box().longest_side() / 60;
            for (const Vec3& p : points_about(mesh, 1000, 3))
                boxes.push_back({p, {p[0] + side, p[1] + side, p[2] + side}});
            std::vector<BoxPlace> found(boxes.size()), expected(boxes.size());
            transform.classify(boxes, side, found);
            right.classify(boxes, side, expected);
            // Boxes near sheets, which have no inside, are near the mesh, too.
            const bool has_sheets = transform.topology().sheet_faces > 0;
            for (std::size_t i = 0; i < boxes.size(); ++i)
                BOOST_TEST((found[i] == expected[i] || (has_sheets && found[i] == BoxPlace::within)));
        }
    }
}
