#pragma once

#include <clsdf/topology.hpp>

#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <vector>

namespace clsdf::test {

inline bool are_same(const std::vector<Topology::Edge>& a, const std::vector<Topology::Edge>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const Topology::Edge& one, const Topology::Edge& other) {
                          return one.from == other.from && one.to == other.to;
                      });
}

/// Compares the counts and the first edges; not what follows from them.
inline void check_same_counts(const Topology& found, const Topology& expected) {
    BOOST_TEST(found.open_edges == expected.open_edges);
    BOOST_TEST(found.unbalanced_edges == expected.unbalanced_edges);
    BOOST_TEST(found.non_manifold_edges == expected.non_manifold_edges);
    BOOST_TEST(found.repeated_vertex_faces == expected.repeated_vertex_faces);
    BOOST_TEST(found.coincident_vertices == expected.coincident_vertices);
    BOOST_TEST(found.unused_vertices == expected.unused_vertices);
    BOOST_TEST(found.boundary_edges == expected.boundary_edges);
    BOOST_TEST(found.joined_vertices == expected.joined_vertices);
    BOOST_TEST(found.uncounted_faces == expected.uncounted_faces);
    BOOST_TEST(found.reoriented_faces == expected.reoriented_faces);
    BOOST_TEST(are_same(found.first_open_edges, expected.first_open_edges));
    BOOST_TEST(are_same(found.first_unbalanced_edges, expected.first_unbalanced_edges));
}

}  // namespace clsdf::test
