#include "frusta/one_lane.hpp"
#include "support/random_meshes.hpp"

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <limits>

namespace clsdf::test {
namespace {

using engine::Vector;
using engine::vectors_of;

/// one_lane::ConeSearch with memory of its own.
class ConeSearch {
public:
    struct State {
        std::uint32_t conditions;
        Vector direction;
        bool is_undecided;
    };

    void start(const Vector& first_guess) { return_to({0, first_guess, false}); }
    bool add(const Vector& condition) {
        if (conditions_.size() == search_.count) conditions_.emplace_back();
        search_.conditions = conditions_.data();
        return add_condition(&search_, vectors_of(condition));
    }
    Vector direction() const { return engine::to_vector(search_.direction); }
    bool is_undecided() const { return search_.is_undecided; }

    State state() const { return {search_.count, direction(), is_undecided()}; }
    void return_to(const State& state) {
        search_.count = state.conditions;
        search_.direction = vectors_of(state.direction);
        search_.is_undecided = state.is_undecided;
    }

private:
    std::vector<engine::one_lane::Vectors> conditions_;
    engine::one_lane::ConeSearch search_{};
};

Vector random_direction(Random& random) {
    const Vec3 v = random.direction();
    return {v[0], v[1], v[2]};
}

double least_product(const std::vector<Vector>& conditions, const Vector& u) {
    double least = std::numeric_limits<double>::infinity();
    for (const Vector& condition : conditions) least = std::min(least, condition.dot(u));
    return least;
}

/// The greatest, over all directions in which two conditions' planes meet, of the least product with a condition: 0
/// where there is a cone, negative if there is none.
double best_ray(const std::vector<Vector>& conditions) {
    double best = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < conditions.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            const Vector cross = conditions[i].cross(conditions[j]);
            if (cross.norm() < 1e-13) continue;
            const Vector ray = cross.normalized();
            best = std::max({best, least_product(conditions, ray), least_product(conditions, -ray)});
        }
    return best;
}

bool search(ConeSearch& cone, const std::vector<Vector>& conditions, const Vector& guess) {
    cone.start(guess);
    return std::all_of(conditions.begin(), conditions.end(), [&](const Vector& c) { return cone.add(c); });
}

BOOST_AUTO_TEST_SUITE(cone_search)

BOOST_AUTO_TEST_CASE(a_direction_is_found_where_there_is_one_and_only_there) {
    ConeSearch cone;
    int found = 0;
    int empty = 0;
    int undecided = 0;
    for (std::uint64_t seed = 1; seed <= 20000; ++seed) {
        BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            // Around a common direction, so that cones are thin as often as not.
            const Vector axis = random_direction(random);
            const double opening = std::pow(10, random.uniform(-5, 0.5));
            std::vector<Vector> conditions(3 + random.index(9));
            for (Vector& condition : conditions) {
                const Vector side = random_direction(random).cross(axis).normalized();
                condition = (side + opening * random.uniform(-0.3, 1) * axis).normalized();
            }
            // And nearly the same conditions again.
            for (int i = 0; i < 20; ++i) {
                const Vector condition = conditions[random.index(conditions.size())];
                const Vector change = std::pow(10, random.uniform(-17, -9)) * random_direction(random);
                conditions.emplace_back(condition + change);
            }
            const bool is_found = search(cone, conditions, random_direction(random));
            const double best = best_ray(conditions);
            if (is_found) {
                ++found;
                undecided += cone.is_undecided() ? 1 : 0;
                if (!cone.is_undecided()) BOOST_TEST(least_product(conditions, cone.direction()) > -1e-13);
                BOOST_TEST(best > -1e-8);
            } else {
                ++empty;
                BOOST_TEST(best < -1e-15);
            }
        }
    }
    BOOST_TEST(found > 2000);
    BOOST_TEST(empty > 2000);
    BOOST_TEST(undecided < 20);
}

BOOST_AUTO_TEST_CASE(conditions_that_hold_at_the_direction_found_leave_one) {
    ConeSearch cone;
    for (std::uint64_t seed = 1; seed <= 20000; ++seed) {
        BOOST_TEST_CONTEXT("seed " << seed) {
            Random random(seed);
            const Vector axis = random_direction(random);
            const double opening = std::pow(10, random.uniform(-8, 0));
            std::vector<Vector> conditions(3 + random.index(9));
            for (Vector& condition : conditions)
                condition = (random_direction(random).cross(axis).normalized() + opening * axis).normalized();
            if (!search(cone, conditions, random_direction(random))) continue;
            for (int i = 0; i < 10; ++i) {
                const Vector turn = random_direction(random).cross(cone.direction());
                const Vector condition = conditions[random.index(conditions.size())];
                BOOST_TEST(cone.add(condition + std::pow(10, random.uniform(-15, -9)) * turn));
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(cones_without_thickness_are_found) {
    ConeSearch cone;
    const Vector x = Vector::UnitX();
    const Vector y = Vector::UnitY();
    const Vector z = Vector::UnitZ();
    for (const Vector& guess : {x, y, z, Vector(-x), Vector(-y), Vector(-z), Vector((x + y + z).normalized())}) {
        BOOST_TEST(search(cone, {x, -x, y}, guess));        // half a plane
        BOOST_TEST(search(cone, {x, y, -(x + y)}, guess));  // a line
        BOOST_TEST(search(cone, {x, -x, y, -y, z}, guess));
        BOOST_TEST(!search(cone, {x, y, z, -(x + y + z)}, guess));
    }
}

BOOST_AUTO_TEST_CASE(a_search_returns_to_where_it_was) {
    ConeSearch cone;
    const Vector x = Vector::UnitX();
    const Vector y = Vector::UnitY();
    const Vector z = Vector::UnitZ();
    BOOST_TEST(search(cone, {x, y, z}, -x));
    const ConeSearch::State state = cone.state();
    BOOST_TEST(!cone.add(-(x + y + z)));
    cone.return_to(state);
    BOOST_TEST(cone.add(z - x));
    BOOST_TEST(cone.add(z - y));
    BOOST_TEST(cone.direction().minCoeff() > -1e-13);
    BOOST_TEST(cone.direction().z() >= cone.direction().maxCoeff() - 1e-13);
}

BOOST_AUTO_TEST_SUITE_END()

}  // namespace
}  // namespace clsdf::test
