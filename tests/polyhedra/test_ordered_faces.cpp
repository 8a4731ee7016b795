#include "polyhedra/face_order.hpp"
#include "polyhedra/topology.hpp"
#include "support/random_meshes.hpp"
#include "support/test_meshes.hpp"

#include <clsdf/mesh.hpp>

#include <boost/test/unit_test.hpp>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace clsdf::test {
namespace {

using polyhedra::OrderedFaces;
using Rings = std::vector<std::vector<std::uint32_t>>;

/// Calls f() with this number of threads, also if there are fewer cores.
template <typename Function>
void with_threads(std::size_t threads, const Function& f) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    tbb::task_arena(static_cast<int>(threads)).execute(f);
}

OrderedFaces plainly_ordered(const Mesh& mesh, std::span<const std::uint32_t> order) {
    OrderedFaces faces;
    std::vector<std::uint32_t> numbers(mesh.vertices().size(), UINT32_MAX);
    for (std::size_t face = 0; face < order.size(); ++face) {
        Triangle triangle = mesh.triangles()[order[face]];
        for (std::uint32_t& vertex : triangle) {
            if (numbers[vertex] == UINT32_MAX) {
                numbers[vertex] = static_cast<std::uint32_t>(faces.vertices.size());
                faces.vertices.push_back(vertex);
            }
            vertex = numbers[vertex];
        }
        faces.triangles.push_back(triangle);
    }
    return faces;
}

Rings plain_rings(std::span<const Triangle> triangles, std::size_t vertex_count) {
    Rings rings(vertex_count);
    for (std::uint32_t face = 0; face < triangles.size(); ++face)
        for (std::uint32_t k = 0; k < 3; ++k) rings[triangles[face][k]].push_back(Corner{face, k}.packed());
    return rings;
}

bool are_same(const OneRings& rings, const Rings& expected) {
    if (rings.vertex_count() != expected.size()) return false;
    for (std::size_t vertex = 0; vertex < expected.size(); ++vertex) {
        if (rings.size(vertex) != expected[vertex].size()) return false;
        for (std::size_t i = 0; i < expected[vertex].size(); ++i)
            if (rings.corner(vertex, i).packed() != expected[vertex][i]) return false;
    }
    return true;
}

/// Faces of a fan around the first vertex, which all chunks share, in an order that leaps to and fro.
Mesh fan(std::uint32_t count) {
    std::vector<Vec3> vertices{{0, 0, 0}};
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
        const double angle = 6.283185307179586 * i / count;
        vertices.push_back({std::cos(angle), std::sin(angle), 0.1});
        const std::uint32_t spoke = static_cast<std::uint32_t>(std::uint64_t{i} * 7919 % count);
        triangles.push_back({0, 1 + spoke, 1 + (spoke + 1) % count});
    }
    return {std::move(vertices), std::move(triangles), "fan"};
}

Mesh first_faces(const Mesh& mesh, std::size_t count) {
    return {mesh.vertices(),
            {mesh.triangles().begin(), mesh.triangles().begin() + static_cast<std::ptrdiff_t>(count)},
            std::to_string(count) + " faces of " + mesh.name()};
}

std::vector<Mesh> meshes_of_every_kind() {
    Random random(3);
    const Mesh closed = make_shape("sphere6");
    const Mesh shuffled = random_soup(random, 3000, 60000);
    std::vector<Mesh> meshes{closed, make_shape("noisy"), first_faces(closed, 20000), fan(100000)};
    for (const std::size_t count : {1U, 3072U, 3073U}) meshes.push_back(first_faces(shuffled, count));
    meshes.push_back(shuffled);
    // All parts name the same few vertices, or many name none.
    meshes.push_back(random_soup(random, 20, 50000));
    meshes.push_back(random_soup(random, 200000, 30000));
    // Long enough for threads to run side by side.
    meshes.push_back(make_shape("sphere8"));
    meshes.push_back(random_soup(random, 200000, 200000));
    return meshes;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(ordered_faces_and_rings)

BOOST_AUTO_TEST_CASE(vertices_are_numbered_as_one_thread_numbers_them) {
    for (const Mesh& mesh : meshes_of_every_kind()) {
        const auto order = polyhedra::morton_order(mesh);
        const OrderedFaces expected = plainly_ordered(mesh, order);
        for (const std::size_t threads : {1U, 2U, 16U})
            for (int time = 0; time < 5; ++time) {
                BOOST_TEST_CONTEXT(mesh.name() << ", " << threads << " threads, time " << time) {
                    with_threads(threads, [&] {
                        const OrderedFaces found = polyhedra::ordered_faces(mesh, order);
                        BOOST_TEST((found.triangles == expected.triangles));
                        BOOST_TEST((found.vertices == expected.vertices));
                    });
                }
            }
    }
}

BOOST_AUTO_TEST_CASE(rings_are_filed_as_one_thread_files_them) {
    for (const Mesh& mesh : meshes_of_every_kind()) {
        const OrderedFaces ordered = plainly_ordered(mesh, polyhedra::morton_order(mesh));
        const Rings expected = plain_rings(ordered.triangles, ordered.vertices.size());
        const Rings expected_of_mesh = plain_rings(mesh.triangles(), mesh.vertices().size());
        for (const std::size_t threads : {1U, 2U, 16U}) {
            BOOST_TEST_CONTEXT(mesh.name() << ", " << threads << " threads") {
                with_threads(threads, [&] {
                    BOOST_TEST(are_same(OneRings(ordered.triangles, ordered.vertices.size()), expected));
                    BOOST_TEST(are_same(OneRings(mesh.triangles(), mesh.vertices().size()), expected_of_mesh));
                });
            }
        }
    }
}

BOOST_AUTO_TEST_SUITE_END()

}  // namespace clsdf::test
