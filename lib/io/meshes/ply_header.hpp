#pragma once

#include "io/meshes/mesh_files.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace clsdf {

enum class PlyFormat { ascii, binary_little_endian, binary_big_endian };

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::int8;
    std::optional<PlyType> count_type;  ///< of a list: the type of its length; always an integer
};

struct PlyElement {
    std::string name;
    std::size_t count = 0;
    std::vector<PlyProperty> properties;

    /// The property's index, if the element has it.
    std::optional<std::size_t> find(const std::string& property) const;
};

struct PlyHeader {
    PlyFormat format = PlyFormat::ascii;
    std::vector<PlyElement> elements;
    /// With the end of its last line. Two if the first byte of the rows may belong to that end; the likely one is
    /// first.
    std::vector<std::size_t> bytes;
    std::size_t lines = 0;

    const PlyElement* find(const std::string& element) const;
};

/// Bytes of a number in a binary file.
std::size_t size_of(PlyType type);

/// Throws Error(unreadable_input) with the line, also if the elements could not fit into the file.
PlyHeader read_ply_header(const FileContent& file, ReadingNotes& notes);

}  // namespace clsdf
