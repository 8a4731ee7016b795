#include "benchmarks/meshes.hpp"

#include <clsdf/clsdf.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <set>

using namespace clsdf;
using namespace clsdf::bench;

namespace {

double area_of(const Mesh& mesh) {
    double sum = 0;
    for (const Triangle& t : mesh.triangles()) {
        const Vec3 &a = mesh.vertices()[t[0]], &b = mesh.vertices()[t[1]], &c = mesh.vertices()[t[2]];
        const Vec3 u{b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v{c[0] - a[0], c[1] - a[1], c[2] - a[2]};
        sum += std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 2;
    }
    return sum;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(bench_meshes)

BOOST_AUTO_TEST_CASE(the_noisy_sphere_is_closed_faces_outwards_and_its_seed_decides_it) {
    const Mesh mesh = noisy_sphere(71, 0.5, 7);
    BOOST_TEST(mesh.triangles().size() == 20U * 71 * 71);
    BOOST_TEST(mesh.vertices().size() == mesh.triangles().size() / 2 + 2);
    const Topology topology = describe_topology(mesh);
    BOOST_TEST(topology.balanced);
    BOOST_TEST(!topology.inside_out);
    BOOST_TEST((mesh.vertices() == noisy_sphere(71, 0.5, 7).vertices()));
    BOOST_TEST((mesh.vertices() != noisy_sphere(71, 0.5, 8).vertices()));
}

BOOST_AUTO_TEST_CASE(noise_of_half_an_edge_moves_vertices_by_half_an_edge) {
    const double edge = std::sqrt(16 * 3.141592653589793 / (std::sqrt(3.0) * 20 * 71 * 71));
    double most = 0;
    const Mesh mesh = noisy_sphere(71, 0.5, 1);
    for (const Vec3& v : mesh.vertices()) most = std::max(most, std::abs(std::hypot(v[0], v[1], v[2]) - 1));
    BOOST_TEST(most < 0.5 * edge);
    BOOST_TEST(most > 0.49 * edge);
}

BOOST_AUTO_TEST_CASE(without_noise_its_triangles_are_much_alike) {
    const Mesh mesh = noisy_sphere(20, 0, 1);
    BOOST_TEST(std::abs(area_of(mesh) - 4 * 3.141592653589793) < 0.02);
}

BOOST_AUTO_TEST_CASE(triangles_split_in_four_are_the_same_surface) {
    const Mesh mesh = make_shape("sphere3"), split = split_triangles(mesh);
    BOOST_TEST(split.triangles().size() == 4 * mesh.triangles().size());
    BOOST_TEST(split.vertices().size() == mesh.vertices().size() + 3 * mesh.triangles().size() / 2);
    BOOST_TEST(describe_topology(split).balanced);
    BOOST_TEST(std::abs(area_of(split) - area_of(mesh)) < 1e-12);
}

BOOST_AUTO_TEST_CASE(every_name_is_known_once) {
    const std::vector<std::string> names = mesh_names();
    BOOST_TEST(std::set<std::string>(names.begin(), names.end()).size() == names.size());
    for (const std::string& standard : standard_meshes())
        BOOST_TEST(std::count(names.begin(), names.end(), standard) == 1, standard);
    BOOST_TEST(std::count(names.begin(), names.end(), "knot") == 1);
}

BOOST_AUTO_TEST_CASE(a_mesh_that_was_not_fetched_is_named_with_the_remedy) {
    BOOST_CHECK_EXCEPTION(load_mesh("bunny00", "/nonexistent", 1), Error, [](const Error& error) {
        const std::string what = error.what();
        return error.code() == ErrorCode::unreadable_input && what.find("bunny00.off") != std::string::npos &&
               what.find("scripts/fetch-meshes") != std::string::npos;
    });
}

BOOST_AUTO_TEST_SUITE_END()
