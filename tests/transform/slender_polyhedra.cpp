#include "device/context.hpp"
#include "polyhedra/records.hpp"
#include "prepare/layout_of.hpp"
#include "support/random_meshes.hpp"

#include <clsdf/device.hpp>

#include <fmt/format.h>
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

// The scan of slender polyhedra alone, with polyhedra that no mesh need have: whether every sample within one of them
// gets the distance to its triangle, and whether none far outside of all gets any.

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

constexpr const char* scan_alone = R"(
__kernel void scan_alone(Layout layout, int x, int y, int z, uint count, __global const uint* entries, float bound,
                         __global const Polyhedron* polyhedra, __global Minimum* minima, __global uint* others,
                         __global uint* other_count, __global float* squared, __global uint* nearest) {
    for (uint b = 0; b < 64; ++b) clear_minimum(minima + b);
    const float slack = bound * layout.slack_rate + layout.brick_slack;
    *other_count =
        scan_slender_polyhedra(layout, (int3)(x, y, z), count, entries, bound, slack, polyhedra, minima, others, 0);
    for (uint b = 0; b < 64; ++b) {
        const int3 brick = brick_of_coarse((int3)(0, 0, 0), b) * CLSDF_BRICK;
        for (uint row = 0; row < 64; ++row) {
            const size_t at = ((size_t)(brick.z + row / 8) * 32 + brick.y + row % 8) * 32 + brick.x;
            vstore8(as_float8(squares_of_row(minima + b, row % 8, row / 8)), 0, squared + at);
#ifdef NEAREST
            vstore8(polyhedra_of_row(minima + b, row % 8, row / 8), 0, nearest + at);
#endif
        }
    }
}
)";

/// The position of a sample in a polyhedron's frame, in double.
struct Position {
    double squared_distance;
    double outside;  ///< how far it lies beyond the polyhedron, without slack, at most; 0 within
    bool is_within;  ///< with the slack of docs/method.md, 'Rounding and slack'
};

Position position_in(const Polyhedron& p, double i, double j, double k, double bound, double slack) {
    const auto coordinate = [&](int n) {
        return p.exact_gradient_x[n] * (i - p.origin_x) + p.exact_gradient_y[n] * (j - p.origin_y) +
               p.exact_gradient_z[n] * (k - p.origin_z) + p.exact_constant_at_origin[n];
    };
    const double x = coordinate(0), y = coordinate(1), z = coordinate(2);
    const std::size_t half = x < 0 ? CLSDF_HALF_LEFT : CLSDF_HALF_RIGHT;
    const double away = std::abs(x);
    const auto outward = [&](std::size_t side, double from_altitude) {
        return p.exact_normal_along[side] * (from_altitude - p.exact_base[side]) + p.exact_normal_across[side] * y;
    };
    const double along = p.exact_normal_along[half], across = p.exact_normal_across[half];
    const double beyond = away - p.exact_base[half];
    const double r = y < 0 ? -y : outward(half, away);
    const double t =
        y < 0 ? beyond : std::max(across * beyond - along * y, along * (y - p.exact_altitude) - across * away);
    const std::array outward_of_edges{-y, outward(CLSDF_HALF_RIGHT, x), outward(CLSDF_HALF_LEFT, -x)};
    const double height = std::abs(z);
    double outside = std::max(height - bound, 0.0);
    bool is_within = height <= bound + slack;
    for (std::size_t edge = 0; edge < 3; ++edge) {
        const double above = static_cast<double>(p.slope_above[edge]), below = static_cast<double>(p.slope_below[edge]);
        outside = std::max(outside, outward_of_edges[edge] - (z < 0 ? below : above) * height);
        is_within &= outward_of_edges[edge] <= std::max(above * (z + slack), below * (slack - z)) + slack;
    }
    return {std::pow(std::max(r, 0.0), 2) + std::pow(std::max(t, 0.0), 2) + z * z, outside, is_within};
}

/// Triangles of `size` units in and around the coarse brick; every eighth in a plane of samples.
std::vector<Polyhedron> random_polyhedra(Random& random, const polyhedra::LatticeView& lattice, const Vec3& first,
                                         double size, double steepest, std::size_t count) {
    std::vector<Polyhedron> result;
    while (result.size() < count) {
        Vec3 centre = first;
        for (std::size_t axis = 0; axis < 3; ++axis)
            centre[axis] += lattice.spacing_in_units[axis] * random.uniform(-0.6, 1.6) * CLSDF_COARSE;
        std::array<Vec3, 3> corners;
        const bool is_flat = result.size() % 8 == 0;
        for (Vec3& corner : corners) {
            corner = along(centre, size * random.uniform(0.3, 1), random.direction());
            if (is_flat) corner[2] = std::round(centre[2] / lattice.spacing_in_units[2]) * lattice.spacing_in_units[2];
        }
        const polyhedra::TriangleFrame frame = polyhedra::triangle_frame(corners, lattice);
        polyhedra::FaceSlopes slopes{};
        for (std::size_t edge = 0; edge < 3; ++edge) {
            slopes.above[edge] = static_cast<float>(random.uniform(0, steepest));
            slopes.below[edge] = static_cast<float>(random.uniform(0, steepest));
        }
        result.push_back(
            polyhedra::pack(frame, slopes, static_cast<std::uint32_t>(result.size()), corners, {0, 1, 2}, lattice));
    }
    return result;
}

struct Scanned {
    std::vector<float> squared;    ///< of the coarse brick's samples, x running fastest
    std::vector<cl_uint> nearest;  ///< their polyhedra, with -DNEAREST
    std::vector<cl_uint> others;   ///< the polyhedra that are not slender
};

Scanned scan(const device::Context& context, unsigned lanes, const std::string& options, const Layout& layout,
             const Index3& coarse, const std::vector<Polyhedron>& polyhedra, float bound) {
    Scanned result;
    result.squared.resize(std::size_t{CLSDF_COARSE} * CLSDF_COARSE * CLSDF_COARSE);
    result.nearest.resize(result.squared.size());
    result.others.resize(polyhedra.size() + lanes);
    std::vector<cl_uint> entries(polyhedra.size());
    for (std::size_t n = 0; n < entries.size(); ++n) entries[n] = static_cast<cl_uint>(n);
    device::guarded([&] {
        cl::Program program(context.context(), device::kernel_text("slender_scan.h") + scan_alone);
        program.build(context.device(), fmt::format("-cl-std=CL1.2 -w -DLANES={} {}", lanes, options).c_str());
        const auto room = [&](std::size_t bytes) { return cl::Buffer(context.context(), CL_MEM_READ_WRITE, bytes); };
        const cl::Buffer of_entries = room(entries.size() * sizeof(cl_uint));
        const cl::Buffer of_polyhedra = room(polyhedra.size() * sizeof(Polyhedron));
        const cl::Buffer minima = room(2 * result.squared.size() * sizeof(float));
        const cl::Buffer others = room(result.others.size() * sizeof(cl_uint)), other_count = room(sizeof(cl_uint));
        const cl::Buffer squared = room(result.squared.size() * sizeof(float));
        const cl::Buffer nearest = room(result.nearest.size() * sizeof(cl_uint));
        const cl::CommandQueue& queue = context.queue();
        queue.enqueueWriteBuffer(of_entries, CL_TRUE, 0, entries.size() * sizeof(cl_uint), entries.data());
        queue.enqueueWriteBuffer(of_polyhedra, CL_TRUE, 0, polyhedra.size() * sizeof(Polyhedron), polyhedra.data());
        cl::Kernel kernel(program, "scan_alone");
        cl_uint n = 0;
        kernel.setArg(n++, layout);
        for (const std::int64_t index : coarse) kernel.setArg(n++, static_cast<cl_int>(index));
        kernel.setArg(n++, static_cast<cl_uint>(entries.size()));
        kernel.setArg(n++, of_entries);
        kernel.setArg(n++, bound);
        for (const cl::Buffer* buffer : {&of_polyhedra, &minima, &others, &other_count, &squared, &nearest})
            kernel.setArg(n++, *buffer);
        queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(1));
        cl_uint count = 0;
        queue.enqueueReadBuffer(other_count, CL_TRUE, 0, sizeof(count), &count);
        queue.enqueueReadBuffer(others, CL_TRUE, 0, result.others.size() * sizeof(cl_uint), result.others.data());
        queue.enqueueReadBuffer(squared, CL_TRUE, 0, result.squared.size() * sizeof(float), result.squared.data());
        queue.enqueueReadBuffer(nearest, CL_TRUE, 0, result.nearest.size() * sizeof(cl_uint), result.nearest.data());
        result.others.resize(count);
    });
    return result;
}

struct Case {
    Index3 coarse;
    Vec3 spacing;
    double size, half_width, steepest;
    std::size_t count = 61;  ///< of polyhedra; if they are few, most have samples that are nearest to them alone
};

/// Returns how many of the samples lie in a slender polyhedron.
std::size_t check_scan(const device::Context& context, unsigned lanes, const Case& c, std::uint64_t seed) {
    Random random(seed);
    Grid grid;
    grid.spacing = c.spacing;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        grid.first[axis] = c.coarse[axis] * CLSDF_COARSE;
        grid.size[axis] = CLSDF_COARSE;
    }
    const Layout layout = scan::layout_of(grid, Band::symmetric(c.half_width), SignRule::automatic);
    const polyhedra::LatticeView lattice = scan::lattice_of(grid);
    Vec3 first{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        first[axis] = static_cast<double>(grid.first[axis]) * lattice.spacing_in_units[axis];
    const auto bound = static_cast<double>(layout.half_width);
    std::vector<Polyhedron> polyhedra = random_polyhedra(random, lattice, first, c.size, c.steepest, c.count);
    // A point site in the middle: its triangle has no area, but its sections may have any.
    polyhedra::Vector middle(first[0], first[1], first[2]);
    middle += 16 * polyhedra::to_vector(lattice.spacing_in_units);
    const auto site = static_cast<cl_uint>(polyhedra.size());
    const std::array<Vec3, 1> position{Vec3{middle.x(), middle.y(), middle.z()}};
    polyhedra.push_back(polyhedra::pack(polyhedra::point_frame(middle, polyhedra::Vector(0, 0, 1)),
                                        polyhedra::FaceSlopes{{1, 1, 1}, {1, 1, 1}}, site, position, {0, 0, 0},
                                        lattice));
    std::string options = seed % 2 == 0 ? "" : "-DMOST_SAMPLES=8";  // lists that one polyhedron fills several times
    if (seed / 2 % 2 == 0) options += " -DSCATTERED_ACCESS";        // matters if the processor has AVX-512
    const bool has_nearest = seed % 3 == 0;
    if (has_nearest) options += " -DNEAREST";
    const Scanned scanned = scan(context, lanes, options, layout, c.coarse, polyhedra, layout.half_width);

    std::vector<bool> is_scanned(polyhedra.size(), true);
    for (const cl_uint other : scanned.others) is_scanned[other] = false;
    const double slack = static_cast<double>(layout.brick_slack) + bound * static_cast<double>(layout.slack_rate);
    std::size_t within = 0, missed = 0, astray = 0, misnamed = 0, n = 0;
    double largest = 0;
    for (int k = 0; k < CLSDF_COARSE; ++k)
        for (int j = 0; j < CLSDF_COARSE; ++j)
            for (int i = 0; i < CLSDF_COARSE; ++i, ++n) {
                double least = infinite, least_within = infinite, of_named = infinite;
                bool may_have = false;
                for (std::size_t p = 0; p < polyhedra.size(); ++p) {
                    if (!is_scanned[p]) continue;
                    const Position place = position_in(polyhedra[p], static_cast<double>(grid.first[0] + i),
                                                       static_cast<double>(grid.first[1] + j),
                                                       static_cast<double>(grid.first[2] + k), bound, slack);
                    least = std::min(least, place.squared_distance);
                    if (p == scanned.nearest[n]) of_named = place.squared_distance;
                    if (place.is_within) least_within = std::min(least_within, place.squared_distance);
                    may_have |= place.outside <= 20 * slack;
                }
                const double found = std::sqrt(static_cast<double>(scanned.squared[n]));
                const double tolerance = std::max(1e-6, 2.4e-7 * found);  // 2 ulp at most
                within += least_within < infinite;
                missed += least_within < infinite && !(found <= std::sqrt(least_within) + tolerance);
                astray += found < infinite && !may_have;
                misnamed += has_nearest && !(found < infinite ? std::abs(std::sqrt(of_named) - found) <= tolerance
                                                              : scanned.nearest[n] == CLSDF_NO_TRIANGLE);
                if (found < infinite) largest = std::max(largest, (std::sqrt(least) - found) / tolerance);
            }
    BOOST_TEST(!is_scanned[site]);
    BOOST_TEST(missed == 0U);
    BOOST_TEST(astray == 0U);
    BOOST_TEST(misnamed == 0U);
    BOOST_TEST(largest <= 1);
    return within;
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_sample_of_a_slender_polyhedron_has_its_distance_and_no_other_has_one) {
    const Device device = Device::strongest();
    constexpr std::uint64_t seed = 20261121;
    const std::vector<Case> cases{
        {{0, 0, 0}, {1, 1, 1}, 1.5, 25, 0.06},    {{-3, 2, 7}, {1, 1, 1}, 0.4, 25, 0.016},
        {{5, -1, 0}, {1.3, 1.3, 1.3}, 2, 4, 0.5}, {{1, 1, 1}, {1.4, 1, 1.2}, 2, 20, 0.1},
        {{0, -2, 0}, {1, 1, 1}, 3, 12, 0.25},     {{4000, 9, -70000}, {1, 1, 1}, 1, 30, 0.033},
        {{2, 0, -1}, {1, 1, 1}, 1.5, 1.5, 1},     {{2, 0, -1}, {1, 1.1, 1}, 3, 1, 1},
        {{0, 0, 0}, {1, 1, 1}, 1, 60, 0.01},      {{0, 1, 0}, {1, 1, 1}, 2, 5, 0.3, 6},
        {{0, 1, 0}, {1, 1, 1}, 1.5, 8, 0.2, 6},
    };
    for (const Case& c : cases)
        for (const unsigned lanes : {8U, 16U})
            for (std::uint64_t n = 0; n < 4; ++n) {
                BOOST_TEST_CONTEXT("size " << c.size << ", half width " << c.half_width << ", " << lanes
                                           << " lanes, seed " << seed + n) {
                    BOOST_TEST(check_scan(device::context_of(device), lanes, c, seed + n) > c.count / 2);
                }
            }
}
