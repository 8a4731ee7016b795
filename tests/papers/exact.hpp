#pragma once

#include "papers/scanned.hpp"

#include <clsdf/tuning.hpp>

namespace clsdf::test {

/// Scanned by slices, with the polyhedra that the build names: exact, no empty intersection.
inline Scanned check_scanned(const Mesh& mesh, const Grid& grid, const Band& band, const Accuracy& accuracy = aimed,
                             KernelBody body = KernelBody::automatic) {
    Scanned scanned = scan_slices(mesh, grid, band, {.polyhedra = Polyhedra::CLSDF_SCANNED}, body);
    const reference::CheckReport report = check_exact(mesh, scanned.field, accuracy);
    BOOST_TEST(report.band_samples > 0U, "nothing of " << mesh.name() << " is in the band");
    check_intersections(scanned.statistics);
    return scanned;
}

inline void check_at_some_widths(const Mesh& mesh, std::int64_t resolution, KernelBody body = KernelBody::automatic) {
    for (const double share : {0.02, 0.1}) {
        const Band band = Band::symmetric(share * mesh.box().longest_side());
        check_scanned(mesh, Grid::around(mesh, resolution, band), band, aimed, body);
    }
}

}  // namespace clsdf::test
