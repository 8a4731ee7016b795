#pragma once

#include "plan/stages.hpp"
#include "points/face_sides.hpp"
#include "points/point_mesh.hpp"
#include "points/point_scan.hpp"

#include <memory>
#include <vector>

namespace clsdf::points {

/// The values that a transform keeps for points, beside those of its Stages, which must outlive this. Each is made when
/// it is needed first, and forgotten when the vertices move or memory is short.
///
///     points' tree   of the positions                    once points are asked for
///     face sides     + sign rule                         once about as many points are asked for
///     scanned mesh   + frusta                            once many points are asked for
///
/// For one thread at a time.
class KeptPoints {
public:
    explicit KeptPoints(transform::Stages& stages);
    KeptPoints(const KeptPoints&) = delete;
    KeptPoints& operator=(const KeptPoints&) = delete;

    /// The tree in which points are looked up. Throws Error(invalid_argument, unsupported or out_of_memory).
    std::shared_ptr<const PointMesh> tree();

    /// The records that the scan of many points reads beside the tree. `program`: the scan's. Throws as tree().
    std::shared_ptr<const ScannedMesh> scanned_mesh(const cl::Program& program);

    /// The signs on the sides of faces. If they are not known, they are found if `is_found`; otherwise null. Always
    /// null for a part of a mesh. The sign rule is the same in all calls.
    std::shared_ptr<const FaceSides> face_sides(SignRule sign, bool is_found);

private:
    std::vector<transform::Stages::KeptValue> values();

    transform::Stages& stages_;
    std::shared_ptr<const PointMesh> tree_;
    std::shared_ptr<const ScannedMesh> scanned_mesh_;
    std::shared_ptr<const FaceSides> face_sides_;
};

}  // namespace clsdf::points
