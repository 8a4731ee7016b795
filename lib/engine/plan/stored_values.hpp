#pragma once

#include "frusta/frusta.hpp"

#include <clsdf/topology_table.h>
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
#define CLSDF_VISIT(member, meaning) archive(t.member);
    CLSDF_TOPOLOGY_COUNTS(CLSDF_VISIT)
#undef CLSDF_VISIT
    for (std::vector<Topology::Edge>* edges :
         {&t.first_open_edges, &t.first_unbalanced_edges, &t.first_overlapping_rim_edges})
        archive(*edges);
}

}  // namespace clsdf::engine
