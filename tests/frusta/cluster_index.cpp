#include "frusta/cluster_index.hpp"

#include "awkward_meshes.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

// A call pays for the clusters near its box, and misses none of them.

namespace clsdf::test {
namespace {

using engine::ClusterIndex;
using engine::NearRecords;
using engine::record_group;
using engine::RecordRange;
using engine::Vector;

constexpr double infinity = std::numeric_limits<double>::infinity();

bool boxes_overlap(const Box& a, const Box& b) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (a.lower[axis] > b.upper[axis] || b.lower[axis] > a.upper[axis]) return false;
    return true;
}

Box grown(Box box, double by) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] -= by;
        box.upper[axis] += by;
    }
    return box;
}

Box around(const Vec3& centre, double reach) {
    return grown({centre, centre}, reach);
}

/// Around the ball of a face, whose centre is the foot of the altitude on the longest edge.
Box ball_box(const std::array<Vec3, 3>& corners) {
    const std::array at{engine::to_vector(corners[0]), engine::to_vector(corners[1]), engine::to_vector(corners[2])};
    std::size_t base = 0;
    for (std::size_t k = 1; k < 3; ++k)
        if ((at[(k + 1) % 3] - at[k]).norm() > (at[(base + 1) % 3] - at[base]).norm()) base = k;
    const Vector edge = at[(base + 1) % 3] - at[base];
    const double along = edge.norm() > 0 ? (at[(base + 2) % 3] - at[base]).dot(edge) / edge.squaredNorm() : 0;
    const Vector foot = at[base] + along * edge;
    double radius = 0;
    for (const Vector& corner : at) radius = std::max(radius, (corner - foot).norm());
    return around({foot[0], foot[1], foot[2]}, radius * (1 - 1e-12));
}

/// The index of a mesh, and a box of each face, of each cluster, and of each point site.
struct Indexed {
    explicit Indexed(const Mesh& mesh)
        : topology(mesh),
          frusta(engine::make_frusta(topology, mesh.vertices())),
          index(topology.order.size(), engine::cluster_boxes(topology.faces.triangles, frusta.positions), frusta) {
        for (const auto& [a, b, c] : topology.faces.triangles)
            faces.push_back(ball_box({frusta.positions[a], frusta.positions[b], frusta.positions[c]}));
        for (std::size_t face = 0; face < faces.size(); ++face) {
            if (face % ClusterIndex::cluster == 0)
                clusters.push_back({{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}});
            Box& cluster = clusters.back();
            for (std::size_t axis = 0; axis < 3; ++axis) {
                cluster.lower[axis] = std::min(cluster.lower[axis], faces[face].lower[axis]);
                cluster.upper[axis] = std::max(cluster.upper[axis], faces[face].upper[axis]);
            }
        }
        for (const auto& site : frusta.sites) sites.push_back(around(frusta.positions[site.vertex], 0));
    }

    engine::MeshTopology topology;
    engine::Frusta frusta;
    ClusterIndex index;
    std::vector<Box> faces, clusters, sites;
};

/// Which of `count` are in the ranges, which ascend without overlap, in whole groups.
std::vector<bool> listed(const std::vector<RecordRange>& ranges, std::size_t group, std::size_t count) {
    std::vector<bool> is_listed(count);
    std::size_t end = 0;
    for (const RecordRange& range : ranges) {
        BOOST_TEST(range.begin >= end);
        BOOST_TEST(range.begin % group == 0U);
        BOOST_TEST((range.end % group == 0 || range.end == count));
        BOOST_TEST_REQUIRE(range.end <= count);
        end = range.end;
        std::fill(is_listed.begin() + static_cast<std::ptrdiff_t>(range.begin),
                  is_listed.begin() + static_cast<std::ptrdiff_t>(range.end), true);
    }
    return is_listed;
}

struct Counts {
    std::size_t missed_faces = 0, missed_sites = 0, needless_clusters = 0, near = 0, far = 0, sites = 0;
};

void search(const Indexed& mesh, const Box& box, Counts& counts) {
    const NearRecords near = mesh.index.near(box);
    const std::vector<bool> faces = listed(near.faces, ClusterIndex::cluster, mesh.faces.size()),
                            sites = listed(near.sites, record_group, mesh.sites.size());
    BOOST_TEST(near.face_count == static_cast<std::size_t>(std::count(faces.begin(), faces.end(), true)));
    BOOST_TEST(near.site_count == static_cast<std::size_t>(std::count(sites.begin(), sites.end(), true)));
    for (std::size_t face = 0; face < mesh.faces.size(); ++face)
        counts.missed_faces += boxes_overlap(mesh.faces[face], box) && !faces[face] ? 1U : 0U;
    for (std::size_t site = 0; site < mesh.sites.size(); ++site) {
        counts.missed_sites += boxes_overlap(mesh.sites[site], box) && !sites[site] ? 1U : 0U;
        counts.sites += sites[site] ? 1U : 0U;
    }
    for (std::size_t n = 0; n < mesh.clusters.size(); ++n) {
        const Box& cluster = mesh.clusters[n];
        // The index takes the altitude of a face as 0.8661 of its longest edge, so its boxes may be 0.73 wider.
        const double side = cluster.longest_side();
        const bool is_found = faces[n * ClusterIndex::cluster];
        counts.needless_clusters += is_found && !boxes_overlap(grown(cluster, 0.37 * side), box) ? 1U : 0U;
        (is_found ? counts.near : counts.far) += 1;
    }
}

/// Triangles of a thousandth of the mesh and triangles as large as it, slivers, and vertices with point sites.
std::vector<Mesh> meshes_of_all_sizes() {
    Random random(3);
    std::vector<Mesh> parts{make_shape("sphere5"), scaled(tilted(cube(1)), 40), shifted(make_shape("knot"), {9, 4, 1}),
                            random_soup(random, 300, 900), random_slivers(random, 900)};
    for (int n = 0; n < 40; ++n) parts.push_back(shifted(random_fan(random), random.point(-30, 30)));
    const Mesh all = together(parts, "small and large triangles");
    return {all, shifted(all, {1e7, -1e7, 1e6}), make_shape("sphere6"), cube(1)};
}

BOOST_AUTO_TEST_SUITE(cluster_index)

BOOST_AUTO_TEST_CASE(the_search_misses_no_face_and_finds_little_else) {
    for (const Mesh& mesh : meshes_of_all_sizes()) {
        BOOST_TEST_CONTEXT(mesh.name() << ", " << mesh.triangles().size() << " triangles") {
            const Indexed indexed(mesh);
            const Box& all = mesh.box();
            const double side = all.longest_side();
            Random random(5);
            Counts counts;
            for (int n = 0; n < 300; ++n) {
                const Triangle& triangle = mesh.triangles()[random.index(mesh.triangles().size())];
                Vec3 centre = mesh.vertices()[triangle[random.index(3)]];
                if (n % 2 == 0)
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        centre[axis] = random.uniform(all.lower[axis] - 0.1 * side, all.upper[axis] + 0.1 * side);
                search(indexed, around(centre, n % 5 == 0 ? 0 : side * std::pow(10, random.uniform(-5, -1))), counts);
            }
            BOOST_TEST(counts.missed_faces == 0U);
            BOOST_TEST(counts.missed_sites == 0U);
            BOOST_TEST(counts.needless_clusters == 0U);
            BOOST_TEST(counts.near > 0U);
            BOOST_TEST((counts.far > counts.near || mesh.triangles().size() < 1000));
            BOOST_TEST((counts.sites > 0 || indexed.sites.empty()));
            search(indexed, grown(all, side), counts);
            BOOST_TEST(indexed.index.near(grown(all, side)).face_count == indexed.faces.size());
            BOOST_TEST(
                indexed.index.near(around({all.upper[0] + 3 * side, all.upper[1], all.upper[2]}, 0)).face_count == 0U);
        }
    }
}

// A box that a face just meets, on every side: the search may not be narrower than the face.
BOOST_AUTO_TEST_CASE(a_box_that_only_meets_a_cluster_finds_it) {
    for (const Mesh& mesh : meshes_of_all_sizes()) {
        const Indexed indexed(mesh);
        Counts counts;
        for (std::size_t n = 0; n < indexed.clusters.size(); n += 1 + indexed.clusters.size() / 200) {
            const Box& cluster = indexed.clusters[n];
            for (std::size_t axis = 0; axis < 3; ++axis) {
                Box above = cluster, below = cluster;
                above.lower[axis] = cluster.upper[axis];
                above.upper[axis] = cluster.upper[axis] + mesh.box().longest_side();
                below.upper[axis] = cluster.lower[axis];
                below.lower[axis] = cluster.lower[axis] - mesh.box().longest_side();
                search(indexed, above, counts);
                search(indexed, below, counts);
            }
        }
        BOOST_TEST(counts.missed_faces == 0U, mesh.name());
        BOOST_TEST(counts.missed_sites == 0U, mesh.name());
    }
}

BOOST_AUTO_TEST_SUITE_END()

}  // namespace
}  // namespace clsdf::test
