#pragma once

#include "frusta/cluster_index.hpp"
#include "layout.h"
#include "segments/sample_box.hpp"
#include "sign/exact_sides.hpp"

#include <clsdf/grid.hpp>
#include <clsdf/topology.hpp>

#include <optional>
#include <vector>

namespace clsdf::segments {

// The exact sides of all samples of a part's bricks as the sign bits that the kernels of fields read: rows of
// layout.sign_words words, 1 inside. grid: of the part.

/// By kernels; nothing if a coordinate of the mesh is out of range. Throws as SampleBox() and find_exact_sides() do.
std::optional<device::BufferPool::Lease> sign_bits_by_kernels(const engine::DeviceTools& tools,
                                                              const engine::ShortLaunches& launches,
                                                              const engine::CrossedMesh& mesh, SignRule rule,
                                                              const Grid& grid, const Layout& layout);
/// By the host. near: see BoxSides. Throws as SampleBox() does, and Error(out_of_memory).
device::BufferPool::Lease sign_bits_by_host(const engine::DeviceTools& tools, const engine::CrossedFaces& faces,
                                            SignRule rule, const Grid& grid, const Layout& layout,
                                            const std::vector<engine::RecordRange>* near);

}  // namespace clsdf::segments
