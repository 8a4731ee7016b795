#pragma once

#include <clsdf/grid.hpp>

#include "frusta/cluster_index.hpp"
#include "frusta/prepared_mesh.hpp"
#include "homes/kept.hpp"
#include "lists/surface_points.hpp"
#include "sign/sweep_mesh.hpp"

#include <cstddef>
#include <memory>
#include <optional>

namespace clsdf::engine {

/// The kept values of one lattice.
class Lattice final : public KeptValue {
public:
    Lattice(const Vec3& origin_in, const Vec3& spacing_in)
        : KeptValue(MadeOf::positions, UsedBy::grids), origin(origin_in), spacing(spacing_in) {}
    bool is_of(const Grid& grid) const { return origin == grid.origin && spacing == grid.spacing; }

    KeptMemory memory() const override {
        KeptMemory memory;
        if (record_ranges) memory.host_bytes += record_ranges->host_bytes();
        if (records) memory.device_bytes += records->device_bytes();
        if (sweep_mesh) memory.device_bytes += sweep_mesh->device_bytes();
        if (points) memory.host_bytes += points->size() * sizeof(SurfacePoint);
        return memory;
    }
    bool is_in_use() const override {
        return records.use_count() > 1 || sweep_mesh.use_count() > 1 || points.use_count() > 1;
    }
    void forget() override { *this = Lattice(origin, spacing); }
    void leave_device() override {
        if (memory().device_bytes > 0) forget();
    }

    Vec3 origin;
    Vec3 spacing;
    std::optional<NearRecords> record_ranges{};  ///< the faces and sites in `records`
    std::shared_ptr<const PreparedMesh> records{};
    std::shared_ptr<const SweepMesh> sweep_mesh{};
    std::shared_ptr<const SurfacePoints> points{};
    std::optional<bool> may_meet_samples{};  ///< see KeptMesh::needs_normals()
    /// Numbers of faces whose records, or triangles of the sweep, were made for small grids only.
    std::size_t faces_packed = 0;
    std::size_t faces_swept = 0;
};

}  // namespace clsdf::engine
