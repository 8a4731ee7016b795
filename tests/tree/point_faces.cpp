// The faces that GPUs look points up among, and their sides, made by kernels, against those of the host.
#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"

#include "device/buffer_pool.hpp"
#include "launch/programs.hpp"
#include "points/face_sides.hpp"
#include "points/sign_faces.hpp"
#include "tree/binary_tree.hpp"
#include "tree/point_mesh.hpp"
#include "tree/wide_tree.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <random>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

template <class Value>
bool are_equal(const std::vector<Value>& values, const std::vector<Value>& others) {
    return std::memcmp(values.data(), others.data(), values.size() * sizeof(Value)) == 0;
}

/// A mesh on the device, and its faces and their tree by kernels.
struct Made {
    explicit Made(const Mesh& mesh)
        : topology(engine::make_device_topology(set_up, mesh)),
          made(engine::make_faces_and_tree(
              set_up.tools, mesh.box(), "mesh",
              {topology->topology, std::make_shared<const device::BufferPool::Lease>(std::move(topology->positions))},
              nullptr)),
          faces(made.faces) {}

    device::Context& context = device::context_of(test_device());
    std::shared_ptr<device::BufferPool> pool =
        std::make_shared<device::BufferPool>(device::shared_context_of(test_device()));
    engine::Programs programs{context, KernelBody::by_group};
    engine::DeviceTools tools{context, pool, programs};
    engine::DeviceSetUp set_up{tools};
    std::optional<engine::MadeTopology> topology;
    engine::FacesAndTree made;
    const engine::PointFaces& faces;
};

/// A body far from zero, and two equal faces that look to both sides.
Mesh body(Random& random) {
    const Mesh pillow({{0, 0, 0}, {1, 0, 0.25}, {0, 1, 0.5}}, {{1, 2, 0}, {0, 2, 1}}, "pillow");
    const Mesh all = together({random_closed(random, 3), pillow, overlapping_cubes()}, "body");
    return shifted(tilted(all), {1e3, -7, 1e-3});
}

}  // namespace

BOOST_AUTO_TEST_CASE(kernels_make_the_faces_of_the_host) {
    const unsigned seed = std::random_device()();
    Random random(seed);
    BOOST_TEST_CONTEXT("seed " << seed) {
        const Mesh mesh = body(random);
        const Made made(mesh);
        BOOST_REQUIRE(made.faces.found.special == 0U);
        const engine::PointMesh expected =
            engine::make_point_mesh(made.tools, mesh, {}, std::make_shared<const engine::MeshTopology>(mesh));
        const std::size_t count = expected.face_count();
        BOOST_REQUIRE(made.faces.count == count);
        BOOST_TEST(made.faces.lattice.unit == expected.lattice.unit);
        BOOST_TEST(are_equal(read<Polyhedron>(made.context, **made.faces.polyhedra, count),
                             read<Polyhedron>(made.context, **expected.polyhedra, count)));
        const auto faces = read<PointFace>(made.context, **expected.faces, count);
        BOOST_TEST(are_equal(read<PointFace>(made.context, **made.faces.faces, count), faces));
        std::size_t equal = 0;
        for (std::size_t face = 0; face < count; ++face) equal += faces[face].lowest != face ? 1U : 0U;
        BOOST_TEST(equal > 0U);
        BOOST_TEST(made.faces.found.inexact == 0U);
    }
}

BOOST_AUTO_TEST_CASE(kernels_find_the_sides_of_the_host) {
    const unsigned seed = std::random_device()();
    Random random(seed);
    BOOST_TEST_CONTEXT("seed " << seed) {
        for (const Mesh& mesh : {body(random), together({cube(1), shifted(cube(1), {3, 0, 0})}, "cubes"), cube(2),
                                 without_triangle(cube(1), 3), plate(1e-9)})
            for (const SignRule rule : {SignRule::nonzero, SignRule::parity}) {
                const Made made(mesh);
                const engine::PointFaces& faces = made.faces;
                BOOST_REQUIRE(faces.found.special == 0U);
                const points::DeviceSignFaces surface = points::make_sign_faces(made.tools, faces, rule);
                BOOST_REQUIRE(surface.are_exact);
                const auto found = read<std::uint16_t>(
                    made.context, *points::find_face_sides(made.tools, faces, made.made.tree, surface).sides,
                    faces.count);
                const engine::PointMesh on_host =
                    engine::make_point_mesh(made.tools, mesh, {}, std::make_shared<const engine::MeshTopology>(mesh));
                const engine::WideTree wide = engine::make_wide_tree(on_host);
                const auto expected = read<std::uint16_t>(
                    made.context, *points::find_face_sides(made.tools, engine::SearchedMesh{on_host, wide}, rule).sides,
                    faces.count);
                BOOST_TEST(found == expected, boost::test_tools::per_element());
                if (mesh.name() == "cubes") BOOST_TEST(std::ranges::count(found, 0) == 0);
            }
    }
}

BOOST_AUTO_TEST_CASE(special_cases_are_left_to_the_host) {
    const Mesh flat = together({cube(1), Mesh({{0, 0, 0}, {1, 1, 1}}, {{0, 1, 1}}, "segment")}, "with a segment");
    BOOST_TEST(Made(flat).faces.found.special == 1U);
}

BOOST_AUTO_TEST_CASE(coordinates_out_of_range_are_counted) {
    std::vector<Vec3> vertices = cube(1).vertices();
    vertices[0][1] = 1e-200;
    const Made made(Mesh(vertices, cube(1).triangles(), "cube"));
    BOOST_TEST(made.faces.found.inexact == 1U);
    BOOST_TEST(made.faces.found.immoderate == 1U);
}
