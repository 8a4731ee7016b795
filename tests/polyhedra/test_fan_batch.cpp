#include "polyhedra/cone_search.hpp"
#include "polyhedra/edge_slopes.hpp"
#include "polyhedra/fan_batch.hpp"
#include "polyhedra/gaps.hpp"
#include "support/random_meshes.hpp"
#include "support/test_meshes.hpp"

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>

namespace clsdf::test {
namespace {

using polyhedra::ConeSearch;
using polyhedra::Corner;
using polyhedra::Vector;

constexpr double infinite = std::numeric_limits<double>::infinity();

/// From flat to spiky, of 3 to 13 faces, one in eight around its tip twice, one in two inside out.
Mesh random_fan(Random& random) {
    const std::size_t count = 3 + random.index(11);
    const double turns = random.index(8) == 0 ? 2 : 1;
    const double waves = std::pow(10, random.uniform(-5, 1));
    const double slant = random.index(3) == 0 ? random.uniform(-6, 6) : 0;
    std::vector<Vec3> ring(count);
    for (std::size_t i = 0; i < count; ++i) {
        const double angle = 2 * std::numbers::pi * turns * (static_cast<double>(i) + random.uniform(-0.4, 0.4)) /
                             static_cast<double>(count);
        const double radius = random.uniform(0.5, 3);
        ring[i] = {radius * std::cos(angle), radius * std::sin(angle), slant + waves * random.uniform(-1, 1)};
    }
    Mesh mesh = closed_fan("fan", ring);
    if (random.index(2) == 0) return mesh;
    std::vector<Triangle> triangles = mesh.triangles();
    for (Triangle& triangle : triangles) std::swap(triangle[1], triangle[2]);
    return {mesh.vertices(), std::move(triangles), "fan inside out"};
}

/// The faces around vertex 0, and their edges that leave it and that arrive there, counter-clockwise.
struct Fan {
    polyhedra::OneRings rings;
    polyhedra::PairedEdges edges;
    std::vector<polyhedra::TriangleFrame> frames;
    std::vector<polyhedra::FaceSlopes> slopes;
    std::vector<Corner> leaving;
    std::vector<Corner> arriving;

    explicit Fan(const Mesh& mesh)
        : rings(mesh.triangles(), mesh.vertices().size()), edges(pair_edges(mesh.triangles(), rings)) {
        const polyhedra::LatticeView lattice;
        measure_edges({mesh.vertices(), mesh.triangles(), lattice}, edges.faces, {}, CLSDF_OPEN_SLOPE,
                      [&](polyhedra::EdgeSlopes& stretch) {
                          for (std::size_t face = stretch.begin(); face < stretch.end(); ++face) {
                              lean(stretch.frame(face), stretch.slopes(face));
                              frames.push_back(stretch.frame(face));
                              slopes.push_back(stretch.slopes(face));
                          }
                      });
        walk_first_fan(edges.faces, rings, 0, leaving);
        for (const Corner& corner : leaving)
            arriving.push_back({corner.face, polyhedra::previous_of_three(corner.vertex)});
    }

    polyhedra::LateralPlane plane(const Corner& edge) const {
        const polyhedra::FaceSlopes& of_face = slopes[edge.face];
        return {frames[edge.face].normal, frames[edge.face].inwards[edge.vertex], of_face.above[edge.vertex],
                of_face.below[edge.vertex]};
    }
    /// Lower planes reject more.
    void lower_slopes(Random& random) {
        for (polyhedra::FaceSlopes& face : slopes)
            for (std::array<float, 3>* side : {&face.above, &face.below})
                for (float& slope : *side) slope *= static_cast<float>(random.uniform(0, 1));
    }

    Vector mean_normal() const {
        Vector sum = Vector::Zero();
        for (const Corner& edge : leaving) sum += frames[edge.face].normal;
        return sum / static_cast<double>(leaving.size());
    }

    /// g with g . u >= margin where the plane of the edge, above or below the face, rejects u by the margin.
    Vector rejection(const Corner& edge, bool above) const {
        const polyhedra::LateralPlane of_edge = plane(edge);
        const auto slope = static_cast<double>(above ? of_edge.above : of_edge.below);
        return -(of_edge.inward + (above ? slope : -slope) * of_edge.normal) / (1 + slope);
    }
};

/// The least product of a unit vector with a condition.
double least_product(const std::vector<Vector>& conditions, const Vector& u, double enough = -infinite) {
    double least = infinite;
    for (const Vector& condition : conditions) {
        least = std::min(least, condition.dot(u));
        if (least <= enough) break;
    }
    return least;
}

/// The greatest least product of all unit vectors, where that is positive: the vector then points to the point of the
/// conditions' convex hull that is nearest to the origin, which lies on a corner, an edge or a triangle of it.
double greatest_least_product(const std::vector<Vector>& conditions) {
    double best = -infinite;
    const auto look_along = [&](const Vector& v) {
        const double length = v.norm();
        if (length > 1e-12) best = std::max(best, least_product(conditions, v / length, best));
    };
    for (std::size_t i = 0; i < conditions.size(); ++i) {
        look_along(conditions[i]);
        for (std::size_t j = 0; j < i; ++j) {
            const Vector side = conditions[j] - conditions[i];
            if (side.squaredNorm() > 0) look_along(conditions[i] - conditions[i].dot(side) / side.squaredNorm() * side);
            for (std::size_t k = 0; k < j; ++k) {
                const Vector normal = side.cross(conditions[k] - conditions[i]);
                look_along(normal);
                look_along(-normal);
            }
        }
    }
    return best;
}

BOOST_AUTO_TEST_SUITE(fan_batch)

std::vector<int> answers(const std::vector<const Fan*>& fans, double margin) {
    polyhedra::FanBatch batch;
    for (const Fan* fan : fans) batch.add(*fan, static_cast<std::uint32_t>(batch.size()), fan->leaving);
    polyhedra::FanBatch::Answers are_covered;
    batch.ask(margin, are_covered);
    return {are_covered.begin(), are_covered.begin() + static_cast<std::ptrdiff_t>(fans.size())};
}

BOOST_AUTO_TEST_CASE(what_is_said_of_a_fan_does_not_hang_on_the_fans_beside_it) {
    constexpr double margin = 1e-4;
    std::map<std::size_t, std::vector<const Fan*>> by_size;
    std::array<int, 2> seen{};
    std::vector<std::unique_ptr<Fan>> fans;
    for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
        Random random(seed);
        fans.push_back(std::make_unique<Fan>(random_fan(random)));
        if (seed % 2 == 0) fans.back()->lower_slopes(random);
        const std::size_t size = fans.back()->leaving.size();
        if (size > polyhedra::FanBatch::most_faces) continue;
        std::vector<const Fan*>& batch = by_size[size];
        batch.push_back(fans.back().get());
        if (batch.size() < polyhedra::lanes) continue;
        const std::vector<int> together = answers(batch, margin);
        for (std::size_t i = 0; i < batch.size(); ++i) {
            const int alone = answers({batch[i]}, margin)[0];
            BOOST_TEST(together[i] == alone);
            ++seen.at(static_cast<std::size_t>(alone));
        }
        batch.clear();
    }
    for (const int times : seen) BOOST_TEST(times > 300);
    BOOST_TEST(by_size.size() >= 9U);
}

BOOST_AUTO_TEST_CASE(where_no_direction_can_be_rejected_there_is_none) {
    int asked = 0;
    int certain = 0;
    int rejected = 0;
    int undecided = 0;
    for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
        BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            Fan fan(random_fan(random));
            if (seed % 2 == 0) fan.lower_slopes(random);
            if (fan.leaving.size() > polyhedra::FanBatch::most_faces) continue;
            const double margin = std::pow(10, random.uniform(-7, -1));
            const Vector middle = fan.mean_normal();
            const bool is_certain = answers({&fan}, margin)[0] != 0;
            ++asked;
            if (is_certain) ++certain;
            bool is_rejected = false;
            for (const std::vector<Corner>& edges : {fan.leaving, fan.arriving}) {
                std::vector<Vector> conditions;
                for (const Corner& edge : edges)
                    for (const bool above : {true, false}) conditions.push_back(fan.rejection(edge, above));
                const double best = greatest_least_product(conditions);
                is_rejected = is_rejected || best >= margin;
                if (!is_certain) continue;
                BOOST_TEST(best < margin);
                for (int i = 0; i < 2000; ++i) {
                    const Vec3 u = random.direction();
                    BOOST_REQUIRE(least_product(conditions, {u[0], u[1], u[2]}, best) <= std::max(best, 0.0) + 1e-12);
                }

                ConeSearch cone;
                cone.start(middle.norm() > 0.1 ? Vector(middle.normalized()) : Vector::UnitZ());
                bool is_found = true;
                for (std::size_t i = 0; i < conditions.size() && is_found; ++i)
                    is_found = cone.add(conditions[i] - (i % 2 == 0 ? margin : -margin) * 0.99 * middle);
                if (is_found && cone.is_undecided()) ++undecided;
                BOOST_TEST((!is_found || cone.is_undecided()));
            }
            if (is_rejected) ++rejected;
        }
    }
    BOOST_TEST_MESSAGE(certain << " certain and " << rejected << " rejected of " << asked << ", " << undecided
                               << " undecided");
    BOOST_TEST(3 * certain > 2 * (asked - rejected));
    BOOST_TEST(20 * rejected > asked);
    BOOST_TEST(100 * undecided <= certain);
}

BOOST_AUTO_TEST_SUITE_END()

}  // namespace
}  // namespace clsdf::test
