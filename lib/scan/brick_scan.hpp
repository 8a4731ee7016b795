#pragma once

#include "scan/field_scan.hpp"
#include "scan/prepared_mesh.hpp"
#include "scan/programs.hpp"
#include "scan/short_launches.hpp"

#include <memory>
#include <span>

namespace clsdf::scan {

/// The scan by bricks; the mesh, the sign bits and `finishing`, null for the distance alone, must outlive it. `wanted`:
/// see PlanOptions.
std::unique_ptr<FieldScan> make_brick_scan(device::Context& context, const Programs& programs,
                                           const std::shared_ptr<device::BufferPool>& pool, const Layout& layout,
                                           const PreparedMesh& mesh, const RecordSelection& selection,
                                           const std::shared_ptr<const SurfacePoints>& points,
                                           const cl::Buffer& sign_bits, const Finishing* finishing,
                                           const BrickVariant& variant, std::span<const Grid> wanted,
                                           const ShortLaunches& launches);

}  // namespace clsdf::scan
