#pragma once

#include "disguise/disguise.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"

#include <clsdf/clsdf.hpp>

/// A processor as a GPU, for a whole program; and a mesh, a grid and a band.
namespace clsdf::test {

/// A processor as a GPU, from before the first call of OpenCL on: BOOST_TEST_GLOBAL_FIXTURE(AsGpu).
inline const disguise::Settings as_gpu{.gpu = true, .compute_units = 132};
struct AsGpu {
    AsGpu() { disguise::set(as_gpu); }
};

inline const Mesh& mesh() {
    static const Mesh shape = tilted(make_shape("knot"));
    return shape;
}
inline const Grid& grid() {
    static const Grid around = grid_around(mesh(), 40, 5);
    return around;
}
inline Band band() {
    return Band::symmetric(3 * grid().voxel());
}

}  // namespace clsdf::test
