#pragma once

#include "field/raw_values.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace clsdf {

/// The text before the values of an .npy file (numpy.org, "numpy.lib.format"), whose array is in C order.
struct NpyHeader {
    RawValues values;
    std::vector<std::int64_t> shape;  ///< slowest first: (nz, ny, nx)
};

/// Throws Error(unreadable_input).
NpyHeader read_npy_header(InputFile& file);

/// `type` is numpy's, as "<f4".
std::string npy_header(const std::string& type, const std::vector<std::int64_t>& shape);

}  // namespace clsdf
