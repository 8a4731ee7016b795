#include "random_scenes.hpp"

#include <boost/test/unit_test.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <numeric>

using namespace clsdf;
using namespace clsdf::test;

namespace {

double length(const Vec3& a, const Vec3& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

template <typename T>
bool have_same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

constexpr std::uint64_t first_seed = 1;

/// CLSDF_SCENES=2000 asks for more scenes.
std::uint64_t last_seed() {
    const char* const asked = std::getenv("CLSDF_SCENES");
    return asked == nullptr ? 300 : std::strtoull(asked, nullptr, 10);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_scene_has_the_least_of_the_distances_of_its_bodies) {
    const std::uint64_t last = last_seed();
    std::size_t wrong = 0, own = 0, not_own = 0, inside = 0;
    for (std::uint64_t seed = first_seed; seed <= last; ++seed) {
        const RandomScene random(seed);
        const double tolerance = random.tolerance;
        for (const double half_width : {no_limit, 0.2}) {
            const PointValues found = query(random.scene, random.points, half_width);
            std::vector<std::uint8_t> is_inside(random.points.size());
            random.scene.contains(random.points, is_inside);
            for (std::size_t i = 0; i < random.points.size(); ++i) {
                const double least = random.least(i);
                const double expected = std::clamp(least, -half_width, half_width);
                bool is_right = std::abs(found.distance[i] - expected) <= tolerance;
                if (least < -tolerance) is_right = is_right && is_inside[i] == 1;
                if (least > tolerance) is_right = is_right && is_inside[i] == 0;
                const std::uint32_t body = found.body[i];
                if (std::abs(least) > half_width + tolerance)
                    is_right = is_right && body == no_body && found.triangle[i] == no_triangle && found.is_own[i] == 1;
                if (std::abs(least) < half_width - tolerance) is_right = is_right && body < random.bodies.size();
                if (is_right && body != no_body) {
                    is_right =
                        std::abs(random.of_bodies[body][i] - least) <= 2 * tolerance &&
                        std::abs(length(found.closest[i], random.points[i]) - std::abs(least)) <= 2 * tolerance &&
                        found.triangle[i] < random.bodies[body].mesh->triangles().size();
                    for (std::size_t a = 0; a < 3; ++a)
                        is_right =
                            is_right &&
                            std::abs(random.points[i][a] + found.offset[i][a] - found.closest[i][a]) <= 2 * tolerance &&
                            (std::abs(least) < 1e-3 ||
                             std::abs(found.gradient[i][a] * found.distance[i] + found.offset[i][a]) <= 4 * tolerance);
                    // The closest point of another body may be where this one's is: then none is the union's for sure.
                    double of_others = no_limit;
                    for (std::size_t other = 0; other < random.bodies.size(); ++other)
                        if (other != body && random.transforms[other].sign() != SignRule::none)
                            of_others = std::min(
                                of_others, distances(random.transforms[other], std::span(&found.closest[i], 1))[0]);
                    if (found.is_own[i] == 1)
                        is_right = is_right && (least > -tolerance || of_others > 0);
                    else
                        is_right = is_right && least < tolerance && of_others <= 1e-5;
                    inside += least < 0 ? 1U : 0U;
                    (found.is_own[i] == 1 ? own : not_own) += 1;
                }
                wrong += is_right ? 0U : 1U;
                if (!is_right && wrong < 5)
                    BOOST_TEST_MESSAGE("seed " << seed << ", point " << i << " within " << half_width << ": found "
                                               << found.distance[i] << " of body " << body << ", expected " << expected
                                               << ", own " << int{found.is_own[i]});
            }
        }
    }
    BOOST_TEST(wrong == 0U, wrong << " points are wrong; seeds " << first_seed << " to " << last);
    BOOST_TEST(inside > 1000U);
    BOOST_TEST(own > 1000U);
    BOOST_TEST(not_own > 100U);
}

BOOST_AUTO_TEST_CASE(neither_order_nor_other_points_nor_bodies_that_are_off_change_a_value) {
    std::size_t wrong = 0;
    for (std::uint64_t seed = 1001; seed <= 1060; ++seed) {
        RandomScene random(seed);
        const PointValues found = query(random.scene, random.points);
        for (std::size_t i = 0; i < random.points.size(); i += 7) {
            const PointValues alone = query(random.scene, std::span(random.points).subspan(i, 1));
            wrong += alone.distance[0] != found.distance[i] || alone.body[0] != found.body[i] ||
                             std::memcmp(alone.gradient.data(), &found.gradient[i], sizeof(Vec3)) != 0
                         ? 1U
                         : 0U;
        }
        Scene reversed(test_device());
        const auto last = static_cast<std::uint32_t>(random.bodies.size() - 1);
        for (std::uint32_t i = 0; i <= last; ++i) {
            const BodyOfTest& body = random.bodies[last - i];
            reversed.add(*body.mesh, body.pose, body.sign);
        }
        const PointValues other = query(reversed, random.points);
        for (std::size_t i = 0; i < random.points.size(); ++i)
            wrong += other.distance[i] != found.distance[i] ||
                             (other.body[i] != last - found.body[i] &&
                              random.of_bodies[last - other.body[i]][i] > random.least(i) + random.tolerance)
                         ? 1U
                         : 0U;
        if (last == 0) continue;
        Scene without(test_device());
        for (std::uint32_t i = 0; i < last; ++i)
            without.add(*random.bodies[i].mesh, random.scene.pose(i), random.bodies[i].sign);
        random.scene.set_active(last, false);
        const PointValues off = query(random.scene, random.points), absent = query(without, random.points);
        wrong += have_same_bytes(off.distance, absent.distance) && have_same_bytes(off.body, absent.body) &&
                         have_same_bytes(off.closest, absent.closest) && have_same_bytes(off.is_own, absent.is_own)
                     ? 0U
                     : 1U;
    }
    BOOST_TEST(wrong == 0U, "seeds 1001 to 1060");
}

BOOST_AUTO_TEST_CASE(pairs_have_the_distances_of_one_body_and_winding_numbers_add_up) {
    std::size_t wrong = 0;
    for (std::uint64_t seed = 2001; seed <= 2060; ++seed) {
        RandomScene random(seed);
        std::vector<PointOfBody> pairs;
        for (std::uint32_t i = 0; i < 200; ++i)
            pairs.push_back({random.random.index(random.points.size()), random.random.index(random.bodies.size())});
        std::vector<double> found(pairs.size());
        random.scene.query_pairs(random.points, pairs, no_limit, found);
        for (std::size_t i = 0; i < pairs.size(); ++i)
            wrong += std::abs(found[i] - random.of_bodies[pairs[i].body][pairs[i].point]) <= random.tolerance ? 0U : 1U;
        std::vector<double> sums(random.points.size()), expected(random.points.size()), of_body(random.points.size());
        random.scene.winding(random.points, sums);
        for (const DistanceTransform& transform : random.transforms) {
            transform.winding(random.points, of_body);
            for (std::size_t i = 0; i < sums.size(); ++i) expected[i] += of_body[i];
        }
        for (std::size_t i = 0; i < sums.size(); ++i) {
            double nearest = no_limit;
            for (const std::vector<double>& of_one : random.of_bodies) nearest = std::min(nearest, std::abs(of_one[i]));
            wrong += nearest < 1e-6 || std::abs(sums[i] - expected[i]) <= 1e-6 ? 0U : 1U;
        }
    }
    BOOST_TEST(wrong == 0U, "seeds 2001 to 2060");
}

BOOST_AUTO_TEST_CASE(boxes_are_inside_one_body_or_outside_all_of_them) {
    std::size_t wrong = 0, inside = 0, outside = 0;
    for (std::uint64_t seed = 3001; seed <= 3080; ++seed) {
        RandomScene random(seed);
        std::vector<Box> boxes;
        for (const Vec3& p : random.points) {
            const double size = random.random.uniform(0, 0.3);
            boxes.push_back({{p[0] - size, p[1] - size, p[2] - size}, {p[0] + size, p[1] + size, p[2] + size}});
        }
        const double half_width = random.random.uniform(0, 0.1);
        std::vector<BoxPlace> places(boxes.size());
        random.scene.classify(boxes, half_width, places);
        for (std::size_t i = 0; i < boxes.size(); ++i) {
            const double size = (boxes[i].upper[0] - boxes[i].lower[0]) / 2, least = random.least(i);
            if (places[i] == BoxPlace::inside) wrong += least > -half_width - size + random.tolerance ? 1U : 0U;
            if (places[i] == BoxPlace::outside || places[i] == BoxPlace::beyond)
                wrong += least < half_width + size - random.tolerance ? 1U : 0U;
            // Boxes are taken for larger ones if a body is turned, and triangles for the boxes around them.
            if (std::abs(least) > half_width + 6 * size + 4) wrong += places[i] == BoxPlace::within ? 1U : 0U;
            if (random.scene.has_sign()) wrong += places[i] == BoxPlace::beyond ? 1U : 0U;
            inside += places[i] == BoxPlace::inside ? 1U : 0U;
            outside += places[i] == BoxPlace::outside ? 1U : 0U;
        }
    }
    BOOST_TEST(wrong == 0U, "seeds 3001 to 3080");
    BOOST_TEST(inside > 10U);
    BOOST_TEST(outside > 100U);
}
