#pragma once

#include <clsdf/error.hpp>
#include <clsdf/fractions.hpp>

#include <cstddef>

namespace clsdf::calls {

/// For arrays of rows with less room.
Error too_little_room(std::size_t rows, std::size_t room);

/// Whether kernels of the device find the rows: of a GPU, if all arrays are in its memory.
bool are_found_by_kernels(const Device& device, const OuterSurface& surface, const Grid& grid,
                          const FractionRows& rows);
/// Throws as fractions() of a device does, whose grid has been checked.
void fractions_by_kernels(const Device& device, const OuterSurface& surface, const Grid& grid, const FractionRows& rows,
                          std::size_t& count, const FractionOptions& options, const CallOptions& call);

}  // namespace clsdf::calls
