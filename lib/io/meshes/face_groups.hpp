#pragma once

#include "io/meshes/text_scanner.hpp"
#include "mesh/mesh_arrays.hpp"

#include <clsdf/mesh.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

/// Groups of faces as files name them. Equal names are one group; groups without faces are left out.
namespace clsdf {

/// The words of the rest of a line, with a blank between them.
std::string name_in(TextScanner& scanner);

/// Groups in the making: names in the order of their first triangles.
class NamedGroups {
public:
    /// The next triangles.
    void add(const std::string& name, std::size_t triangles);
    /// The next triangles are those of a file.
    void add_file(const std::string& path, const FaceGroups& groups, std::size_t triangles);

    /// None if no triangle has a name.
    FaceGroups take();

private:
    std::uint32_t number_of(const std::string& name);

    FaceGroups groups_;
    std::unordered_map<std::string, std::uint32_t> numbers_;
    std::unordered_set<std::string> files_;
};

/// The groups of a file. Triangles before the first run have no name.
FaceGroups groups_of(std::span<const GroupRun> runs, std::size_t triangles);

}  // namespace clsdf
