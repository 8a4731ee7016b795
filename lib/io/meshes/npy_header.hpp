#pragma once

#include "io/meshes/raw_values.hpp"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace clsdf {

/// The text before the values of an .npy file (numpy.org, "numpy.lib.format").
struct NpyHeader {
    RawValues values;
    std::vector<std::int64_t> shape;  ///< slowest first: (nz, ny, nx)
    bool fortran_order = false;       ///< the reverse: slowest last
};

/// Throws Error(unreadable_input).
NpyHeader read_npy_header(InputFile& file);

/// `type` is numpy's as it is written in Python, as "'<f4'" or a list of the members of a structure.
std::string npy_header(std::string_view type, const std::vector<std::int64_t>& shape);

/// Numpy's name of a type, as "<f4".
const char* npy_name_of(ElementType type);

}  // namespace clsdf
