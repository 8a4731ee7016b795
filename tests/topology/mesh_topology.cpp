// The topology that kernels make of a mesh has the bytes of the host's, which is its specification.
#include "frusta/awkward_meshes.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/test_meshes.hpp"

#include "checks/known_topology.hpp"
#include "device/buffer_pool.hpp"
#include "launch/programs.hpp"

#include <clsdf/io.hpp>
#include <clsdf/tuning.hpp>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

/// Makes topologies by the kernels for GPUs.
class Kernels {
public:
    void check(const Mesh& mesh) const {
        const std::optional<std::string> difference = checks::topology_difference(job_, mesh);
        BOOST_TEST(!difference.has_value(),
                   mesh.name() << ", " << mesh.triangles().size() << " triangles: " << difference.value_or(""));
    }
    std::optional<std::string> sweep_difference() const { return checks::sweep_difference(job_); }
    bool refuses(const Mesh& mesh) const { return !engine::make_device_topology(job_, mesh).has_value(); }

private:
    device::Context& context_ = device::context_of(test_device());
    std::shared_ptr<device::BufferPool> pool_ =
        std::make_shared<device::BufferPool>(device::shared_context_of(test_device()));
    engine::Programs programs_{context_, KernelBody::by_group};
    engine::DeviceSetUp job_{engine::DeviceTools{context_, pool_, programs_}};
};

/// Triangles at random over few vertices, of which many are equal: edges and faces of all kinds.
Mesh chaos(Random& random, std::size_t vertex_count, std::size_t triangle_count) {
    std::vector<Vec3> vertices;
    for (std::size_t i = 0; i < vertex_count; ++i)
        vertices.push_back({static_cast<double>(random.index(9)) - 4, -0.25 * static_cast<double>(random.index(9)),
                            static_cast<double>(random.index(3))});
    std::vector<Triangle> triangles(triangle_count);
    for (Triangle& triangle : triangles)
        for (std::uint32_t& vertex : triangle) vertex = static_cast<std::uint32_t>(random.index(vertex_count));
    return {std::move(vertices), std::move(triangles), "chaos"};
}

/// Faces that share an edge.
Mesh book(std::uint32_t pages) {
    std::vector<Vec3> vertices{{0, 0, 0}, {0, 0, 1}};
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < pages; ++i) {
        vertices.push_back({std::cos(0.01 * i), std::sin(0.01 * i), 0.5});
        triangles.push_back({0, 1, 2 + i});
    }
    return {std::move(vertices), std::move(triangles), "book"};
}

}  // namespace

BOOST_AUTO_TEST_CASE(shapes_have_the_topology_of_the_host) {
    const Kernels kernels;
    kernels.check(checks::mesh_of_known_topology());
    for (const char* shape : {"cube", "sphere5", "torus", "knot"}) {
        kernels.check(make_shape(shape));
        kernels.check(reversed(make_shape(shape)));
        kernels.check(unwelded(make_shape(shape)));
    }
    for (const Counterexample& one : all_counterexamples()) kernels.check(one.mesh);
}

// For patches: a part of the faces, each with vertices of its own.
BOOST_AUTO_TEST_CASE(the_sweep_of_some_clusters_has_the_vertices_of_the_host) {
    BOOST_TEST(!Kernels().sweep_difference().has_value());
}

BOOST_AUTO_TEST_CASE(hostile_meshes_have_the_topology_of_the_host) {
    const Kernels kernels;
    const unsigned seed = std::random_device()();
    Random random(seed);
    BOOST_TEST_CONTEXT("seed " << seed) {
        kernels.check({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, "one"});
        // Zeros of both signs, a vertex without use that equals others and comes first, one without use that is no
        // number.
        kernels.check({{{-0.0, 0, 0},
                        {std::nan(""), 1, 2},
                        {0, 0, 0},
                        {1, 0, 0},
                        {0, 1, 0},
                        {0, -0.0, 0},
                        {1, 0, -0.0},
                        {0, 0, 1}},
                       {{2, 3, 4}, {5, 7, 6}, {5, 4, 7}},
                       "zeros"});
        // Equal to a vertex in use, but alone in use: nothing is merged.
        kernels.check({{{-0.0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{1, 2, 3}}, "equal without use"});
        kernels.check({std::vector<Vec3>(3000, {1, -2, 3}), std::vector<Triangle>(2000, {7, 300, 2999}), "all equal"});
        kernels.check(scaled(make_shape("sphere3"), 1e-320));
        kernels.check(scaled(make_shape("sphere3"), 8e307));
        kernels.check(shifted(make_shape("sphere3"), {1e15, 0, -1e14}));
        kernels.check(together({make_shape("sphere3"), shifted(make_shape("cube"), {5, 0, 0})}, "two parts"));
        kernels.check(book(3000));
        kernels.check(cone(2000));
        kernels.check(moebius_strip(50));
        kernels.check(fins());
        kernels.check(chaos(random, 5, 1000));
        for (const std::size_t vertices : {40U, 3000U}) kernels.check(chaos(random, vertices, 7000));
        for (int i = 0; i < 100; ++i) kernels.check(awkward_mesh(random));
    }
}

// More tiles than a work-group has work-items, and codes of 30 bits.
BOOST_AUTO_TEST_CASE(a_mesh_of_many_triangles_has_the_topology_of_the_host) {
    const Kernels kernels;
    kernels.check(make_shape("sphere7"));
}

// Work-items would look at all faces around a vertex, for each of them.
BOOST_AUTO_TEST_CASE(too_many_faces_at_both_ends_of_an_edge_are_refused) {
    BOOST_TEST(Kernels().refuses(book(CLSDF_MOST_RING + 1)));
    BOOST_TEST(!Kernels().refuses(cone(2 * CLSDF_MOST_RING)));
}

// CLSDF_TOPOLOGY_FILES: a folder of meshes, which takes longer.
BOOST_AUTO_TEST_CASE(files_have_the_topology_of_the_host) {
    const char* const folder = std::getenv("CLSDF_TOPOLOGY_FILES");
    if (folder == nullptr) return;
    const Kernels kernels;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        if (!entry.is_regular_file()) continue;
        std::optional<Mesh> mesh;
        try {
            mesh = read_mesh(entry.path().string());
        } catch (const Error&) {
            continue;  // not a mesh
        }
        kernels.check(*mesh);
    }
}
