#include "support/shared_structs.hpp"

#include "coarse.h"
#include "face_sources.h"
#include "layout.h"
#include "outputs.h"
#include "point_groups.h"
#include "point_tree.h"
#include "stored_box.h"
#include "sweep.h"

#include <boost/test/unit_test.hpp>

#include <regex>
#include <set>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

std::vector<Agreement> agreements() {
    std::vector<Agreement> all;
    CLSDF_SHARED(all, Polyhedron, gradient_x, gradient_y, gradient_z, constant_at_origin, base, normal_along,
                 normal_across, slope_above, slope_below, foot, origin_x, origin_y, origin_z, flags, triangle,
                 exact_gradient_x, exact_gradient_y, exact_gradient_z, exact_constant_at_origin, exact_base,
                 exact_normal_along, exact_normal_across, exact_altitude);
    CLSDF_SHARED(all, Layout, first, size, brick_first, bricks, coarse_first, coarse_bricks, sign_words, half_width,
                 inside_squared, outside_squared, slack_rate, brick_slack, coarse_slack, brick_radius, coarse_radius,
                 spacing, unit, inside_fill, outside_fill);
    CLSDF_SHARED(all, SurfacePoint, origin, foot);
    CLSDF_SHARED(all, ClusterPair, cluster, brick, lanes);
    CLSDF_SHARED(all, CoarsePair, brick, polyhedron, index);
    CLSDF_SHARED(all, SweepVertex, y, z, x);
    CLSDF_SHARED(all, SweepRecord, row, key, index);
    CLSDF_SHARED(all, SweepTotals, records, large, large_blocks, largest_rows);
    CLSDF_SHARED(all, TriangleSites, triangle, site);
    CLSDF_SHARED(all, Finish, origin, spacing, per_spacing, unit, inside_fill, outside_fill, wanted, in_double, outward,
                 renumbered);
    CLSDF_SHARED(all, StoredBox, from, to, strides, component_stride, size, padding);
    CLSDF_SHARED(all, FaceLattice, origin, spacing, sample, per_unit);
    CLSDF_SHARED(all, FanItem, offset, count, faces);
    CLSDF_SHARED(all, PointTree, faces, levels, first, count);
    CLSDF_SHARED(all, PointNode, lower, upper);
    CLSDF_SHARED(all, PointFace, offset, triangle, lowest);
    CLSDF_SHARED(all, PointLeaf, gradient, offset, base, normal_along, normal_across, altitude, origin, extent,
                 padding);
    CLSDF_SHARED(all, PointGroup, origin, children, centre, half_side);
    CLSDF_SHARED(all, FaceNeighbours, vertex, across);
    CLSDF_SHARED(all, ScanRecord, gradient_x, gradient_y, gradient_z, constant_at_origin, base, normal_along,
                 normal_across, slope_above, slope_below, foot, origin_x, origin_y, origin_z, flags, altitude);
    CLSDF_SHARED(all, ScanCounts, faces, records, longest);
    CLSDF_SHARED(all, PointBrick, at, squared, from_origin, bound, triangle, face, vertex, candidate, record, vector);
    return all;
}

}  // namespace

BOOST_AUTO_TEST_CASE(host_and_device_lay_out_what_they_share_alike) {
    std::string text;
    for (const char* header : {"polyhedron.h", "layout.h", "coarse.h", "sweep.h", "outputs.h", "stored_box.h",
                               "face_sources.h", "point_tree.h", "point_groups.h"})
        text += device::kernel_text(header);
    const std::vector<Agreement> all = agreements();
    std::set<std::string> names;
    for (const Agreement& agreement : all) names.insert(agreement.name);
    const std::regex end_of_struct("\n\\} (\\w+);");
    for (std::sregex_iterator match(text.begin(), text.end(), end_of_struct), end; match != end; ++match)
        BOOST_TEST(names.contains("sizeof(" + (*match)[1].str() + ")"), (*match)[1] << " is not compared");
    check_agreements(all, text);
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
    const Device device = Device::strongest();
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
