#pragma once

#include "frusta/frusta.hpp"

#include <clsdf/topology.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// Values that are written to bytes and read from them, by an archive (core/archive.hpp).
namespace clsdf::engine {

/// A site without its normal's type, which is Eigen's.
struct StoredSite {
    std::uint32_t vertex, face;
    std::array<double, 3> normal;
    FaceSlopes slopes;
};

inline std::vector<StoredSite> stored_sites(std::span<const SiteFrustum> sites) {
    std::vector<StoredSite> stored;
    stored.reserve(sites.size());
    for (const SiteFrustum& site : sites)
        stored.push_back({site.vertex, site.face, {site.normal[0], site.normal[1], site.normal[2]}, site.slopes});
    return stored;
}

inline std::vector<SiteFrustum> sites_of(std::span<const StoredSite> stored) {
    std::vector<SiteFrustum> sites;
    sites.reserve(stored.size());
    for (const StoredSite& site : stored)
        sites.push_back({site.vertex, site.face, {site.normal[0], site.normal[1], site.normal[2]}, site.slopes});
    return sites;
}

template <typename Archive>
void visit_topology(Topology& t, Archive& archive) {
    for (bool* flag : {&t.closed, &t.balanced, &t.inside_out}) archive(*flag);
    for (std::size_t* count : {&t.open_edges,
                               &t.unbalanced_edges,
                               &t.non_manifold_edges,
                               &t.repeated_vertex_faces,
                               &t.coincident_vertices,
                               &t.unused_vertices,
                               &t.boundary_edges,
                               &t.joined_vertices,
                               &t.duplicate_faces,
                               &t.uncounted_faces,
                               &t.reoriented_faces,
                               &t.inner_wall_faces,
                               &t.first_inner_wall_face,
                               &t.parts,
                               &t.inward_parts,
                               &t.first_inward_face,
                               &t.nested_parts,
                               &t.first_nested_face,
                               &t.tested_points,
                               &t.doubtful_points,
                               &t.inside_points,
                               &t.unclear_parts,
                               &t.first_unclear_face,
                               &t.double_sided_faces,
                               &t.doubled_cavity_faces,
                               &t.first_doubled_cavity_face,
                               &t.sheet_faces,
                               &t.first_sheet_face,
                               &t.enclosing_faces,
                               &t.first_enclosing_face,
                               &t.overlapping_parts,
                               &t.first_overlapping_face,
                               &t.downward_faces,
                               &t.first_downward_face,
                               &t.rim_loops,
                               &t.overlapping_rim_edges,
                               &t.detail_parts,
                               &t.detail_faces,
                               &t.first_detail_face,
                               &t.partial_faces,
                               &t.hidden_faces})
        archive(*count);
    for (std::vector<Topology::Edge>* edges :
         {&t.first_open_edges, &t.first_unbalanced_edges, &t.first_overlapping_rim_edges})
        archive(*edges);
}

}  // namespace clsdf::engine
