#include "device/context.hpp"
#include "device/kernel_text.hpp"

#include <clsdf/device.hpp>

#include <fmt/format.h>
#include <boost/test/unit_test.hpp>

#include <bit>
#include <string>
#include <vector>

// Where the compiler has an instruction for what a vector does, the kernels take it; else plain OpenCL C, which no
// processor at hand may take. A compiler that forgets what it has takes it everywhere.

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
    std::vector<cl_uint> front;  // of each vector what is chosen; the rest may be anything
    for (cl_uint mask = 0; mask < masks; ++mask) {
        wrong += bits[mask] != mask;
        const auto begin = chosen.begin() + static_cast<std::ptrdiff_t>(std::size_t{mask} * lanes);
        front.insert(front.end(), begin, begin + std::popcount(mask));
    }
    BOOST_TEST(wrong == 0U);
    BOOST_TEST((front == values_of_masks(values)));
}

}  // namespace

BOOST_AUTO_TEST_CASE(vectors_are_masked_and_packed_alike_with_and_without_instructions_for_it) {
    const Device device = Device::best();
    const std::string helpers = device::kernel_text("brick_lists.h") + every_mask;
    for (const unsigned lanes : {8U, 16U}) BOOST_TEST_CONTEXT(lanes << " lanes") {
            BOOST_TEST_CONTEXT("as the compiler is") check_every_mask(device.internal(), helpers, lanes);
            BOOST_TEST_CONTEXT("in plain OpenCL C") check_every_mask(device.internal(), forget + helpers, lanes);
        }
}

BOOST_AUTO_TEST_CASE(kernels_of_vectors_are_plain_opencl_c_where_the_compiler_has_nothing_else) {
    const Device device = Device::best();
    for (const char* file : {"scan.cl", "coarse_lists.cl", "sign_sweep.cl", "bricks_by_vector.cl", "fill.cl"})
        for (const unsigned lanes : {8U, 16U})
            BOOST_CHECK_NO_THROW(
                device::guarded([&] { build(device.internal(), forget + device::kernel_text(file), lanes); }));
}
