#pragma once

#include "core/files.hpp"
#include "core/outputs.hpp"
#include "io/fields/hdf5.hpp"

#include <clsdf/grid.hpp>

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace clsdf::hdf5 {

/// Numbers, or a text of fixed length: UTF-8 that ends with 0, or ASCII without an end; or texts in UTF-8, one or more,
/// of the length of the longest.
struct NewAttribute {
    struct Ascii {
        std::string text;
    };

    std::string name;
    std::variant<std::string, Ascii, std::vector<double>, std::vector<std::int64_t>, std::vector<std::string>> value;
};

struct NewGroup {
    std::string name;  ///< a path; the groups that it is in stand before it
    std::vector<NewAttribute> attributes;
};

/// A contiguous array, whose values are written later.
struct NewArray {
    std::string name;  ///< a path: "VTKHDF/PointData/distance"
    ElementType type;
    std::vector<hsize_t> shape;
    std::vector<NewAttribute> attributes;
};

struct NewContent {
    std::vector<NewAttribute> attributes;  ///< of the file
    std::vector<NewGroup> groups;
    std::vector<NewArray> arrays;
};

/// Writes all of a file but the values of its arrays. Returns the offset of each array's values; 0 if it has none. The
/// structure has checksums (file format 1.8) and no times, so the same content has the same bytes. `path` is for
/// messages. Throws Error(output_failure).
std::vector<std::uint64_t> write_layout(AtomicFile& target, const std::string& path, const NewContent& content);

/// z, y, x and the components of a sample.
std::vector<hsize_t> shape_of(const Grid& grid, const OutputInfo& info);

}  // namespace clsdf::hdf5
