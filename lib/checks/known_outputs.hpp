#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/outputs.hpp>

#include "outputs.h"
#include "polyhedron.h"
#include "targets/host_arrays.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace clsdf::checks {

/// A sample that is compared.
struct KnownSample {
    std::size_t at;  ///< among the packed ones
    Vec3 index;      ///< in the lattice
    Vec3 position;
    double distance;  ///< signed, and not limited by the band
    double most;      ///< the half width on its side, as distances of the field have it
};

/// A number of an array of any type.
double number_at(const targets::HostArrays& arrays, Output output, std::size_t index);

/// The outputs of samples by the host, which compiles the functions of the kernels: every output of the table.
class KnownOutputs {
public:
    KnownOutputs(const Mesh& mesh, const Grid& grid);

    /// Describes an output that differs from the host's; empty if all agree. If several faces have the named site, the
    /// sample may have been finished from each of them. All outputs are wanted. error: of the distance.
    std::string difference(const targets::HostArrays& found, const KnownSample& sample, double error) const;

private:
    std::string difference_from(std::uint32_t face, const targets::HostArrays& found, const KnownSample& sample,
                                double error) const;

    engine::Finishing how_;
    std::vector<Triangle> triangles_;
    std::vector<Polyhedron> polyhedra_;
    std::vector<TriangleSites> sites_;
    std::vector<float> normals_;
};

}  // namespace clsdf::checks
