#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/throws.hpp"
#include "support/winding.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

using namespace clsdf;
using namespace clsdf::test;

namespace {

std::vector<BoxPlace> places_of(const DistanceTransform& transform, std::span<const Box> boxes, double half_width) {
    std::vector<BoxPlace> places(boxes.size());
    transform.classify(boxes, half_width, places);
    return places;
}

/// The cells of so many levels of a tree whose root is the mesh's box, enlarged by half.
std::vector<Box> tree_cells(const Mesh& mesh, int levels) {
    std::vector<Box> cells;
    const double side = 1.5 * mesh.box().longest_side();
    for (int level = 0; level < levels; ++level) {
        const int count = 1 << level;
        for (int n = 0; n < count * count * count; ++n) {
            const std::array<int, 3> place{n % count, n / count % count, n / (count * count)};
            Box cell;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double middle = (mesh.box().lower[axis] + mesh.box().upper[axis]) / 2;
                cell.lower[axis] = middle - side / 2 + side * place[axis] / count;
                cell.upper[axis] = middle - side / 2 + side * (place[axis] + 1) / count;
            }
            cells.push_back(cell);
        }
    }
    return cells;
}

/// Corners of a box, its centre and points inside.
std::vector<Vec3> points_of(const Box& box, std::mt19937_64& generator) {
    std::uniform_real_distribution<double> part(0, 1);
    std::vector<Vec3> points;
    for (int n = 0; n < 14; ++n) {
        Vec3 p;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double weight = n < 8 ? (n >> axis) % 2 : n == 8 ? 0.5 : part(generator);
            p[axis] =
                std::clamp((1 - weight) * box.lower[axis] + weight * box.upper[axis], box.lower[axis], box.upper[axis]);
        }
        points.push_back(p);
    }
    return points;
}

struct Seen {
    std::size_t near = 0, inside = 0, outside = 0, far = 0;
};

/// Holds the places against distances and winding numbers at points of the boxes.
Seen check_places(const Mesh& mesh, SignRule rule, std::span<const Box> boxes, double half_width) {
    const DistanceTransform transform(test_device(), mesh, {.sign = rule});
    const reference::Oracle oracle(mesh);
    std::mt19937_64 generator(7);
    const std::vector<BoxPlace> places = places_of(transform, boxes, half_width);
    Seen seen;
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        if (places[i] == BoxPlace::within) {
            ++seen.near;
            continue;
        }
        ++(places[i] == BoxPlace::inside ? seen.inside : places[i] == BoxPlace::outside ? seen.outside : seen.far);
        for (const Vec3& p : points_of(boxes[i], generator)) {
            if (oracle.nearest(p).distance <= half_width) ++wrong;
            if (transform.sign() == SignRule::none) {
                wrong += places[i] != BoxPlace::beyond ? 1U : 0U;
                continue;
            }
            if (transform.sign() == SignRule::solid_angle) {
                const bool is_inside = std::abs(winding_by_faces(mesh, p)) >= 0.5;
                wrong += is_inside != (places[i] == BoxPlace::inside) ? 1U : 0U;
                continue;
            }
            const std::optional<int> winding = oracle.winding_number(p);
            const bool is_inside =
                winding && (transform.sign() == SignRule::parity ? *oracle.crossings(p) % 2 != 0 : *winding != 0);
            wrong += !winding || is_inside != (places[i] == BoxPlace::inside) ? 1U : 0U;
        }
    }
    BOOST_TEST(wrong == 0U, wrong << " points belie their box's place");
    return seen;
}

}  // namespace

BOOST_AUTO_TEST_CASE(boxes_that_are_not_near_lie_on_one_side) {
    Random random(3);
    for (const Mesh& mesh : {cube(1), reversed(cube(1)), overlapping_cubes(), tilted(make_shape("noisy")),
                             make_shape("knot"), random_soup(random, 20, 40), without_triangle(cube(1), 3)}) {
        const double side = mesh.box().longest_side();
        const std::vector<Box> cells = tree_cells(mesh, 5);
        Seen all;
        for (const double half_width : {0.0, 0.02 * side, 0.4 * side}) {
            const Seen seen = check_places(mesh, SignRule::automatic, cells, half_width);
            BOOST_TEST(seen.near > 0U);
            all.inside += seen.inside;
            all.outside += seen.outside;
            all.far += seen.far;
        }
        const bool has_sign = DistanceTransform(test_device(), mesh).sign() != SignRule::none;
        BOOST_TEST((all.far > 0U) == !has_sign, mesh.name());
        BOOST_TEST((all.outside > 0U) == has_sign, mesh.name());
        if (mesh.name() != "knot" && has_sign) BOOST_TEST(all.inside > 0U, mesh.name());
    }
    for (const SignRule rule : {SignRule::parity, SignRule::none}) {
        const Mesh mesh = overlapping_cubes();
        check_places(mesh, rule, tree_cells(mesh, 5), 0.05);
    }
}

// A sphere's triangles are small: the box around one lies within a tenth of the radius.
BOOST_AUTO_TEST_CASE(boxes_far_beyond_the_half_width_are_not_near) {
    const Mesh sphere = make_shape("sphere6");
    const double radius = sphere.box().longest_side() / 2;
    const DistanceTransform transform(test_device(), sphere);
    const std::vector<Box> cells = tree_cells(sphere, 6);
    for (const double half_width : {0.0, 0.1 * radius, 0.5 * radius}) {
        const std::vector<BoxPlace> places = places_of(transform, cells, half_width);
        std::size_t wrong = 0, near = 0;
        for (std::size_t i = 0; i < cells.size(); ++i) {
            double nearest = 0, farthest = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double lower = cells[i].lower[axis], upper = cells[i].upper[axis];
                nearest += std::pow(std::max({lower, -upper, 0.0}), 2);
                farthest += std::pow(std::max(std::abs(lower), std::abs(upper)), 2);
            }
            const double reach = half_width + 0.1 * radius;
            const BoxPlace expected = std::sqrt(nearest) > radius + reach    ? BoxPlace::outside
                                      : std::sqrt(farthest) < radius - reach ? BoxPlace::inside
                                                                             : BoxPlace::within;
            if (expected == BoxPlace::within)
                ++near;
            else
                wrong += places[i] != expected ? 1U : 0U;
        }
        BOOST_TEST(wrong == 0U);
        BOOST_TEST(near > 0U);
    }
}

BOOST_AUTO_TEST_CASE(a_box_that_touches_is_near_and_the_next_float_is_not) {
    const DistanceTransform transform(test_device(), cube(1));
    const Box unit_box{{2, -0.25, -0.25}, {3, 0.25, 0.25}};  // a unit from the face at x = 1
    const Box in_the_middle{{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}};
    const Box point{{0.25, 0.5, 0}, {0.25, 0.5, 0}};
    const std::array boxes{unit_box, in_the_middle, point};
    const std::vector<BoxPlace> touching = places_of(transform, boxes, 1);
    BOOST_TEST((touching[0] == BoxPlace::within));
    const std::vector<BoxPlace> apart = places_of(transform, boxes, 0.499);
    BOOST_TEST((apart[0] == BoxPlace::outside));
    BOOST_TEST((apart[1] == BoxPlace::inside));
    BOOST_TEST((apart[2] == BoxPlace::inside));
    BOOST_TEST((places_of(transform, boxes, 0.5)[2] == BoxPlace::within));
    const std::array far{Box{{1e300, 0, 0}, {1.5e300, 1, 1}}, Box{{-1e300, -1e300, -1e300}, {1e300, 1e300, 1e300}}};
    BOOST_TEST((places_of(transform, far, 1)[0] == BoxPlace::outside));
    BOOST_TEST((places_of(transform, far, 1)[1] == BoxPlace::within));
    BOOST_TEST((places_of(transform, far, std::numeric_limits<double>::infinity())[0] == BoxPlace::within));
}

BOOST_AUTO_TEST_CASE(an_answer_depends_on_its_box_alone_and_follows_moves) {
    const Mesh mesh = tilted(make_shape("noisy"));
    DistanceTransform transform(test_device(), mesh);
    std::vector<Box> cells = tree_cells(mesh, 5);
    const double half_width = 0.03 * mesh.box().longest_side();
    const std::vector<BoxPlace> all = places_of(transform, cells, half_width);
    std::size_t differences = 0;
    for (std::size_t i = 0; i < cells.size(); i += 13)
        differences += places_of(transform, std::span(cells).subspan(i, 1), half_width)[0] != all[i] ? 1U : 0U;
    BOOST_TEST(differences == 0U);
    const Mesh other = moved(mesh, [](const Vec3& p) { return Vec3{p[0] + p[1] * p[1], 1.3 * p[1], p[2] - p[0]}; });
    transform.set_positions(other.vertices());
    BOOST_TEST((places_of(transform, cells, half_width) ==
                places_of(DistanceTransform(test_device(), other), cells, half_width)));
    BOOST_TEST((places_of(transform, cells, half_width) != all));
}

BOOST_AUTO_TEST_CASE(errors_name_the_box_and_the_argument) {
    const DistanceTransform transform(test_device(), cube(1));
    std::vector<Box> boxes(4, Box{{0, 0, 0}, {1, 1, 1}});
    std::vector<BoxPlace> places(4);
    const auto refused = [&](const std::vector<std::string>& fragments, double half_width = 1) {
        check_throws(ErrorCode::invalid_argument, fragments, [&] { transform.classify(boxes, half_width, places); });
    };
    boxes[2].upper[1] = std::numeric_limits<double>::quiet_NaN();
    refused({"box 2", "nan", "not finite"});
    boxes[2].upper[1] = -1;
    refused({"box 2", "-1", "exchanged"});
    boxes[2].upper[1] = 0;
    refused({"half width", "-1"}, -1);
    refused({"half width", "nan"}, std::numeric_limits<double>::quiet_NaN());
    places.resize(3);
    refused({"4 boxes", "3 places"});
}
