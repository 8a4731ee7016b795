#pragma once

#include "transform/field_scan.hpp"
#include "transform/prepared_mesh.hpp"
#include "transform/programs.hpp"

#include <memory>

namespace clsdf::transform {

/// Whether distance and triangle are one 64-bit number; without triangles the distances alone are the key, and 32 bits
/// are enough. Throws Error(unsupported) where the device has no 64-bit atomics and `asked` needs them.
bool takes_64_bits(const device::Context& context, const Layout& layout, bool with_triangle, SliceMinimum asked);

/// The scan by slices, for a mesh with pieces; the mesh and the sign bits must outlive it. Throws Error(unsupported)
/// where the device has no 64-bit atomics and `minimum` asks for them.
std::unique_ptr<FieldScan> make_slice_scan(device::Context& context, const Programs& programs,
                                           const std::shared_ptr<device::BufferPool>& pool, const Layout& layout,
                                           const PreparedMesh& mesh, const cl::Buffer& sign_bits,
                                           const BrickVariant& variant, SliceMinimum minimum);

}  // namespace clsdf::transform
