// How a segment crosses a face, against rational arithmetic with explicit moves.
#include "segments/walk.hpp"
#include "support/exact_distance.hpp"

#include <boost/test/unit_test.hpp>

#include <fmt/format.h>

#include <cmath>
#include <random>

using namespace clsdf;
using namespace clsdf::test;
using crossing::Corners;
using crossing::FaceCrossing;
using crossing::Segment;

namespace {

Rational determinant(const RationalPoint& u, const RationalPoint& v, const RationalPoint& w) {
    return dot(cross(u, v), w);
}

RationalPoint plus(const RationalPoint& a, const RationalPoint& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

/// By moves of the segment that are small beside all coordinates, which are multiples of `step`.
FaceCrossing moved_crossings(const Corners& face, const Vec3& from, const Vec3& to, double step, bool is_ray) {
    const RationalPoint a = rational(face[0]), b = rational(face[1]), c = rational(face[2]);
    const RationalPoint normal = cross(minus(b, a), minus(c, a));
    const Rational e = Rational(step) / (1 << 30) / (1 << 30);
    FaceCrossing result{0, 0};
    for (unsigned look = 0; look < 8; ++look) {
        const Rational unit = Rational(step);
        Rational x = e, y = e * (e / unit), z = e * (e / unit) * (e / unit);
        if ((look & 1U) != 0) x = -x;
        if ((look & 2U) != 0) y = -y;
        if ((look & 4U) != 0) z = -z;
        const RationalPoint p = plus(rational(from), {x, y, z});
        const RationalPoint q = is_ray ? RationalPoint{} : plus(rational(to), {x, y, z});
        const RationalPoint along = is_ray ? rational(to) : minus(q, p);
        const Rational before = dot(normal, minus(p, a));
        const Rational behind = is_ray ? dot(normal, along) : dot(normal, minus(q, a));
        if (normal == RationalPoint{} || dot(normal, along) == 0) continue;
        BOOST_REQUIRE(before != 0);
        if ((before > 0) == (behind > 0)) continue;
        const Rational turns[3]{determinant(along, minus(a, p), minus(b, p)),
                                determinant(along, minus(b, p), minus(c, p)),
                                determinant(along, minus(c, p), minus(a, p))};
        for (const Rational& turn : turns) BOOST_REQUIRE(turn != 0);
        if ((turns[0] > 0) != (turns[1] > 0) || (turns[0] > 0) != (turns[2] > 0)) continue;
        result.looks |= 1U << look;
        const int side = before > 0 ? 1 : -1;
        BOOST_REQUIRE(result.side == 0 || result.side == side);
        result.side = side;
    }
    return result;
}

Rational exact_place(const Corners& face, const Vec3& from, const Vec3& to, bool is_ray) {
    const RationalPoint a = rational(face[0]);
    const RationalPoint normal = cross(minus(rational(face[1]), a), minus(rational(face[2]), a));
    const RationalPoint along = is_ray ? rational(to) : minus(rational(to), rational(from));
    return dot(normal, minus(a, rational(from))) / dot(normal, along);
}

/// In ulp of the exact number.
double error_in_ulp(double computed, const Rational& exact) {
    if (exact == 0) return computed == 0 ? 0 : INFINITY;
    int exponent = 0;
    std::frexp(static_cast<double>(exact), &exponent);
    return std::abs(static_cast<double>((Rational(computed) - exact) / Rational(std::ldexp(1.0, exponent - 53))));
}

struct Kind {
    const char* name;
    double step;
    int most;      // coordinates are whole multiples of the step up to that
    double shift;  // of all
};

}  // namespace

BOOST_AUTO_TEST_CASE(crossings_are_those_of_small_moves) {
    constexpr Kind kinds[]{{"few whole numbers", 1, 1, 0}, {"whole numbers", 1, 4, 0},
                           {"many", 0x1p-20, 1 << 22, 0},  {"far away", 0x1p-20, 1 << 10, 1e6},
                           {"fine", 0x1p-40, 5, 3},        {"small", 0x1p-120, 2, 0}};
    const std::uint64_t seed = std::random_device()();
    BOOST_TEST_MESSAGE(fmt::format("seed {}", seed));
    std::mt19937_64 generator(seed);
    for (const Kind& kind : kinds) {
        std::uniform_int_distribution<int> number(-kind.most, kind.most);
        const auto point = [&] {
            const auto coordinate = [&] { return std::trunc(kind.shift) + kind.step * number(generator); };
            const double x = coordinate(), y = coordinate();
            return Vec3{x, y, coordinate()};
        };
        std::size_t crossed = 0, ties = 0, wrong = 0;
        double worst = 0;
        for (int i = 0; i < 3000; ++i) {
            const Corners face{point(), point(), point()};
            const Vec3 from = point();
            const bool is_ray = i % 2 != 0;
            Vec3 to = point();
            if (is_ray)
                for (double& x : to) x -= std::trunc(kind.shift);
            const Segment segment = is_ray ? crossing::ray(from, to) : crossing::segment(from, to);
            const FaceCrossing expected = moved_crossings(face, from, to, kind.step, is_ray);
            const FaceCrossing found = crossing::crossing_of(face, segment);
            if (expected.looks != found.looks || (found.looks != 0 && expected.side != found.side)) ++wrong;
            if (found.looks == 0) continue;
            ++crossed;
            ties += found.looks != CLSDF_ALL_LOOKS;
            worst =
                std::max(worst, error_in_ulp(crossing::place_of(face, segment), exact_place(face, from, to, is_ray)));
        }
        BOOST_TEST_MESSAGE(fmt::format("{}: {} crossed, {} of them with ties, place within {:.3f} ulp", kind.name,
                                       crossed, ties, worst));
        BOOST_TEST(wrong == 0U);
        BOOST_TEST(crossed > 30U);
        BOOST_TEST(worst <= 0.51);
    }
}

// Of faces that a segment meets at nearly the same place, or exactly at the same one.
BOOST_AUTO_TEST_CASE(faces_are_sorted_by_exact_places) {
    const std::uint64_t seed = std::random_device()();
    BOOST_TEST_MESSAGE(fmt::format("seed {}", seed));
    std::mt19937_64 generator(seed);
    std::uniform_int_distribution<int> number(-3, 3);
    const auto point = [&] {
        const double x = number(generator), y = number(generator);
        return Vec3{x, y, static_cast<double>(number(generator))};
    };
    std::size_t groups = 0, equal = 0;
    for (int i = 0; i < 300; ++i) {
        const Vec3 from = point(), to = point();
        const bool is_ray = i % 2 != 0;
        const Segment segment = is_ray ? crossing::ray(from, to) : crossing::segment(from, to);
        std::vector<segments::Crossed> crossed;
        for (std::uint32_t triangle = 0; triangle < 40; ++triangle) {
            Corners face{point(), point(), point()};
            if (triangle % 3 == 1) face[0][0] = std::nextafter(face[0][0], 9);
            const FaceCrossing of_face = crossing::crossing_of(face, segment);
            if (of_face.looks != 0)
                crossed.push_back({face, crossing::place_of(face, segment), triangle,
                                   static_cast<std::uint8_t>(of_face.looks), static_cast<std::int8_t>(of_face.side)});
        }
        segments::sort_by_place(segment, crossed);
        std::span<const segments::Crossed> left(crossed);
        Rational last = -1;
        while (!left.empty()) {
            const std::size_t count = segments::count_at_first_place(segment, left);
            const Rational place = exact_place(left[0].corners, from, to, is_ray);
            BOOST_TEST((last < place));
            for (std::size_t k = 0; k < count; ++k) {
                BOOST_TEST((exact_place(left[k].corners, from, to, is_ray) == place));
                if (k > 0) BOOST_TEST(left[k - 1].triangle < left[k].triangle);
            }
            ++groups;
            equal += count - 1;
            last = place;
            left = left.subspan(count);
        }
    }
    BOOST_TEST_MESSAGE(fmt::format("{} places, {} further faces at them", groups, equal));
    BOOST_TEST(groups > 100U);
    BOOST_TEST(equal > 10U);
}
