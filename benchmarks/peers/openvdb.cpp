// OpenVDB: meshToVolume with the band's widths, and a parallel copy of its sparse grid into the dense field. Vertices
// are given in double, in the grid's index space, so that the voxels are the grid's samples.

#include "benchmarks/method.hpp"
#include "benchmarks/peers/openvdb_headers.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <limits>
#include <vector>

namespace clsdf::bench {

namespace {

/// The mesh in the grid's index space, formed once, because meshToVolume reads each point many times.
struct IndexSpaceMesh {
    std::vector<openvdb::Vec3d> points;
    std::vector<openvdb::Vec3I> triangles;

    IndexSpaceMesh(const Mesh& mesh, const Grid& grid)
        : points(mesh.vertices().size()), triangles(mesh.triangles().size()) {
        const Vec3 first = grid.position(0, 0, 0);
        tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t v) {
            for (std::size_t axis = 0; axis < 3; ++axis)
                points[v][static_cast<int>(axis)] = (mesh.vertices()[v][axis] - first[axis]) / grid.spacing[axis];
        });
        tbb::parallel_for(std::size_t{0}, triangles.size(), [&](std::size_t t) {
            const Triangle& triangle = mesh.triangles()[t];
            triangles[t] = {triangle[0], triangle[1], triangle[2]};
        });
    }
};

class OpenVdb final : public Method {
public:
    OpenVdb() { openvdb::initialize(); }

    std::string name() const override { return "OpenVDB"; }
    std::string note() const override { return "approximate by design"; }

    Cost compute(const Workload& workload, std::span<float> distance, std::size_t) override {
        const Grid& grid = workload.grid;
        const double voxel = grid.voxel();
        const bool whole = std::isinf(workload.band.outside);
        // Without a band, the widths are the distance of the farthest sample, and the interior is filled.
        const auto outside =
            static_cast<float>(whole ? workload.largest_distance / voxel + 1 : workload.band.outside / voxel);
        const float inside =
            whole ? std::numeric_limits<float>::max() : static_cast<float>(workload.band.inside / voxel);
        const int flags = workload.sign == SignRule::none ? openvdb::tools::UNSIGNED_DISTANCE_FIELD : 0;
        const IndexSpaceMesh mesh(workload.mesh, grid);
        const auto transform = openvdb::math::Transform::createLinearTransform(voxel);
        const openvdb::FloatGrid::Ptr sparse = openvdb::tools::meshToVolume<openvdb::FloatGrid>(
            openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3d, openvdb::Vec3I>(mesh.points, mesh.triangles),
            *transform, outside, inside, flags);

        const openvdb::CoordBBox box({0, 0, 0}, {static_cast<int>(grid.size[0]) - 1, static_cast<int>(grid.size[1]) - 1,
                                                 static_cast<int>(grid.size[2]) - 1});
        openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> dense(box, distance.data());
        openvdb::tools::copyToDense(*sparse, dense);
        return {};
    }
};

}  // namespace

Entry openvdb_entry() {
    return {"openvdb", fmt::format("OpenVDB {}", openvdb::getLibraryVersionString()), "", std::make_unique<OpenVdb>()};
}

}  // namespace clsdf::bench
