// A part with a margin gives the bytes of the whole transform when vertices have moved by up to the margin.
#include "calls/restricted_bodies.hpp"
#include "support/throws.hpp"

#include <clsdf/tuning.hpp>

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// Positions that are just less than a margin from the mesh's.
std::vector<Vec3> moved(const DistanceTransform& transform, const Mesh& mesh, double margin, std::uint64_t seed) {
    Random random(seed);
    const Topology& topology = transform.topology();
    std::vector<Vec3> positions = mesh.vertices();
    const double way = 0.999999 * margin, side = mesh.box().longest_side();
    if (topology.coincident_vertices == 0 && topology.joined_vertices == 0) {
        for (Vec3& at : positions) at = along(at, random.index(4) == 0 ? 0 : way, random.direction());
        return positions;
    }
    // Those that are equal, or nearly, move together.
    const Vec3 waves = random.point(-20, 20), phases = random.point(0, 6);
    for (Vec3& at : positions) {
        const double angle = (waves[0] * at[0] + waves[1] * at[1] + waves[2] * at[2]) / side;
        at = along(at, way / std::sqrt(3),
                   {std::sin(angle + phases[0]), std::sin(angle + phases[1]), std::sin(angle + phases[2])});
    }
    return positions;
}

std::vector<Vec3> of_part(const DistanceTransform& part, std::span<const Vec3> positions) {
    std::vector<Vec3> own;
    for (const std::uint32_t vertex : part.part_vertices()) own.push_back(positions[vertex]);
    return own;
}

/// positions: of all vertices of the whole.
void move(DistanceTransform& part, std::span<const Vec3> positions) {
    const std::vector<Vec3> own = of_part(part, positions);
    part.set_positions(own);
}

/// Blocks of a box by random cuts.
std::vector<Box> random_blocks(Random& random, const Box& box) {
    std::vector<Box> blocks{box};
    for (int cut = 0; cut < 2; ++cut) {
        std::vector<Box> halves;
        for (const Box& block : blocks) {
            const std::size_t axis = random.index(3);
            const double at = random.uniform(block.lower[axis], block.upper[axis]);
            halves.insert(halves.end(), 2, block);
            halves[halves.size() - 2].upper[axis] = halves.back().lower[axis] = at;
        }
        blocks = halves;
    }
    return blocks;
}

OutputSet all_but_gradients() {
    OutputSet outputs;
    for (const OutputInfo& info : output_table())
        if (info.output != Output::gradient) outputs.insert(info.output);
    return outputs;
}

bool can_turn_inside_out(const DistanceTransform& part, const Region& region) {
    const Vec3 point = region.box.lower;
    std::vector<float> distance(1), gradient(3);
    try {
        part.query(std::span(&point, 1), region.half_width,
                   {{Output::distance, distance}, {Output::gradient, gradient}});
    } catch (const Error& error) {
        BOOST_TEST((error.code() == ErrorCode::unsupported));
        return std::string(error.what()).find("inside out") != std::string::npos;
    }
    return false;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_moved_part_has_the_bytes_of_the_whole_at_the_same_positions) {
    Random random(31);
    std::uint64_t seed = 0;
    std::size_t with_gradients = 0, without_gradients = 0;
    for (const auto& [mesh, options] : bodies()) {
        const double side = mesh.box().longest_side(), h = side / 30;
        for (const double margin : {0.3 * h, 2.5 * h}) {
            DistanceTransform whole(test_device(), mesh, options);
            Box around = mesh.box();
            for (std::size_t axis = 0; axis < 3; ++axis) around.lower[axis] -= 3 * h, around.upper[axis] += 3 * h;
            const Vec3 origin{0.1 * side, -0.3 * side, 0.2 * side};
            for (const Box& box : random_blocks(random, around)) {
                whole.set_positions(mesh.vertices());
                const Grid bricks = in_whole_bricks(samples_in(box, h, origin));
                const std::array regions{Region{box, 4 * h, h}, Region{bricks.box(), 4 * h, h}};
                DistanceTransform part =
                    DistanceTransform::from_part(test_device(), whole.restrict_to(regions, margin).part_bytes());
                check_same_answers(whole, part, regions[0], origin);
                for (int step = 0; step < 2; ++step) {
                    const std::vector<Vec3> positions = moved(whole, mesh, margin, ++seed);
                    whole.set_positions(positions);
                    move(part, positions);
                    BOOST_TEST_CONTEXT(mesh.name() << ", margin " << margin << ", seed " << seed) {
                        BOOST_TEST(part.box().lower == whole.box().lower, boost::test_tools::per_element());
                        BOOST_TEST(part.box().upper == whole.box().upper, boost::test_tools::per_element());
                        const bool has_gradients = !can_turn_inside_out(part, regions[0]);
                        (has_gradients ? with_gradients : without_gradients) += 1;
                        check_same_answers(whole, part, regions[0], origin,
                                           has_gradients ? all_outputs() : all_but_gradients());
                    }
                }
            }
        }
    }
    BOOST_TEST(with_gradients > without_gradients);
}

// The parts have few of the vertices, also of the sample that bounds distances.
BOOST_AUTO_TEST_CASE(small_parts_of_a_large_mesh_move_as_the_whole) {
    Random random(8);
    const Mesh mesh = tilted(make_shape("sphere7"));
    const double h = mesh.box().longest_side() / 250;
    DistanceTransform whole(test_device(), mesh);
    std::vector<DistanceTransform> parts;
    std::vector<Region> regions;
    const std::array margins{0.2 * h, 4 * h, 4 * h, h, h};
    for (const double margin : margins) {
        const Vec3 at = mesh.vertices()[random.index(mesh.vertices().size())];
        Box box{at, at};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            box.lower[axis] -= random.uniform(2, 12) * h;
            box.upper[axis] += random.uniform(2, 12) * h;
        }
        regions.push_back({box, 3 * h, h});
        const std::array both{regions.back(), Region{in_whole_bricks(samples_in(box, h, {0, 0, 0})).box(), 3 * h, h}};
        parts.push_back(whole.restrict_to(both, margin));
    }
    for (const double margin : {0.2 * h, h, 4 * h}) {
        const std::vector<Vec3> positions = moved(whole, mesh, margin, parts.size());
        whole.set_positions(positions);
        for (std::size_t n = 0; n < parts.size(); ++n) {
            BOOST_TEST_CONTEXT("part " << n << ", margin " << margin) {
                // The whole's vertices move by up to the margin, so some of a part do by more than a smaller one.
                if (margin > margins[n]) {
                    check_throws(ErrorCode::invalid_argument, {}, [&] { move(parts[n], positions); });
                    continue;
                }
                move(parts[n], positions);
                BOOST_TEST(parts[n].box().lower == whole.box().lower, boost::test_tools::per_element());
                BOOST_TEST(parts[n].box().upper == whole.box().upper, boost::test_tools::per_element());
                check_same_answers(whole, parts[n], regions[n], {0, 0, 0}, all_but_gradients());
            }
        }
    }
}

// Its corners belong to sheets far from the region, and from each other.
BOOST_AUTO_TEST_CASE(a_large_face_comes_near_within_the_margin) {
    std::vector<Vec3> positions;
    std::vector<Triangle> triangles;
    constexpr std::uint32_t side = 32;  // of a sheet, in vertices
    for (const auto& [x, y] : {std::pair(-20, 0), std::pair(20, 18), std::pair(20, 22)})
        for (std::uint32_t j = 0; j < side; ++j)
            for (std::uint32_t i = 0; i < side; ++i) {
                const auto at = static_cast<std::uint32_t>(positions.size());
                positions.push_back({x + i / 16.0, y + j / 16.0, 0});
                if (i + 1 == side || j + 1 == side) continue;
                triangles.push_back({at, at + 1, at + side + 1});
                triangles.push_back({at, at + side + 1, at + side});
            }
    const Triangle large{0, side * side, 2 * side * side};
    triangles.push_back(large);
    DistanceTransform whole(test_device(), Mesh(positions, triangles, "sheets"), {.sign = SignRule::none});
    DistanceTransform part = whole.restrict_to({{{-10, 4, 1.5}, {-9, 6, 1.6}}, 1, 0}, 1);
    for (const std::uint32_t vertex : large) positions[vertex][2] += 0.999;
    whole.set_positions(positions);
    move(part, positions);
    const std::vector<Vec3> points{{-9.5, 5, 1.5}};
    check_same(query(whole, points, 1), query(part, points, 1));
    BOOST_TEST(query(part, points, 1).distance()[0] < 0.6F);
}

BOOST_AUTO_TEST_CASE(both_kernel_bodies_move_parts) {
    const Mesh mesh = tilted(make_shape("noisy"));
    const double side = mesh.box().longest_side(), h = side / 60;
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group}) {
        DistanceTransform whole(test_device(), mesh, {.body = body});
        const Box box = boxes_about(mesh).front();
        const Region region{box, 3 * h, h};
        DistanceTransform part = whole.restrict_to(region, h);
        const std::vector<Vec3> positions = moved(whole, mesh, h, 5);
        whole.set_positions(positions);
        move(part, positions);
        const Grid grid = samples_in(box, h, {0, 0, 0});
        check_same(whole.compute(grid, Band::symmetric(3 * h), all_outputs()),
                   part.compute(grid, Band::symmetric(3 * h), all_outputs()));
    }
}

BOOST_AUTO_TEST_CASE(a_moved_part_travels_and_keeps_its_margin) {
    const Mesh mesh = tilted(make_shape("knot"));
    const double side = mesh.box().longest_side(), h = side / 40, margin = h / 8;
    DistanceTransform whole(test_device(), mesh);
    const Region region{boxes_about(mesh).front(), 4 * h, h};
    const std::array regions{region, Region{in_whole_bricks(samples_in(region.box, h, {0, 0, 0})).box(), 4 * h, h}};
    DistanceTransform part = whole.restrict_to(regions, margin);
    std::vector<Vec3> positions = moved(whole, mesh, margin, 1);
    whole.set_positions(positions);
    move(part, positions);
    DistanceTransform sent = DistanceTransform::from_part(test_device(), part.part_bytes());
    BOOST_TEST((sent.part_vertices() == part.part_vertices()));
    check_same_answers(whole, sent, region, {0, 0, 0});
    positions = moved(whole, mesh, margin, 2);  // from the first place, two margins on
    whole.set_positions(positions);
    move(sent, positions);
    check_same_answers(whole, sent, region, {0, 0, 0});
    // A part of a mesh that has moved counts its margin from there.
    DistanceTransform later = whole.restrict_to(regions, margin);
    std::vector<Vec3> on = positions;
    for (Vec3& at : on) at[1] += 0.99 * margin;
    whole.set_positions(on);
    move(later, on);
    check_same_answers(whole, later, region, {0, 0, 0});
}

BOOST_AUTO_TEST_CASE(a_part_has_a_part_of_the_vertices) {
    const Mesh mesh = make_shape("sphere7");
    const DistanceTransform whole(test_device(), mesh);
    const DistanceTransform part = whole.restrict_to({{{0.5, 0.5, 0.3}, {0.7, 0.7, 0.5}}, 0.02, 0.005}, 0.002);
    const std::vector<std::uint32_t> vertices = part.part_vertices();
    BOOST_TEST(std::ranges::is_sorted(vertices));
    BOOST_TEST(vertices.size() < mesh.vertices().size() / 2);
}

BOOST_AUTO_TEST_CASE(a_vertex_beyond_the_margin_is_named) {
    const Mesh mesh = tilted(make_shape("knot"));
    const double side = mesh.box().longest_side(), h = side / 40, margin = 0.125;
    const DistanceTransform whole(test_device(), mesh);
    const Region region{boxes_about(mesh).front(), 4 * h, h};
    DistanceTransform part = whole.restrict_to(region, margin);
    const std::vector<std::uint32_t> vertices = part.part_vertices();
    const std::vector<Vec3> first = of_part(part, mesh.vertices());
    const Grid grid = samples_in(region.box, h, {0, 0, 0});
    const Field before = part.compute(grid, Band::symmetric(4 * h), all_outputs());
    const std::size_t one = vertices.size() / 3;
    std::vector<Vec3> positions = first;
    positions[one][2] += 1.0001 * margin;
    check_throws(
        ErrorCode::invalid_argument,
        {fmt::format("vertex {} of knot", vertices[one]), "moves by 0.125", "the margin 0.125", "larger margin"},
        [&] { part.set_positions(positions); });
    positions[one][2] = std::numeric_limits<double>::infinity();
    check_throws(ErrorCode::invalid_mesh, {fmt::format("vertex {}", vertices[one]), "not finite"},
                 [&] { part.set_positions(positions); });
    check_throws(ErrorCode::invalid_argument, {"vertices, and 3 positions", "part_vertices()"},
                 [&] { part.set_positions(std::span(positions).first(3)); });
    check_same(before, part.compute(grid, Band::symmetric(4 * h), all_outputs()));
    check_throws(ErrorCode::unsupported, {"the margin", "in the place of a motion"}, [&] {
        part.set_motion({{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {0, 0, 0});
    });
    check_throws(ErrorCode::unsupported, {"restrict", "with a margin"},
                 [&] { whole.restrict_to(region).part_vertices(); });
    check_throws(ErrorCode::unsupported, {"restrict", "with a margin"}, [&] { whole.part_vertices(); });
    check_throws(ErrorCode::invalid_argument, {"the margin is -1"}, [&] { whole.restrict_to(region, -1); });
    const DistanceTransform outer(test_device(), together({cube(1), shifted(cube(1), {0.5, 0.6, 0.7})}, "two"),
                                  {.surface = Surface::outer});
    check_throws(ErrorCode::unsupported, {"margin", "the mesh of outer()"}, [&] {
        outer.restrict_to({{{0, 0, 0}, {1, 1, 1}}, 0.3, 0.1}, 0.1);
    });
}

BOOST_AUTO_TEST_CASE(a_part_that_cannot_tell_the_sign_of_the_volume_has_no_gradients_when_it_has_moved) {
    std::vector<Vec3> thin = cube(1).vertices();
    for (Vec3& at : thin) at[2] *= 0.01;
    const Mesh plate(thin, cube(1).triangles(), "plate");
    const DistanceTransform whole(test_device(), plate);
    const Region region{plate.box(), 0.2, 0.05};
    const Vec3 point{0.5, 0.5, 0.005};
    std::vector<float> distance(1), gradient(3);
    const OutputTargets with_gradient{{Output::distance, distance}, {Output::gradient, gradient}};
    for (const double margin : {0.1, 0.0005}) {
        DistanceTransform part = whole.restrict_to(region, margin);
        part.query(std::span(&point, 1), 0.2, with_gradient);
        move(part, plate.vertices());
        part.query(std::span(&point, 1), 0.2, distance);
        const auto ask = [&] { part.query(std::span(&point, 1), 0.2, with_gradient); };
        if (margin == 0.1)
            check_throws(ErrorCode::unsupported, {"plate", "inside out", "smaller margin"}, ask);
        else
            ask();
        BOOST_TEST(
            (DistanceTransform::from_part(test_device(), part.part_bytes()).part_vertices() == part.part_vertices()));
    }
}
