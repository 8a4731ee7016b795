// Signs by expansions, on the host and on the device, against those of CGAL and of integers.
#include "support/device_memory.hpp"
#include "support/exact_field.hpp"

#include "launch/commands.hpp"
#include "launch/programs.hpp"
#include "mesh/expansions.hpp"
#include "mesh/predicates.hpp"
#include "surface/ray_side.hpp"

#include <boost/multiprecision/cpp_int.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

using Points = std::array<Vec3, 4>;  // a face and a point

enum Answer : std::size_t { in_space, in_plane, displaced, of_edges, forward, backward, on_face, on_segment, answers };
using Answers = std::array<std::int8_t, answers>;

constexpr device::KernelFile kernel_file{"signs_of_cases.cl", R"(
#include "ray_side.h"

__kernel void signs_of_cases(uint count, __global const double* points, __global char* answers) {
    const uint i = (uint)get_global_id(0);
    if (i >= count) return;
    const double3 a = vload3(4 * i, points), b = vload3(4 * i + 1, points), c = vload3(4 * i + 2, points),
                  p = vload3(4 * i + 3, points);
    __global char* own = answers + 8 * i;
    own[0] = orientation_in_space(a, b, c, p);
    own[1] = orientation_in_plane(a.x, a.y, b.x, b.y, p.x, p.y);
    own[2] = displaced_side(a, b, p);
    own[3] = side_of_edges(a, b, c, p);
    own[4] = crossing_of_ray(a, b, c, p, true);
    own[5] = crossing_of_ray(a, b, c, p, false);
    own[6] = is_on_face(a, b, c, p);
    own[7] = is_on_segment(a, b, p);
}
)"};

std::vector<Answers> by_device(const std::vector<Points>& cases) {
    device::Context& context = device::context_of(test_device());
    const engine::Programs programs(context, KernelBody::by_group);
    const std::array files{kernel_file};
    device::LentKernel kernel(context.kernels(),
                              context.program({std::string(kernel_file.name), programs.common_options(1), files}),
                              "signs_of_cases");
    const cl::Buffer points(context.context(), CL_MEM_READ_ONLY, cases.size() * sizeof(Points)),
        found(context.context(), CL_MEM_READ_WRITE, cases.size() * sizeof(Answers));
    context.queue().enqueueWriteBuffer(points, CL_TRUE, 0, cases.size() * sizeof(Points), cases.data());
    engine::launch(context.queue(), kernel, {cases.size()}, static_cast<cl_uint>(cases.size()), points, found);
    return read<Answers>(context, found, cases.size());
}

Answers by_host(const Points& points) {
    using namespace expansions;
    const double3 a = vector(points[0]), b = vector(points[1]), c = vector(points[2]), p = vector(points[3]);
    const std::array<int, answers> found{orientation_in_space(a, b, c, p),
                                         orientation_in_plane(a.x, a.y, b.x, b.y, p.x, p.y),
                                         expansions::displaced_side(a, b, p),
                                         expansions::side_of_edges(a, b, c, p),
                                         crossing_of_ray(a, b, c, p, true),
                                         crossing_of_ray(a, b, c, p, false),
                                         is_on_face(a, b, c, p),
                                         is_on_segment(a, b, p)};
    Answers result;
    std::ranges::transform(found, result.begin(), [](int x) { return static_cast<std::int8_t>(x); });
    return result;
}

bool is_between(const Vec3& a, const Vec3& b, const Vec3& p) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (p[axis] < std::min(a[axis], b[axis]) || p[axis] > std::max(a[axis], b[axis])) return false;
    return are_collinear(a, b, p);
}

bool is_on(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
    if (orientation(a, b, c, p) != 0) return false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t first = (axis + 1) % 3, second = (axis + 2) % 3;
        const int turn = side_of_line(a, b, c, first, second);
        if (turn == 0) continue;
        return turn * side_of_line(a, b, p, first, second) >= 0 && turn * side_of_line(b, c, p, first, second) >= 0 &&
               turn * side_of_line(c, a, p, first, second) >= 0;
    }
    return is_between(a, b, p) || is_between(b, c, p) || is_between(c, a, p);
}

/// By CGAL.
Answers expected(const Points& points) {
    const auto& [a, b, c, p] = points;
    const int side = side_of_edges(a, b, c, p), front = orientation(a, b, c, p);
    const std::array<int, answers> found{front,
                                         side_of_line(a, b, p, 0, 1),
                                         displaced_side(a, b, p),
                                         side,
                                         front == side ? 0 : side,
                                         front == side ? -side : 0,
                                         is_on(a, b, c, p),
                                         is_between(a, b, p)};
    Answers result;
    std::ranges::transform(found, result.begin(), [](int x) { return static_cast<std::int8_t>(x); });
    return result;
}

using Integer = boost::multiprecision::cpp_int;

/// In units of 2^-352.
Integer integer(double x) {
    int exponent = 0;
    const double fraction = std::frexp(x, &exponent);
    const Integer digits(static_cast<long long>(std::ldexp(fraction, 53)));
    return x == 0 ? Integer(0) : Integer(digits << (exponent - 53 + 352));
}

int orientation_by_integers(const Points& points) {
    std::array<std::array<Integer, 3>, 3> rows;
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t axis = 0; axis < 3; ++axis)
            rows[row][axis] = integer(points[row + 1][axis]) - integer(points[0][axis]);
    const auto& [u, v, w] = rows;
    const Integer determinant =
        u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) + u[2] * (v[0] * w[1] - v[1] * w[0]);
    return determinant.sign();
}

using Random = std::mt19937_64;

double between(double lower, double upper, Random& random) {
    return std::uniform_real_distribution(lower, upper)(random);
}
int whole(int lower, int upper, Random& random) {
    return std::uniform_int_distribution(lower, upper)(random);
}

Points made(const std::function<double(std::size_t)>& coordinate) {
    Points points;
    for (Vec3& p : points)
        for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = coordinate(axis);
    return points;
}

Points anywhere(Random& random) {
    return made([&](std::size_t) { return between(-1, 1, random); });
}

/// Multiples of a length that is no power of two: nearly all are degenerate, exactly or up to rounding.
Points on_grid(Random& random) {
    const double spacing = whole(0, 1, random) == 0 ? 1 : 0.1;
    return made([&](std::size_t) { return whole(-2, 2, random) * spacing; });
}

/// The last point is that of the plane, of an edge or of its line, up to rounding and an ulp.
Points nearly_degenerate(Random& random) {
    Points points = anywhere(random);
    if (whole(0, 3, random) == 0) points[2] = points[whole(0, 1, random) == 0 ? 0 : 1];
    const double offset = std::ldexp(1.0, whole(0, 40, random));
    const double s = between(-0.5, 1.5, random), t = whole(0, 2, random) == 0 ? 0 : between(-0.5, 1, random);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t i = 0; i < 3; ++i) points[i][axis] += offset;
        const double a = points[0][axis];
        points[3][axis] = a + s * (points[1][axis] - a) + t * (points[2][axis] - a);
        const int ulp = whole(-1, 1, random);
        if (ulp != 0) points[3][axis] = std::nextafter(points[3][axis], ulp * 2 * offset);
    }
    return points;
}

/// Any exponent of the range, its ends included; zeros, and numbers that differ in the last bit.
Points of_any_size(Random& random) {
    return made([&](std::size_t) {
        const int kind = whole(0, 9, random);
        if (kind == 0) return 0.0;
        const double sign = whole(0, 1, random) == 0 ? 1 : -1;
        if (kind == 1) return sign * GREATEST_EXACT_COORDINATE;
        if (kind == 2) return sign * std::nextafter(GREATEST_EXACT_COORDINATE, 0);
        if (kind == 3) return sign * LEAST_EXACT_COORDINATE;
        if (kind == 4) return sign * std::nextafter(LEAST_EXACT_COORDINATE, 1);
        return sign * std::ldexp(between(1, 2, random), whole(-300, 299, random));
    });
}

/// As nearly_degenerate, each axis in a scale of its own.
Points stretched(Random& random) {
    Points points = nearly_degenerate(random);
    std::array<int, 3> scale;
    for (int& exponent : scale) exponent = whole(-200, 250, random);
    for (Vec3& p : points)
        for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = std::ldexp(p[axis], scale[axis]);
    return points;
}

/// The volume of four points near the least numbers: products are denormal.
Points tiny(Random& random) {
    Points points = whole(0, 1, random) == 0 ? on_grid(random) : nearly_degenerate(random);
    for (Vec3& p : points)
        for (double& x : p) {
            x = std::ldexp(x, -297);
            if (!expansions::is_in_exact_range(x)) x = 0;
        }
    return points;
}

struct Family {
    const char* name;
    Points (*make)(Random&);
};
constexpr std::array<Family, 6> families{{{"anywhere", anywhere},
                                          {"on a grid", on_grid},
                                          {"nearly degenerate", nearly_degenerate},
                                          {"of any size", of_any_size},
                                          {"stretched", stretched},
                                          {"tiny", tiny}}};

std::vector<Points> cases_of(const Family& family, std::size_t count, Random& random) {
    std::vector<Points> cases(count);
    std::ranges::generate(cases, [&] { return family.make(random); });
    for (const Points& points : cases) BOOST_REQUIRE(expansions::are_exact(points));
    return cases;
}

void check_equal(Answers found, const Answers& wanted, std::size_t number) {
    if (wanted[on_face] != 0) found[forward] = wanted[forward], found[backward] = wanted[backward];  // has no promise
    BOOST_TEST(found == wanted, "case " << number);
}

constexpr std::size_t count = 20'000;

}  // namespace

BOOST_AUTO_TEST_CASE(signs_on_the_host_are_exact) {
    const unsigned seed = std::random_device()();
    Random random(seed);
    for (const Family& family : families) BOOST_TEST_CONTEXT("seed " << seed << ", points " << family.name) {
            const std::vector<Points> cases = cases_of(family, count, random);
            for (std::size_t i = 0; i < count; ++i) {
                const Answers found = by_host(cases[i]);
                check_equal(found, expected(cases[i]), i);
                BOOST_TEST(found[in_space] == orientation_by_integers(cases[i]), "case " << i);
            }
        }
}

BOOST_AUTO_TEST_CASE(signs_on_the_device_are_exact) {
    const unsigned seed = std::random_device()();
    Random random(seed);
    for (const Family& family : families) BOOST_TEST_CONTEXT("seed " << seed << ", points " << family.name) {
            const std::vector<Points> cases = cases_of(family, count, random);
            const std::vector<Answers> found = by_device(cases);
            for (std::size_t i = 0; i < count; ++i) check_equal(found[i], expected(cases[i]), i);
        }
}

BOOST_AUTO_TEST_CASE(the_range_is_told) {
    const std::array<double, 5> within{0, -0.0, -1, 0x1p300, -0x1p-300};
    const std::array<double, 5> outside{0x1.0000000000001p300, -0x1.fffffffffffffp-301, 5e-324, INFINITY, NAN};
    for (const double x : within) BOOST_TEST(expansions::are_exact({{Vec3{1, 1, x}, Vec3{x, 1, 1}}}), x);
    for (const double x : outside) BOOST_TEST(!expansions::are_exact({{Vec3{1, 1, 1}, Vec3{1, x, 1}}}), x);
}

// So an expansion has room for another product of three numbers.
BOOST_AUTO_TEST_CASE(a_sum_without_gaps_has_at_most_40_doubles) {
    const unsigned seed = std::random_device()();
    Random random(seed);
    BOOST_TEST_CONTEXT("seed " << seed)
    for (int run = 0; run < 500; ++run) {
        expansions::Expansion expansion{};
        Integer sum = 0;  // in units of 2^-1074
        const int gap = whole(2, 28, random);
        for (int i = 0; i < EXPANSION_DOUBLES; ++i) {
            expansion.doubles[i] = std::ldexp(1.0, gap * i - 1074);
            sum += Integer(1) << (gap * i);
        }
        expansion.count = EXPANSION_DOUBLES;
        for (int round = 0; round < 6; ++round) {
            expansions::close_gaps(&expansion);
            BOOST_TEST(expansion.count <= EXPANSION_DOUBLES - PRODUCT_DOUBLES);
            for (int i = 0; i < PRODUCT_DOUBLES; ++i) {
                const int bits = whole(0, 1, random) == 0 ? 1 : 53;
                const Integer digits(whole(-1, 1, random) * (std::int64_t{1} << (bits - 1)) + whole(0, 1, random));
                const int exponent = whole(0, 2000, random);
                sum += digits << exponent;
                expansions::add_double(&expansion, std::ldexp(digits.convert_to<double>(), exponent - 1074));
            }
            BOOST_REQUIRE(expansion.count <= EXPANSION_DOUBLES);
        }
        for (std::uint32_t i = 0; i < expansion.count; ++i) {
            int exponent = 0;
            const double fraction = std::frexp(expansion.doubles[i], &exponent);
            const Integer digits(static_cast<long long>(std::ldexp(fraction, 53)));
            const int shift = exponent - 53 + 1074;
            sum -= shift >= 0 ? Integer(digits << shift) : Integer(digits >> -shift);
        }
        BOOST_TEST(sum == 0);
    }
}
