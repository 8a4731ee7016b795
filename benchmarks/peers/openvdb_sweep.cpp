// The far field as level-set programs compute it: clsdf's exact band, continued over the whole grid by OpenVDB's fast
// sweeping, a solver of the eikonal equation of first order. The samples of the band keep their distances.

#include "benchmarks/method.hpp"
#include "benchmarks/peers/openvdb_headers.hpp"

#include <fmt/format.h>

namespace clsdf::bench {

namespace {

using Dense = openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ>;

class OpenVdbSweep final : public Method {
public:
    OpenVdbSweep(Device device, double share) : device_(std::move(device)), share_(share) { openvdb::initialize(); }

    std::string name() const override { return fmt::format("band of {:g}%, OpenVDB's fast sweeping", 100 * share_); }
    std::string note() const override { return "from the mesh's arrays anew; one iteration of eight sweeps"; }

    Cost compute(const Workload& workload, std::span<float> distance, std::size_t) override {
        const Grid& grid = workload.grid;
        const Band band = Band::symmetric(share_ * workload.mesh.box().longest_side());
        DistanceTransform(device_, workload.mesh).compute(grid, band, distance);

        const openvdb::CoordBBox box({0, 0, 0}, {static_cast<int>(grid.size[0]) - 1, static_cast<int>(grid.size[1]) - 1,
                                                 static_cast<int>(grid.size[2]) - 1});
        Dense dense(box, distance.data());
        const auto transform = openvdb::math::Transform::createLinearTransform(grid.voxel());
        // Active voxels are the band; all others have the half width, with their sign.
        const auto half_width = static_cast<float>(band.outside);
        const auto narrow = openvdb::FloatGrid::create(half_width);
        narrow->setTransform(transform);
        narrow->setGridClass(openvdb::GRID_LEVEL_SET);
        openvdb::tools::copyFromDense(dense, *narrow, 0.0F);
        openvdb::tools::deactivate(narrow->tree(), -half_width);

        const auto everywhere = openvdb::MaskGrid::create();
        everywhere->setTransform(transform);
        everywhere->denseFill(box, true, true);
        openvdb::tools::copyToDense(*openvdb::tools::maskSdf(*narrow, *everywhere), dense);
        return {};
    }

private:
    Device device_;
    double share_;
};

}  // namespace

Entry openvdb_sweep_entry(const Device& device, double share) {
    return {"openvdb_sweep", fmt::format("OpenVDB {}", openvdb::getLibraryVersionString()), "",
            std::make_unique<OpenVdbSweep>(device, share)};
}

}  // namespace clsdf::bench
