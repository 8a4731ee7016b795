#include "device/context.hpp"

#include <clsdf/device.hpp>

#include <fmt/format.h>
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>
#include <vector>

// If the compiler has an instruction for a vector operation, the kernels use it, else plain OpenCL C. To test the plain
// code on every processor, the compiler is told that it has none of these instructions.

using namespace clsdf;

namespace {

constexpr const char* forget =
    "#undef __clang__\n"
    "#undef __has_builtin\n"
    "#undef __AVX__\n"
    "#undef __AVX2__\n"
    "#undef __AVX512F__\n"
    "#undef __AVX512DQ__\n";

constexpr const char* every_mask = R"(
__kernel void every_mask(__global const uint* values, __global uint* bits, __global uint* chosen) {
    const uint mask = get_global_id(0);
    bits[mask] = lanes_to_bits((((uintL)mask >> LANE_NUMBERS) & 1u) != 0u);
    store_lanes(packed(load_lanes(0, values), mask), mask, chosen);
}
)";

// By lane: the numbers for the tables of polyhedra, and the displacements of samples.
constexpr const char* distances_by_table = R"(
__kernel void distances_by_table(__global const float* numbers, float x, float y, float z,
                                 __global const float* displacements, __global float* squared) {
    EdgeTables all;
    const float8 zero = 0.0f;
#define NUMBERS(n) vload8(group, numbers + (n) * LANES)
    for (uint group = 0; group < LANES / 8; ++group) {
        store_tables(NUMBERS(0), zero, zero, NUMBERS(1), group, all.along);
        store_tables(NUMBERS(2), zero - 1.0f, zero - 1.0f, NUMBERS(3), group, all.across);
        store_tables(NUMBERS(4), zero - y, zero - y, NUMBERS(5), group, all.outward);
        store_tables(NUMBERS(6), zero - INFINITY, zero - INFINITY, NUMBERS(7), group, all.before);
        store_tables(NUMBERS(8), NUMBERS(10), NUMBERS(11), NUMBERS(9), group, all.past);
    }
    for (uint lane = 0; lane < LANES; ++lane)
        store_lanes(squared_distance_by_table(table_at(&all, lane), x, y, z, load_lanes(0, displacements),
                                              load_lanes(1, displacements), load_lanes(2, displacements)),
                    lane, squared);
}
)";

cl::Program build(const device::Context& context, const std::string& text, unsigned lanes) {
    cl::Program program(context.context(), text);
    program.build(context.device(), fmt::format("-cl-std=CL1.2 -w -DLANES={}", lanes).c_str());
    return program;
}

/// The chosen lanes' values of one mask after the other.
std::vector<cl_uint> values_of_masks(const std::vector<cl_uint>& values) {
    std::vector<cl_uint> result;
    for (cl_uint mask = 0; mask < 1U << values.size(); ++mask)
        for (std::size_t lane = 0; lane < values.size(); ++lane)
            if (mask >> lane & 1U) result.push_back(values[lane]);
    return result;
}

void check_every_mask(const device::Context& context, const std::string& text, unsigned lanes) {
    std::vector<cl_uint> values;
    for (unsigned lane = 0; lane < lanes; ++lane) values.push_back(0x80000001U + 1000 * lane);
    const std::size_t masks = std::size_t{1} << lanes;
    std::vector<cl_uint> bits(masks), chosen(masks * lanes);
    device::guarded([&] {
        const auto room = [&](std::size_t count) {
            return cl::Buffer(context.context(), CL_MEM_READ_WRITE, count * sizeof(cl_uint));
        };
        const cl::Buffer of_values = room(lanes), of_bits = room(masks), of_chosen = room(chosen.size());
        const cl::CommandQueue& queue = context.queue();
        queue.enqueueWriteBuffer(of_values, CL_TRUE, 0, lanes * sizeof(cl_uint), values.data());
        cl::Kernel kernel(build(context, text, lanes), "every_mask");
        kernel.setArg(0, of_values);
        kernel.setArg(1, of_bits);
        kernel.setArg(2, of_chosen);
        queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(masks));
        queue.enqueueReadBuffer(of_bits, CL_TRUE, 0, masks * sizeof(cl_uint), bits.data());
        queue.enqueueReadBuffer(of_chosen, CL_TRUE, 0, chosen.size() * sizeof(cl_uint), chosen.data());
    });
    std::size_t wrong = 0;
    std::vector<cl_uint> front;  // the chosen lanes of each vector; the other lanes are undefined
    for (cl_uint mask = 0; mask < masks; ++mask) {
        wrong += bits[mask] != mask;
        const auto begin = chosen.begin() + static_cast<std::ptrdiff_t>(std::size_t{mask} * lanes);
        front.insert(front.end(), begin, begin + std::popcount(mask));
    }
    BOOST_TEST(wrong == 0U);
    BOOST_TEST((front == values_of_masks(values)));
}

/// The distance to a right-angled half of a triangle, at the origin of its frame: the slanted edge from (base, 0) to
/// (0, altitude).
struct Half {
    double base, altitude;

    double length() const { return std::hypot(base, altitude); }
    double along() const { return altitude / length(); }
    double across() const { return base / length(); }
    double outward(double x, double y) const { return along() * (x - base) + across() * y; }
    double before(double x, double y) const { return across() * (x - base) - along() * y; }
    double past(double x, double y) const { return along() * (y - altitude) - across() * x; }

    double squared_distance(double x, double y, double z) const {
        const bool below = y < 0;
        const double r = below ? -y : outward(x, y);
        const double t = below ? x - base : std::max(before(x, y), past(x, y));
        return std::pow(std::max(r, 0.0), 2) + std::pow(std::max(t, 0.0), 2) + z * z;
    }
};

/// Each lane's triangle has an altitude of its own and differing halves; the samples lie in all four regions.
void check_distances_by_table(const device::Context& context, const std::string& text, unsigned lanes) {
    constexpr double x = 0.25, y = -0.5, z = 0.75;
    std::vector<Half> right, left;
    for (unsigned lane = 0; lane < lanes; ++lane) {
        const double altitude = 1 + 0.25 * lane;
        right.push_back({0.5 + 0.125 * lane, altitude});
        left.push_back({2.5 - 0.125 * lane, altitude});
    }
    std::vector<float> numbers;
    const auto append = [&](const std::vector<Half>& halves, const auto& number) {
        for (const Half& half : halves) numbers.push_back(static_cast<float>(number(half)));
    };
    const auto append_both = [&](const auto& number) {
        append(right, [&](const Half& half) { return number(half, x); });
        append(left, [&](const Half& half) { return number(half, -x); });
    };
    append_both([](const Half& half, double) { return half.along(); });
    append_both([](const Half& half, double) { return half.across(); });
    append_both([](const Half& half, double away) { return half.outward(away, y); });
    append_both([](const Half& half, double away) { return half.before(away, y); });
    append_both([](const Half& half, double away) { return half.past(away, y); });
    append_both([](const Half& half, double away) { return away - half.base; });
    std::vector<double> displacements(std::size_t{3} * lanes);  // along X, Y, Z; numbers that float has too
    for (unsigned lane = 0; lane < lanes; ++lane) {
        displacements[lane] = (lane % 2 == 0 ? -1 : 1) * (0.5 + lane);
        displacements[lanes + lane] = (lane / 2 % 2 == 0 ? -1 : 1) * (1.0 + lane);
        displacements[2 * lanes + lane] = 0.25 * lane;
    }

    std::vector<float> squared(std::size_t{lanes} * lanes);
    device::guarded([&] {
        const auto filled = [&](std::vector<float> values) {
            return cl::Buffer(context.context(), CL_MEM_COPY_HOST_PTR, values.size() * sizeof(float), values.data());
        };
        const cl::Buffer result(context.context(), CL_MEM_READ_WRITE, squared.size() * sizeof(float));
        cl::Kernel kernel(build(context, text, lanes), "distances_by_table");
        const cl::Buffer of_numbers = filled(numbers), at = filled({displacements.begin(), displacements.end()});
        kernel.setArg(0, of_numbers);
        kernel.setArg(1, static_cast<float>(x));
        kernel.setArg(2, static_cast<float>(y));
        kernel.setArg(3, static_cast<float>(z));
        kernel.setArg(4, at);
        kernel.setArg(5, result);
        context.queue().enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(1));
        context.queue().enqueueReadBuffer(result, CL_TRUE, 0, squared.size() * sizeof(float), squared.data());
    });
    double largest = 0;
    std::size_t n = 0;
    for (unsigned lane = 0; lane < lanes; ++lane)
        for (unsigned sample = 0; sample < lanes; ++sample, ++n) {
            const double sample_x = x + displacements[sample];
            const Half& half = sample_x < 0 ? left[lane] : right[lane];
            const double expected = half.squared_distance(std::abs(sample_x), y + displacements[lanes + sample],
                                                          z + displacements[2 * lanes + sample]);
            largest = std::max(largest, std::abs(static_cast<double>(squared[n]) - expected) / expected);
        }
    BOOST_TEST(largest < 1e-6);
}

}  // namespace

BOOST_AUTO_TEST_CASE(vectors_are_masked_and_packed_alike_with_and_without_instructions_for_it) {
    const Device device = Device::strongest();
    const std::string helpers = device::kernel_text("brick_lists.h") + every_mask;
    for (const unsigned lanes : {8U, 16U}) BOOST_TEST_CONTEXT(lanes << " lanes") {
            BOOST_TEST_CONTEXT("as the compiler is") check_every_mask(device::context_of(device), helpers, lanes);
            BOOST_TEST_CONTEXT("in plain OpenCL C")
            check_every_mask(device::context_of(device), forget + helpers, lanes);
        }
}

BOOST_AUTO_TEST_CASE(distances_by_table_are_those_of_the_triangle_with_and_without_instructions_for_them) {
    const Device device = Device::strongest();
    const std::string helpers = device::kernel_text("lane_offsets.h") + distances_by_table;
    for (const unsigned lanes : {8U, 16U}) BOOST_TEST_CONTEXT(lanes << " lanes") {
            BOOST_TEST_CONTEXT("as the compiler is")
            check_distances_by_table(device::context_of(device), helpers, lanes);
            BOOST_TEST_CONTEXT("in plain OpenCL C")
            check_distances_by_table(device::context_of(device), forget + helpers, lanes);
        }
}

BOOST_AUTO_TEST_CASE(kernels_of_vectors_are_plain_opencl_c_where_the_compiler_has_nothing_else) {
    const Device device = Device::strongest();
    for (const char* file : {"scan.cl", "coarse_lists.cl", "bricks_by_vector.cl", "fill.cl"})
        for (const unsigned lanes : {8U, 16U})
            BOOST_CHECK_NO_THROW(
                device::guarded([&] { build(device::context_of(device), forget + device::kernel_text(file), lanes); }));
}
