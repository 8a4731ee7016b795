#include "support/device_memory.hpp"
#include "support/exact_distance.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/test_meshes.hpp"
#include "support/throws.hpp"

#include <clsdf/papers.hpp>
#include <clsdf/tuning.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <span>
#include <vector>

// A target of doubles gets the distance to the closest point as double precision gives it. The band, the sign and, on
// grids, the choice among nearly equally near triangles are those of floats.

using namespace clsdf;
using namespace clsdf::test;

namespace {

// The error, relative to the largest coordinate of the mesh and of the sample or point.
constexpr double bound = 1e-15;

/// The largest errors that a test has seen, and how often a double is not a float.
struct Errors {
    double largest = 0;
    std::size_t compared = 0, beyond = 0, finer = 0, farther = 0;

    ~Errors() {
        BOOST_TEST_MESSAGE(compared << " doubles in the band, error " << largest << " of the largest coordinate, "
                                    << finer << " with more digits than a float, " << farther
                                    << " of another triangle than the nearest; " << beyond << " beyond the band");
    }
};

double largest_coordinate(const Vec3& p) {
    return std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
}

/// Holds doubles of a mesh against exact arithmetic.
class Judge {
public:
    /// allowance: by which another triangle than the nearest one may be farther.
    Judge(const Mesh& mesh, const Band& band, double allowance, Errors& errors)
        : mesh_(mesh), band_(band), oracle_(mesh), allowance_(allowance), errors_(errors) {}

    /// floats: the same sample or point with its triangle and site.
    void check(const Vec3& position, double distance, const Field& floats, std::size_t at) {
        const float in_float = floats.distance()[at];
        const std::uint32_t triangle = floats.triangle()[at];
        const bool negative = std::signbit(in_float);
        const double limit = negative ? band_.inside : band_.outside;
        if (triangle == no_triangle) {
            ++errors_.beyond;
            const double expected = negative ? -limit : limit;
            BOOST_REQUIRE(std::bit_cast<std::uint64_t>(distance) == std::bit_cast<std::uint64_t>(expected));
            return;
        }
        const double exact = std::min(distance_to_site(position, triangle, floats.site()[at]), limit);
        const double scale = std::max({largest_coordinate(position), largest_coordinate(mesh_.box().lower),
                                       largest_coordinate(mesh_.box().upper)});
        const double error = std::abs(std::abs(distance) - exact) / scale;
        ++errors_.compared;
        errors_.largest = std::max(errors_.largest, error);
        errors_.finer += distance != static_cast<double>(static_cast<float>(distance)) ? 1U : 0U;
        BOOST_REQUIRE_MESSAGE(error <= bound, "the distance " << distance << " instead of " << exact << ", error "
                                                              << error << " of the largest coordinate");
        if (distance != 0 && in_float != 0) BOOST_REQUIRE(std::signbit(distance) == negative);
        if (distance == 0) BOOST_REQUIRE(!std::signbit(distance));
        const double nearest = std::min(oracle_.nearest(position).distance, limit);
        const double farther = std::abs(distance) - nearest - 2 * bound * scale;
        errors_.farther += farther > 0 ? 1U : 0U;
        BOOST_REQUIRE(farther <= allowance_);
    }

private:
    double distance_to_site(const Vec3& position, std::uint32_t triangle, std::uint8_t site) const {
        const Triangle& t = mesh_.triangles()[triangle];
        const auto corner = [&](std::size_t k) { return mesh_.vertices()[t[k % 3]]; };
        const std::size_t first = site == 6 ? 0U : site % 3U;
        const std::size_t second = site < 3 ? first : first + 1, third = site < 6 ? second : first + 2;
        return static_cast<double>(exact_distance(position, corner(first), corner(second), corner(third)));
    }

    const Mesh& mesh_;
    Band band_;
    reference::Oracle oracle_;
    double allowance_;
    Errors& errors_;
};

/// The distances in double alone.
std::vector<double> doubles(const DistanceTransform& transform, const Grid& grid, const Band& band) {
    std::vector<double> values(grid.sample_count(), 7);
    transform.compute(grid, band, values);
    return values;
}

/// Samples of a field by both kernel bodies; `every`: only every so many.
void check_field(const Mesh& mesh, const Grid& grid, const Band& band, Errors& errors, std::size_t every = 1,
                 SignRule sign = SignRule::nonzero) {
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group})
        BOOST_TEST_CONTEXT(mesh.name() << (body == KernelBody::by_vector ? ", by vector" : ", by group")) {
            const DistanceTransform transform(test_device(), mesh, {.sign = sign, .body = body});
            const Field field = transform.compute(grid, band, Output::triangle | Output::site);
            const std::vector<double> values = doubles(transform, grid, band);
            const std::vector<Vec3> positions = samples_of(grid);
            Judge judge(mesh, band, guaranteed.voxels * grid.voxel(), errors);
            for (std::size_t i = 0; i < values.size(); i += every) judge.check(positions[i], values[i], field, i);
        }
}

Grid stretched(Grid grid, const Vec3& factors) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        grid.spacing[axis] *= factors[axis];
        grid.size[axis] = static_cast<std::int64_t>(static_cast<double>(grid.size[axis]) / factors[axis]) + 1;
    }
    return grid;
}

/// Distances in double of the noisy sphere, as host memory gets them; the tests of memory compare with them.
struct Example {
    Mesh mesh = tilted(make_shape("noisy"));
    Grid grid = grid_around(mesh, 30, 4);
    Band band{0, 3 * grid.voxel()};  // -0.0 inside
    DistanceTransform transform{test_device(), mesh};
    std::vector<double> expected = doubles(transform, grid, band);
    std::size_t count = grid.sample_count();

    bool is_expected(std::span<const double> values) const {
        for (std::size_t i = 0; i < count; ++i)
            if (std::bit_cast<std::uint64_t>(values[i]) != std::bit_cast<std::uint64_t>(expected[i])) return false;
        return true;
    }
    /// `step` doubles from sample to sample.
    OutputArray spread(OutputArray target, std::ptrdiff_t step) const {
        const std::ptrdiff_t stride = step * static_cast<std::ptrdiff_t>(sizeof(double));
        target.strides = {stride, stride * grid.size[0], stride * grid.size[0] * grid.size[1]};
        return target;
    }
};

OutputArray doubles_in(const DeviceMemory& memory) {
    return {memory.handle(), ElementType::float64};
}

std::vector<double> contents_of(const DeviceMemory& memory) {
    const std::vector<std::uint32_t> words = memory.read(device::context_of(test_device()).queue());
    std::vector<double> values(words.size() / 2);
    std::memcpy(values.data(), words.data(), values.size() * sizeof(double));
    return values;
}

}  // namespace

BOOST_AUTO_TEST_CASE(random_meshes_have_the_distance_of_double_precision) {
    Errors errors;
    Random random(23);
    for (int i = 0; i < 4; ++i) {
        const Mesh closed = random_closed(random, 3);
        check_field(closed, grid_around(closed, 18, 3), Band{0.3, 0.6}, errors, 3);
        const Mesh soup = random_soup(random, 30, 20);
        check_field(soup, grid_around(soup, 18, 3), Band{0, 0.4}, errors, 3, SignRule::none);
    }
    BOOST_TEST(errors.finer > errors.compared * 9 / 10);
    BOOST_TEST(errors.compared > 5000U);
    BOOST_TEST(errors.farther < errors.compared / 100);
    BOOST_TEST(errors.beyond > 10000U);
}

// Slivers, segments and points.
BOOST_AUTO_TEST_CASE(triangles_without_area_have_the_distance_of_double_precision) {
    Errors errors;
    Random random(29);
    for (int i = 0; i < 4; ++i) {
        const Mesh mesh = random_slivers(random, 40);
        check_field(mesh, grid_around(mesh, 18, 3), Band::symmetric(0.4), errors, 3, SignRule::none);
    }
    check_field(sliver(), grid_around(sliver(), 24, 4), Band::full(), errors, 3, SignRule::none);
    BOOST_TEST(errors.compared > 5000U);
    BOOST_TEST(errors.farther < errors.compared / 100);
}

BOOST_AUTO_TEST_CASE(unequal_spacings_and_distant_meshes_have_the_distance_of_double_precision) {
    Errors errors;
    Random random(31);
    const Mesh mesh = random_closed(random, 3);
    const Grid grid = grid_around(mesh, 20, 3);
    for (const Vec3& factors : {Vec3{1, 1, 2.7}, Vec3{3.3, 1, 1}, Vec3{1, 0.4, 2}})
        check_field(mesh, stretched(grid, factors), Band::symmetric(1), errors, 3);
    for (const double away : {30.0, 1e6, 1e9}) {
        const Mesh far = shifted(mesh, {away, -0.7 * away, 0.3 * away});
        check_field(far, grid_around(far, 18, 3), Band::symmetric(1), errors, 3);
    }
    BOOST_TEST(errors.compared > 5000U);
    BOOST_TEST(errors.farther < errors.compared / 100);
}

// The band is open at one side, or at both, and large triangles are near small ones.
BOOST_AUTO_TEST_CASE(wide_bands_have_the_distance_of_double_precision) {
    Errors errors;
    for (const char* shape : {"noisy", "knot", "cube"}) {
        const Mesh mesh = tilted(make_shape(shape));
        const Grid grid = grid_around(mesh, 20, 3);
        check_field(mesh, grid, Band::full(), errors, 7);
        check_field(mesh, grid, Band{2 * grid.voxel(), std::numeric_limits<double>::infinity()}, errors, 7);
    }
    BOOST_TEST(errors.compared > 5000U);
    BOOST_TEST(errors.farther < errors.compared / 100);
}

// Samples on faces, edges and vertices.
BOOST_AUTO_TEST_CASE(samples_on_the_surface_have_a_positive_zero) {
    const Mesh mesh = cube(1);
    const Grid grid = grid_at({0, 0, 0}, 0.25, 6);
    const Band band = Band::symmetric(0.5);
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group}) {
        const DistanceTransform transform(test_device(), mesh, {.body = body});
        const std::vector<double> values = doubles(transform, grid, band);
        const std::vector<Vec3> positions = samples_of(grid);
        std::vector<double> at_points(positions.size());
        transform.query(positions, 0.5, at_points);
        std::size_t on_surface = 0;
        for (std::size_t i = 0; i < values.size(); ++i) {
            const Vec3& p = positions[i];
            if (largest_coordinate(p) != 1) continue;
            ++on_surface;
            BOOST_REQUIRE(std::bit_cast<std::uint64_t>(values[i]) == 0U);
            BOOST_REQUIRE(std::bit_cast<std::uint64_t>(at_points[i]) == 0U);
        }
        BOOST_TEST(on_surface == 386U);
    }
    const std::vector<double> signs = doubles(DistanceTransform(test_device(), mesh), grid, Band::signs_only());
    const Field floats = DistanceTransform(test_device(), mesh).compute(grid, Band::signs_only());
    for (std::size_t i = 0; i < signs.size(); ++i) {
        BOOST_REQUIRE(signs[i] == 0);
        BOOST_REQUIRE(std::signbit(signs[i]) == std::signbit(floats.distance()[i]));
    }
}

// Of points that search the tree, and of many, which are scanned; the limit is the caller's double.
BOOST_AUTO_TEST_CASE(points_have_the_distance_of_double_precision) {
    Errors errors;
    Random random(37);
    for (const double away : {0.0, 1e6}) {
        for (Mesh mesh : {random_closed(random, 4), random_soup(random, 30, 20), random_slivers(random, 40)}) {
            if (away > 0) mesh = shifted(mesh, {away, -0.7 * away, 0.3 * away});
            const Vec3 lower = mesh.box().lower, extent = mesh.box().extent();
            for (const std::size_t count : {std::size_t{500}, std::size_t{17000}}) {
                std::vector<Vec3> points(count);
                for (Vec3& p : points)
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        p[axis] = lower[axis] + random.uniform(-0.2, 1.2) * extent[axis];
                const DistanceTransform transform(test_device(), mesh);
                for (const double limit : {0.3, std::numeric_limits<double>::infinity()}) {
                    const Field field = query(transform, points, limit);
                    std::vector<double> values(count), spread(2 * count, 7);
                    transform.query(points, limit, values);
                    OutputArray target(spread);
                    target.strides = {2 * sizeof(double), 0, 0};
                    transform.query(points, limit, target);
                    for (std::size_t i = 0; i < count; ++i) {
                        BOOST_REQUIRE(spread[2 * i] == values[i]);
                        BOOST_REQUIRE(spread[2 * i + 1] == 7);
                    }
                    Judge judge(mesh, Band::symmetric(limit), 0, errors);
                    for (std::size_t i = 0; i < count; i += count / 500) judge.check(points[i], values[i], field, i);
                    const DeviceMemory memory(test_device().context(), 2 * count);
                    transform.query(points, limit, doubles_in(memory));
                    BOOST_TEST((contents_of(memory) == values));
                }
            }
        }
    }
    BOOST_TEST(errors.finer > errors.compared * 9 / 10);
    BOOST_TEST(errors.compared > 5000U);
    BOOST_TEST(errors.beyond > 500U);
}

// Doubles round to the floats, but for a few, whose float has its own rounding; and other outputs change nothing.
BOOST_AUTO_TEST_CASE(floats_and_doubles_agree) {
    const Example example;
    const Field field = example.transform.compute(example.grid, example.band, all_outputs());
    std::vector<double> distance(example.count);
    OutputTargets targets = Field(field).targets();
    Field beside(field, field.outputs());
    targets = beside.targets();
    targets[Output::distance] = OutputArray(distance);
    example.transform.compute(example.grid, example.band, targets);
    BOOST_TEST(example.is_expected(distance));
    for (const OutputInfo& info : output_table())
        if (info.output != Output::distance) BOOST_TEST(same_bytes(field.slab(), beside.slab(), info.output));
    for (std::size_t i = 0; i < example.count; ++i)
        BOOST_REQUIRE(std::abs(distance[i] - static_cast<double>(field.distance()[i])) <= 1e-5 * example.grid.voxel());
    BOOST_TEST(
        (bits_of(example.transform.compute(example.grid, example.band).distance()) == bits_of(field.distance())));
}

BOOST_AUTO_TEST_CASE(plans_write_doubles_if_they_were_made_for_doubles) {
    const Example example;
    const DeviceMemory memory(test_device().context(), 2 * example.count),
        larger(test_device().context(), 4 * example.count);
    for (const OutputArray& target : {doubles_in(memory), example.spread(doubles_in(larger), 2)}) {
        Plan plan = example.transform.plan({example.grid, example.band, target});
        check_throws(ErrorCode::unsupported, {"output distance", "floats", "make the plan of a request"},
                     [&] { plan.enqueue(nullptr, OutputArray(larger.handle())); });
    }
    Plan floats = example.transform.plan(example.grid, example.band);
    check_throws(ErrorCode::unsupported, {"output distance", "doubles", "make the plan of a request"},
                 [&] { floats.enqueue(nullptr, doubles_in(memory)); });
    Plan with_gradients = example.transform.plan(example.grid, example.band, Output::gradient);
    const DeviceMemory gradients(test_device().context(), 3 * example.count);
    check_throws(ErrorCode::unsupported, {"output distance", "doubles"}, [&] {
        with_gradients.enqueue(nullptr,
                               {{Output::distance, doubles_in(memory)}, {Output::gradient, gradients.handle()}});
    });
}

BOOST_AUTO_TEST_CASE(scans_without_finishing_refuse_doubles) {
    const Mesh mesh = make_shape("sphere2");
    const Grid grid = grid_around(mesh, 20, 3);
    const Band band = Band::symmetric(2 * grid.voxel());
    for (const Scan scan : {Scan::slices, Scan::brute_force}) {
        const DistanceTransform transform = make_transform(test_device(), mesh, {.scan = scan});
        std::vector<double> values(grid.sample_count());
        check_throws(ErrorCode::unsupported, {"double"}, [&] { transform.compute(grid, band, values); });
        std::vector<float> floats(grid.sample_count());
        transform.compute(grid, band, floats);
    }
}
