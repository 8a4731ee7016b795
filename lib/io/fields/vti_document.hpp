#pragma once

#include "io/meshes/raw_values.hpp"

#include <clsdf/mesh.hpp>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace clsdf {

/// An array of a .vti file; its values are in `text`, or follow the document.
struct VtiArray {
    std::string name;
    std::string type;        ///< "Float32", "String", ...
    std::string components;  ///< as written
    std::string format;      ///< "appended", "binary" (base64) or "ascii"
    std::uint64_t offset = 0;
    std::string text;
};

/// The XML part of a .vti file (VTK's ImageData in one piece; the VTK file formats, "XML file formats").
struct VtiDocument {
    std::endian order = std::endian::little;
    std::size_t header_width = 4;  ///< bytes of the number that stands before the values of an array
    std::array<std::int64_t, 6> extent{};
    Vec3 origin{};
    Vec3 spacing{1, 1, 1};
    std::string scalars;  ///< the name of the array that PointData calls so
    std::vector<VtiArray> point_arrays;
    std::vector<VtiArray> field_arrays;
    bool is_compressed = false;     ///< by zlib, in blocks
    std::string appended_encoding;  ///< "raw" or "base64"; empty if nothing follows
    std::uint64_t appended_begin = 0;
};

/// Throws Error(unreadable_input).
VtiDocument parse_vti(InputFile& file);

}  // namespace clsdf
