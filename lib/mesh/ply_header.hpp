#pragma once

#include "mesh/file_content.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace clsdf {

enum class PlyFormat { ascii, binary_little_endian, binary_big_endian };

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

std::size_t size_of(PlyType type);

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::int8;
    std::optional<PlyType> count_type;  ///< of a list: the type of its length; always an integer
};

struct PlyElement {
    std::string name;
    std::size_t count = 0;
    std::vector<PlyProperty> properties;

    /// The property's place among the others, where there is one.
    std::optional<std::size_t> find(const std::string& property) const;
};

struct PlyHeader {
    PlyFormat format = PlyFormat::ascii;
    std::vector<PlyElement> elements;
    std::size_t bytes = 0;  ///< with the end of its last line
    std::size_t lines = 0;

    const PlyElement* find(const std::string& element) const;
};

/// Throws Error(unreadable_input) with the line, also where the elements could not fit into the file.
PlyHeader read_ply_header(const FileContent& file);

}  // namespace clsdf
