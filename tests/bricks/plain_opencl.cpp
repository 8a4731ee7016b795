#include "support/float_width.hpp"
#include "support/hostile_meshes.hpp"
#include "support/test_meshes.hpp"

#include <array>
#include <string>
#include <string_view>

// If the compiler has an instruction for a vector operation, the kernels use it, else plain OpenCL C. To test the plain
// code on every processor, the compiler is told that it has none of these instructions.

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr const char* forget =
    "#undef __clang__\n"
    "#undef __has_builtin\n"
    "#undef __AVX__\n"
    "#undef __AVX2__\n"
    "#undef __AVX512F__\n"
    "#undef __AVX512DQ__\n";

Device in_plain_opencl(unsigned width) {
    Device device = with_float_width(width);
    device::context_of(device).set_text_edit([](std::string_view, std::string& text) { text = forget + text; });
    return device;
}

}  // namespace

BOOST_AUTO_TEST_CASE(fields_in_plain_opencl_c_are_those_of_instructions_for_vectors) {
    const Mesh knot = tilted(make_shape("knot")), ball = tilted(make_shape("sphere6"));
    for (const unsigned width : {8U, 16U}) {
        const Device device = with_float_width(width), plain = in_plain_opencl(width);
        for (const Mesh* mesh : {&knot, &ball}) {
            const Grid grid = grid_around(*mesh, 40, 3);
            const DistanceTransform by_instructions(device, *mesh, {.body = KernelBody::by_vector}),
                by_text(plain, *mesh, {.body = KernelBody::by_vector});
            for (const Band& band : {Band::symmetric(2.5 * grid.voxel()), Band::full()}) {
                const Field field = by_text.compute(grid, band, all_outputs());
                BOOST_TEST(check_exact(*mesh, field, guaranteed).band_samples > 0U);
                BOOST_TEST(same_bytes(field, by_instructions.compute(grid, band, all_outputs())));
            }
            const std::vector<Vec3> points = samples_of(grid);
            BOOST_TEST(same_bytes(query(by_text, points), query(by_instructions, points)));
        }
    }
}
