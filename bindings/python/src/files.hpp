#pragma once

#include "arrays.hpp"
#include "binding.hpp"

#include <optional>
#include <string>
#include <vector>

namespace clsdf::python {

/// NumPy's type of an output in fields and files.
nb::dlpack::dtype dtype_of(ElementType type);

FieldDescription described(const Grid& grid, const Band& band, const std::string& sign, const std::string& mesh_name,
                           bool positive_inside, std::optional<double> floor);

/// Packed arrays of the types of the table, without a copy; `held` keeps them. The Python code sees to both. `what`
/// names the call in messages.
using HeldArrays = std::vector<nb::ndarray<nb::ro, nb::c_contig, nb::device::cpu>>;
FieldSlab slab_of(const ArraysByName& arrays, const char* what, HeldArrays& held);

}  // namespace clsdf::python
