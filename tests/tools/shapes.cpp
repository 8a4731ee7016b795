#include <clsdf/error.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/topology.hpp>

#include "support/throws.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace clsdf {

using test::check_throws;

namespace {

double volume(const Mesh& mesh) {
    double six_volumes = 0;
    for (const auto& [i, j, k] : mesh.triangles()) {
        const Vec3& a = mesh.vertices()[i];
        const Vec3& b = mesh.vertices()[j];
        const Vec3& c = mesh.vertices()[k];
        six_volumes += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                       a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return six_volumes / 6;
}

/// The number of vertices with both convex and concave edges, decided exactly, on a closed manifold mesh.
int saddle_count(const Mesh& mesh) {
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    const auto point = [&](std::uint32_t index) {
        const Vec3& v = mesh.vertices()[index];
        return Kernel::Point_3(v[0], v[1], v[2]);
    };
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> opposite;
    for (const Triangle& t : mesh.triangles())
        for (std::size_t k = 0; k < 3; ++k) opposite[{t[k], t[(k + 1) % 3]}] = t[(k + 2) % 3];
    std::vector<std::set<CGAL::Orientation>> kinds(mesh.vertices().size());
    for (const auto& [edge, apex] : opposite) {
        const std::uint32_t other = opposite.at({edge.second, edge.first});
        const CGAL::Orientation kind =
            CGAL::orientation(point(edge.first), point(edge.second), point(apex), point(other));
        if (kind == CGAL::COPLANAR) continue;
        kinds[edge.first].insert(kind);
        kinds[edge.second].insert(kind);
    }
    return static_cast<int>(std::count_if(kinds.begin(), kinds.end(), [](const auto& k) { return k.size() == 2; }));
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_shape_is_closed_balanced_and_looks_outwards) {
    for (const ShapeName& shape : shape_names()) {
        BOOST_TEST_CONTEXT(shape.name) {
            BOOST_TEST(!shape.description.empty());
            const Mesh mesh = make_shape(shape.name);
            const Topology topology = describe_topology(mesh);
            BOOST_TEST(mesh.name() == shape.name);
            BOOST_TEST(topology.closed);
            BOOST_TEST(topology.balanced);
            BOOST_TEST(!topology.inside_out);
            BOOST_TEST(topology.non_manifold_edges == 0U);
            BOOST_TEST(topology.coincident_vertices == 0U);
            BOOST_TEST(topology.repeated_vertex_faces == 0U);
            BOOST_TEST(topology.unused_vertices == 0U);
            BOOST_TEST(volume(mesh) > 0);
        }
    }
}

BOOST_AUTO_TEST_CASE(the_shapes_of_the_paper_have_its_numbers_of_vertices) {
    BOOST_TEST(make_shape("sphere6").vertices().size() == 16386U);
    BOOST_TEST(make_shape("sphere6").triangles().size() == 32768U);
    BOOST_TEST(make_shape("torus").vertices().size() == 3000U);
    BOOST_TEST(make_shape("knot").vertices().size() == 1440U);
    BOOST_TEST(make_shape("seashell").vertices().size() == 915U);
    BOOST_TEST(make_shape("sphere0").triangles().size() == 8U);
    BOOST_TEST(make_shape("sphere9").triangles().size() == 2097152U);
}

BOOST_AUTO_TEST_CASE(the_shapes_of_the_paper_have_saddles_as_its_table_says) {
    // Peikert & Sigg, table 1: 0, 1788, 1378 and 843.
    BOOST_TEST(saddle_count(make_shape("sphere6")) == 0);
    BOOST_TEST(saddle_count(make_shape("torus")) == 1788);
    BOOST_TEST(saddle_count(make_shape("knot")) == 1377);
    BOOST_TEST(saddle_count(make_shape("seashell")) == 879);
}

BOOST_AUTO_TEST_CASE(volumes_are_those_of_the_solids) {
    constexpr double pi = 3.14159265358979323846;
    BOOST_TEST(volume(make_shape("cube")) == 1.0, boost::test_tools::tolerance(1e-12));
    BOOST_TEST(volume(make_shape("sphere6")) == 4 * pi / 3, boost::test_tools::tolerance(1e-3));
    BOOST_TEST(volume(make_shape("torus")) == 2 * pi * pi / 9, boost::test_tools::tolerance(0.02));
    BOOST_TEST(volume(make_shape("plate")) == 0.0075, boost::test_tools::tolerance(1e-9));
    BOOST_TEST(volume(make_shape("plate1e-6")) == 0.75e-6, boost::test_tools::tolerance(1e-6));
    BOOST_TEST(volume(make_shape("nested")) == 4 * pi / 3 * (1 - 0.343 + 0.064), boost::test_tools::tolerance(0.01));
    // A column of height 1 + 0.12 i for each of the 24 steps, 8 deep.
    BOOST_TEST(volume(make_shape("stairs")) == 8 * (24 + 0.12 * 276), boost::test_tools::tolerance(1e-12));
    BOOST_TEST(volume(make_shape("step")) == 20 * (20 * 10 + 10 * 0.01), boost::test_tools::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(a_plate_has_the_thickness_of_its_name) {
    const Mesh plate = make_shape("plate0.25");
    BOOST_TEST(volume(plate) == 0.25 * 0.75, boost::test_tools::tolerance(1e-12));
    BOOST_TEST(describe_topology(plate).balanced);
    for (const char* name : {"plate0", "plate-1", "plate2"})
        BOOST_TEST_CONTEXT(name) check_throws(ErrorCode::invalid_argument, {"thickness"}, [&] { make_shape(name); });
    for (const char* name : {"plateinf", "platenan", "plate 0.1", "plate0.1x"})
        BOOST_TEST_CONTEXT(name) check_throws(ErrorCode::invalid_argument, {"no shape"}, [&] { make_shape(name); });
}

BOOST_AUTO_TEST_CASE(a_mistyped_name_is_answered_with_the_nearest_one) {
    check_throws(ErrorCode::invalid_argument, {"'tours'", "'torus'"}, [] { make_shape("tours"); });
    check_throws(ErrorCode::invalid_argument, {"'seashel'", "'seashell'"}, [] { make_shape("seashel"); });
    check_throws(ErrorCode::invalid_argument, {"'spheer6'", "'sphere6'"}, [] { make_shape("spheer6"); });
    check_throws(ErrorCode::invalid_argument, {"'sphere'", "'sphere0'"}, [] { make_shape("sphere"); });
    check_throws(ErrorCode::invalid_argument, {"plate2x"}, [] { make_shape("plate2x"); });
    check_throws(ErrorCode::invalid_argument, {"''"}, [] { make_shape(""); });
}

}  // namespace clsdf
