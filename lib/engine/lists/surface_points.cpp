#include "lists/surface_points.hpp"

#include "core/parallel.hpp"
#include "frusta/frames.hpp"
#include "frusta/records.hpp"

#include <algorithm>

namespace clsdf::engine {

namespace {

// Surface points that the coarse bounds look at, at most twice as many: they need not be tight.
constexpr std::size_t most_surface_points = 4096;

}  // namespace

std::vector<Triangle> sample_triangles(const MeshTopology& topology) {
    const std::size_t faces = topology.order.size();
    const std::size_t stride = std::max<std::size_t>(1, faces / most_surface_points);
    std::vector<Triangle> sample(chunk_count(faces, stride));
    for (std::size_t i = 0; i < sample.size(); ++i) sample[i] = topology.faces.triangles[i * stride];
    return sample;
}

SurfaceSample surface_sample(const MeshTopology& topology, const Frusta& frusta) {
    const std::vector<Triangle> triangles = sample_triangles(topology);
    SurfaceSample sample(triangles.size());
    for_each_index(sample.size(), [&](std::size_t i) {
        for (std::size_t k = 0; k < 3; ++k) sample[i][k] = frusta.positions[triangles[i][k]];
    });
    return sample;
}

SurfacePoints surface_points(const SurfaceSample& sample, const LatticeView& lattice) {
    SurfacePoints points(sample.size());
    for_each_index(points.size(), [&](std::size_t i) {
        constexpr Triangle corners{0, 1, 2};
        const Polyhedron record = pack(triangle_frame(sample[i], lattice), {}, 0, sample[i], corners, lattice);
        points[i] = {{record.origin_x, record.origin_y, record.origin_z},
                     {record.foot[0], record.foot[1], record.foot[2]}};
    });
    return points;
}

}  // namespace clsdf::engine
