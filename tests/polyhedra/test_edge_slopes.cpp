#include "coverage.hpp"
#include "polyhedra/edge_slopes.hpp"
#include "polyhedra/edges.hpp"
#include "polyhedra/gaps.hpp"
#include "polyhedra/lateral_planes.hpp"
#include "polyhedra/morton_order.hpp"
#include "support/random_meshes.hpp"
#include "support/test_meshes.hpp"

#include <clsdf/mesh.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <numeric>
#include <utility>

namespace clsdf::test {
namespace {

using polyhedra::LatticeView;

/// The slopes of a mesh's faces, measured in sub-ranges of a given size.
struct Edges {
    polyhedra::OneRings rings;
    polyhedra::PairedEdges paired;
    std::vector<polyhedra::FaceSlopes> slopes;
    std::vector<polyhedra::FramePlanes::Directions> directions;

    Edges(const polyhedra::MeshFaces& faces, std::size_t size)
        : rings(faces.triangles, faces.positions.size()), paired(pair_edges(faces.triangles, rings)) {
        const auto of_non_manifold = non_manifold_slopes(faces, rings, paired, CLSDF_OPEN_SLOPE);
        polyhedra::EdgeSlopes stretch(faces, paired.faces, of_non_manifold, CLSDF_OPEN_SLOPE);
        for (std::size_t begin = 0; begin < faces.triangles.size(); begin += size) {
            stretch.measure(begin, std::min(faces.triangles.size(), begin + size));
            for (std::size_t face = stretch.begin(); face < stretch.end(); ++face) {
                lean(stretch.frame(face), stretch.slopes(face));
                slopes.push_back(stretch.slopes(face));
                directions.push_back({stretch.frame(face).normal, stretch.frame(face).inwards});
            }
        }
    }
};

/// Flat here and there, so that frames do not tell on which side faces lie.
Mesh pleated_sheet(Random& random) {
    constexpr std::uint32_t side = 40;
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (std::uint32_t j = 0; j < side; ++j)
        for (std::uint32_t i = 0; i < side; ++i)
            vertices.push_back({0.1 * i, 0.1 * j, 0.05 * static_cast<double>(random.index(2) * (i % 3))});
    for (std::uint32_t j = 0; j + 1 < side; ++j)
        for (std::uint32_t i = 0; i + 1 < side; ++i) {
            const std::uint32_t v = j * side + i;
            triangles.push_back({v, v + 1, v + side + 1});
            triangles.push_back({v, v + side + 1, v + side});
        }
    return {std::move(vertices), std::move(triangles), "pleated sheet"};
}

/// With edges along which both faces run the same way.
Mesh with_turned_faces(const Mesh& mesh, Random& random) {
    std::vector<Triangle> triangles = mesh.triangles();
    for (Triangle& triangle : triangles)
        if (random.index(3) == 0) std::swap(triangle[0], triangle[1]);
    return {mesh.vertices(), std::move(triangles), mesh.name() + " with turned faces"};
}

BOOST_AUTO_TEST_SUITE(edge_slopes)

// In a soup all kinds of edges are at the borders, too: open, folded, unoriented, not manifold, and beside boxes.
BOOST_AUTO_TEST_CASE(edges_are_the_same_wherever_stretches_begin) {
    Random random(4);
    const LatticeView lattice{{-1, -1, -1}, 0.125};
    for (const Mesh& mesh : {make_shape("noisy"), with_turned_faces(make_shape("noisy"), random), make_shape("stairs"),
                             pleated_sheet(random), with_turned_faces(pleated_sheet(random), random),
                             random_soup(random, 300, 2000), random_slivers(random, 1000), random_closed(random, 3)}) {
        BOOST_TEST_CONTEXT(mesh.name()) {
            const polyhedra::MeshFaces faces{mesh.vertices(), mesh.triangles(), lattice};
            const Edges whole(faces, mesh.triangles().size());
            for (const std::size_t size : {1U, 7U, 100U, 1003U}) {
                const Edges parts(faces, size);
                std::size_t different = 0;
                for (std::size_t face = 0; face < mesh.triangles().size(); ++face) {
                    const polyhedra::FaceEdges& one = whole.paired.faces[face];
                    const polyhedra::FaceEdges& other = parts.paired.faces[face];
                    const bool same = one.marks == other.marks && one.base == other.base &&
                                      whole.slopes[face].above == parts.slopes[face].above &&
                                      whole.slopes[face].below == parts.slopes[face].below;
                    if (!same) ++different;
                }
                BOOST_TEST(different == 0U);
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(vertices_at_the_borders_of_stretches_are_judged_like_all_others) {
    const Mesh mesh = make_shape("noisy");
    BOOST_REQUIRE(mesh.triangles().size() > 4 * polyhedra::OrderedFaces::stretch);
    const LatticeView lattice{mesh.box().lower, 1.0 / 64};
    const LeanedFrusta frusta = leaned_frusta(mesh, lattice);

    // As one stretch, and every vertex by the full test.
    const polyhedra::MeshFaces faces{mesh.vertices(), mesh.triangles(), lattice};
    const Edges edges(faces, mesh.triangles().size());
    std::vector<std::uint32_t> vertices(mesh.vertices().size());
    std::iota(vertices.begin(), vertices.end(), 0U);
    std::vector<std::uint8_t> marks(vertices.size());
    find_gaps(faces, edges.paired.faces, edges.rings, polyhedra::FramePlanes(edges.directions, edges.slopes),
              polyhedra::rejection_margin, vertices, marks);
    const auto count = [&](std::uint8_t mark) {
        return static_cast<std::size_t>(
            std::count_if(marks.begin(), marks.end(), [mark](std::uint8_t of) { return (of & mark) != 0; }));
    };
    BOOST_TEST(frusta.saddle_vertices == count(polyhedra::vertex_saddle));
    BOOST_TEST(frusta.point_sites == count(polyhedra::vertex_gap));
    BOOST_TEST(frusta.saddle_vertices > 1000U);
}

BOOST_AUTO_TEST_CASE(ordered_faces_name_their_vertices_in_order) {
    Random random(5);
    for (const Mesh& mesh : {make_shape("noisy"), random_soup(random, 5000, 9000)}) {
        const auto order = polyhedra::morton_order(mesh);
        const polyhedra::OrderedFaces faces = polyhedra::ordered_faces(mesh, order);
        const std::size_t stretch = polyhedra::OrderedFaces::stretch;
        std::uint32_t named = 0;
        for (std::size_t face = 0; face < order.size(); ++face) {
            if (face % stretch == 0) BOOST_REQUIRE(faces.first_vertices[face / stretch] == named);
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t vertex = faces.triangles[face][k];
                BOOST_REQUIRE(vertex <= named);
                if (vertex == named) ++named;
                BOOST_REQUIRE(faces.vertices[vertex] == mesh.triangles()[order[face]][k]);
            }
        }
        BOOST_TEST(faces.vertices.size() == named);
        BOOST_TEST(faces.first_vertices.back() == named);
    }
}

BOOST_AUTO_TEST_SUITE_END()

}  // namespace
}  // namespace clsdf::test
