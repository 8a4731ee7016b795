#pragma once

#include "transform/field_scan.hpp"
#include "transform/prepared_mesh.hpp"
#include "transform/programs.hpp"
#include "transform/short_launches.hpp"

#include <memory>
#include <span>

namespace clsdf::transform {

/// The scan by bricks; the mesh, the sign bits and `finishing`, null for the distance alone, must outlive it. `wanted`:
/// see PlanOptions.
std::unique_ptr<FieldScan> make_brick_scan(device::Context& context, const Programs& programs,
                                           const std::shared_ptr<device::BufferPool>& pool, const Layout& layout,
                                           const PreparedMesh& mesh, const RecordSelection& selection,
                                           const std::shared_ptr<const SurfacePoints>& points,
                                           const cl::Buffer& sign_bits, const Finishing* finishing,
                                           const BrickVariant& variant, std::span<const Grid> wanted,
                                           const ShortLaunches& launches);

}  // namespace clsdf::transform
