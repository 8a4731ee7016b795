#include "support/exact_field.hpp"
#include "support/throws.hpp"

#include "device/context.hpp"

#include <limits>

/// Callers' objects and numbers that are legal, or nearly so, and have broken this library or others.
namespace clsdf::test {
namespace {

Grid unit_grid(double spacing = 0.1) {
    return {{-1.2 * spacing, -1.2 * spacing, -1.2 * spacing}, {spacing, spacing, spacing}, {12, 12, 12}, {}};
}

Mesh enlarged(const Mesh& mesh, double factor) {
    std::vector<Vec3> vertices = mesh.vertices();
    for (Vec3& v : vertices) v = {v[0] * factor, v[1] * factor, v[2] * factor};
    return {std::move(vertices), mesh.triangles(), mesh.name()};
}

/// Every triangle with corners of its own.
Mesh as_soup(const Mesh& mesh) {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (const Triangle& triangle : mesh.triangles()) {
        const auto first = static_cast<std::uint32_t>(vertices.size());
        for (const std::uint32_t corner : triangle) vertices.push_back(mesh.vertices()[corner]);
        triangles.push_back({first, first + 1, first + 2});
    }
    return {std::move(vertices), std::move(triangles), mesh.name() + " as a soup"};
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_device_whose_queue_is_out_of_order_computes_the_same_bytes) {
    const Mesh mesh = make_shape("knot");
    const Grid grid = grid_around(mesh, 64, 6);
    const Band band = Band::symmetric(5 * grid.voxel());
    const Field expected = compute(mesh, grid, band);
    const device::Context& context = test_device().internal();
    const cl::CommandQueue queue(context.context(), context.device(), CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
    const Device device = Device::from_handles(context.context()(), context.device()(), queue());
    DistanceTransform transform(device, mesh);
    for (int repetition = 0; repetition < 20; ++repetition)
        BOOST_TEST((transform(grid, band).distance == expected.distance));
}

BOOST_AUTO_TEST_CASE(a_queue_of_another_context_is_refused) {
    const device::Context& context = test_device().internal();
    const cl::Context other(context.device());
    const cl::CommandQueue queue(other, context.device());
    check_throws(ErrorCode::invalid_argument, {"another context"},
                 [&] { Device::from_handles(context.context()(), context.device()(), queue()); });
}

BOOST_AUTO_TEST_CASE(spacings_beyond_floats_are_refused) {
    for (const double scale : {1e-45, 1e-309, 1e41}) {
        const Mesh mesh = enlarged(make_shape("cube"), scale);
        check_throws(ErrorCode::invalid_argument, {"scale the mesh"},
                     [&] { compute(mesh, unit_grid(0.1 * scale), Band::symmetric(0.2 * scale)); });
    }
    check_throws(ErrorCode::invalid_argument, {"scale the mesh"},
                 [&] { compute(make_shape("cube"), unit_grid(), Band::symmetric(1e40)); });
}

BOOST_AUTO_TEST_CASE(spacings_that_differ_beyond_reason_are_refused) {
    Grid grid = unit_grid();
    grid.spacing[2] = 1e10 * grid.spacing[0];
    check_throws(ErrorCode::invalid_argument, {"factor of 1e9"},
                 [&] { compute(make_shape("cube"), grid, Band::symmetric(0.2)); });
}

BOOST_AUTO_TEST_CASE(an_unsigned_field_beyond_the_mesh_is_outside_by_either_body) {
    const Mesh mesh = make_shape("tetrahedron");
    Grid grid = unit_grid();
    grid.origin = {100, 100, 100};
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group}) {
        const Field field = compute(mesh, grid, {0.1, 0.2}, TransformOptions{.sign = SignRule::none, .body = body});
        BOOST_TEST((field.distance == FieldArray<float>(grid.sample_count(), 0.2F)));
    }
}

BOOST_AUTO_TEST_CASE(a_soup_costs_what_the_welded_mesh_costs) {
    const Mesh mesh = make_shape("torus");
    const Mesh soup = as_soup(mesh);
    const Grid grid = grid_around(mesh, 64, 6);
    const Band band = Band::symmetric(5 * grid.voxel());
    const auto lanes = [&](const Mesh& of) {
        DistanceTransform transform(test_device(), of, TransformOptions{.count = true});
        transform(grid, band);
        return transform.statistics().lanes_evaluated;
    };
    BOOST_TEST(lanes(soup) == lanes(mesh));
    BOOST_TEST((compute(soup, grid, band).distance == compute(mesh, grid, band).distance));
}

BOOST_AUTO_TEST_CASE(triangles_of_ten_billion_voxels_are_found) {
    constexpr double size = 1e10;
    const Mesh mesh({{size, size, size}, {-size, -size, size}, {-size, size, -size}, {size, -size, -size}},
                    {{0, 1, 3}, {0, 3, 2}, {0, 2, 1}, {1, 2, 3}}, "tetrahedron of 1e10 voxels");
    const double middle = -size / 3 - 20;  // of the last face, seen from the origin
    check_exact(mesh, Grid{{middle, middle, middle}, {1, 1, 1}, {40, 40, 40}, {}}, Band::symmetric(8), guaranteed);
}

}  // namespace clsdf::test
