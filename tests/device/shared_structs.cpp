#include <clsdf/device.hpp>

#include "coarse.h"
#include "device/context.hpp"
#include "layout.h"
#include "render.h"
#include "sweep.h"

#include <boost/test/unit_test.hpp>

#include <string>
#include <vector>

using namespace clsdf;

namespace {

/// A number that the host's and the device's compiler must agree on; `expression` is OpenCL C.
struct Agreement {
    std::string name;
    std::size_t on_host;
    std::string expression;
};

#define CLSDF_SIZE(type)                                       \
    Agreement {                                                \
        "sizeof(" #type ")", sizeof(type), "sizeof(" #type ")" \
    }
#define CLSDF_OFFSET(type, member)                                                                \
    Agreement {                                                                                   \
#type "::" #member, offsetof(type, member), "(size_t)&((__global " #type "*)0)->" #member \
    }

const std::vector<Agreement> agreements{
    CLSDF_SIZE(Polyhedron),
    CLSDF_OFFSET(Polyhedron, gradient_x),
    CLSDF_OFFSET(Polyhedron, gradient_y),
    CLSDF_OFFSET(Polyhedron, gradient_z),
    CLSDF_OFFSET(Polyhedron, constant_at_origin),
    CLSDF_OFFSET(Polyhedron, base),
    CLSDF_OFFSET(Polyhedron, normal_along),
    CLSDF_OFFSET(Polyhedron, normal_across),
    CLSDF_OFFSET(Polyhedron, flags),
    CLSDF_OFFSET(Polyhedron, triangle),
    CLSDF_OFFSET(Polyhedron, origin_x),
    CLSDF_OFFSET(Polyhedron, origin_y),
    CLSDF_OFFSET(Polyhedron, origin_z),
    CLSDF_OFFSET(Polyhedron, slope_above),
    CLSDF_OFFSET(Polyhedron, slope_below),
    CLSDF_OFFSET(Polyhedron, foot),
    CLSDF_OFFSET(Polyhedron, exact_gradient_x),
    CLSDF_OFFSET(Polyhedron, exact_gradient_y),
    CLSDF_OFFSET(Polyhedron, exact_gradient_z),
    CLSDF_OFFSET(Polyhedron, exact_constant_at_origin),
    CLSDF_OFFSET(Polyhedron, exact_base),
    CLSDF_OFFSET(Polyhedron, exact_normal_along),
    CLSDF_OFFSET(Polyhedron, exact_normal_across),
    CLSDF_OFFSET(Polyhedron, exact_altitude),
    CLSDF_SIZE(Layout),
    CLSDF_OFFSET(Layout, first),
    CLSDF_OFFSET(Layout, size),
    CLSDF_OFFSET(Layout, brick_first),
    CLSDF_OFFSET(Layout, bricks),
    CLSDF_OFFSET(Layout, coarse_first),
    CLSDF_OFFSET(Layout, coarse_bricks),
    CLSDF_OFFSET(Layout, sign_words),
    CLSDF_OFFSET(Layout, half_width),
    CLSDF_OFFSET(Layout, inside_squared),
    CLSDF_OFFSET(Layout, outside_squared),
    CLSDF_OFFSET(Layout, slack_rate),
    CLSDF_OFFSET(Layout, brick_slack),
    CLSDF_OFFSET(Layout, coarse_slack),
    CLSDF_OFFSET(Layout, brick_radius),
    CLSDF_OFFSET(Layout, coarse_radius),
    CLSDF_OFFSET(Layout, spacing),
    CLSDF_OFFSET(Layout, unit),
    CLSDF_OFFSET(Layout, inside_fill),
    CLSDF_OFFSET(Layout, outside_fill),
    CLSDF_SIZE(SurfacePoint),
    CLSDF_OFFSET(SurfacePoint, foot),
    CLSDF_SIZE(ClusterPair),
    CLSDF_OFFSET(ClusterPair, brick),
    CLSDF_OFFSET(ClusterPair, lanes),
    CLSDF_SIZE(SweepVertex),
    CLSDF_OFFSET(SweepVertex, y),
    CLSDF_OFFSET(SweepVertex, z),
    CLSDF_OFFSET(SweepVertex, x),
    CLSDF_SIZE(SweepRecord),
    CLSDF_OFFSET(SweepRecord, key),
    CLSDF_OFFSET(SweepRecord, index),
    CLSDF_SIZE(SweepTotals),
    CLSDF_OFFSET(SweepTotals, large),
    CLSDF_OFFSET(SweepTotals, large_blocks),
    CLSDF_OFFSET(SweepTotals, largest_rows),
    CLSDF_SIZE(RenderView),
    CLSDF_OFFSET(RenderView, direction),
    CLSDF_OFFSET(RenderView, direction_down),
    CLSDF_OFFSET(RenderView, cut),
    CLSDF_OFFSET(RenderView, light),
    CLSDF_OFFSET(RenderView, spacing),
    CLSDF_OFFSET(RenderView, slope),
    CLSDF_OFFSET(RenderView, reach),
    CLSDF_OFFSET(RenderView, cut_side),
    CLSDF_OFFSET(RenderView, size),
    CLSDF_OFFSET(RenderView, per_side),
    CLSDF_SIZE(RenderHit),
    CLSDF_OFFSET(RenderHit, gradient),
    CLSDF_OFFSET(RenderHit, light),
};

#undef CLSDF_SIZE
#undef CLSDF_OFFSET

}  // namespace

BOOST_AUTO_TEST_CASE(host_and_device_lay_out_what_they_share_alike) {
    std::string text = device::kernel_text("layout.h") + device::kernel_text("coarse.h") +
                       device::kernel_text("sweep.h") + device::kernel_text("render.h");
    text += "__kernel void measure(__global uint* found) {\n";
    for (std::size_t i = 0; i < agreements.size(); ++i)
        text += "    found[" + std::to_string(i) + "] = (uint)(" + agreements[i].expression + ");\n";
    text += "}\n";

    const Device device = Device::best();
    std::vector<cl_uint> found(agreements.size());
    device::guarded([&] {
        const device::Context& context = device::context_of(device);
        cl::Program program(context.context(), text);
        program.build(context.device(), "-cl-std=CL1.2");
        const std::size_t bytes = found.size() * sizeof(cl_uint);
        const cl::Buffer buffer(context.context(), CL_MEM_WRITE_ONLY, bytes);
        cl::Kernel kernel(program, "measure");
        kernel.setArg(0, buffer);
        context.queue().enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(1));
        context.queue().enqueueReadBuffer(buffer, CL_TRUE, 0, bytes, found.data());
    });
    for (std::size_t i = 0; i < agreements.size(); ++i)
        BOOST_TEST_CONTEXT(agreements[i].name) BOOST_TEST(found[i] == agreements[i].on_host);
}

// The device gets a Layout as an argument: by value, with nothing lost.
BOOST_AUTO_TEST_CASE(a_layout_arrives_on_the_device_as_it_was_sent) {
    Layout sent{};
    sent.first[0] = -7;
    sent.coarse_bricks[2] = 11;
    sent.sign_words = 13;
    sent.half_width = 0.5F;
    sent.outside_fill = 17.25F;
    const std::string text = device::kernel_text("layout.h") +
                             "__kernel void copy(Layout layout, __global float* found) {\n"
                             "    found[0] = layout.first[0]; found[1] = layout.coarse_bricks[2];\n"
                             "    found[2] = layout.sign_words; found[3] = layout.half_width;\n"
                             "    found[4] = layout.outside_fill;\n"
                             "}\n";
    const Device device = Device::best();
    std::vector<float> found(5);
    device::guarded([&] {
        const device::Context& context = device::context_of(device);
        cl::Program program(context.context(), text);
        program.build(context.device(), "-cl-std=CL1.2");
        const cl::Buffer buffer(context.context(), CL_MEM_WRITE_ONLY, found.size() * sizeof(float));
        cl::Kernel kernel(program, "copy");
        kernel.setArg(0, sent);
        kernel.setArg(1, buffer);
        context.queue().enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(1));
        context.queue().enqueueReadBuffer(buffer, CL_TRUE, 0, found.size() * sizeof(float), found.data());
    });
    const std::vector<float> expected{-7.0F, 11.0F, 13.0F, 0.5F, 17.25F};
    BOOST_TEST(found == expected, boost::test_tools::per_element());
}
