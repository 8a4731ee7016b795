#pragma once

#include "io/meshes/raw_values.hpp"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace clsdf {

/// A member of a structure.
struct NpyMember {
    std::string name;
    ElementType type = ElementType::float32;
    std::endian order = std::endian::little;
    std::size_t components = 1;
    std::size_t offset = 0;  ///< in the structure, in bytes
};

/// The text before the values of an .npy file (numpy.org, "numpy.lib.format").
struct NpyHeader {
    RawValues values;
    std::vector<std::int64_t> shape;  ///< slowest first: (nz, ny, nx)
    bool fortran_order = false;       ///< the reverse: slowest last
    /// Of an array of structures, whose bytes are the values, of the type uint8; empty for an array of numbers.
    std::vector<NpyMember> members{};
    std::size_t structure_bytes = 0;
};

/// takes_structures: else they are an error, too. Throws Error(unreadable_input).
NpyHeader read_npy_header(InputFile& file, bool takes_structures = false);

/// `type` is numpy's as it is written in Python, as "'<f4'" or a list of the members of a structure.
std::string npy_header(std::string_view type, const std::vector<std::int64_t>& shape);

/// Numpy's name of a type, as "<f4".
const char* npy_name_of(ElementType type);

}  // namespace clsdf
