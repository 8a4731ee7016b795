#pragma once

#include "option_values.hpp"
#include "report.hpp"

#include <clsdf/calls.hpp>
#include <clsdf/outer.hpp>

#include <cstddef>
#include <string>
#include <vector>

/// A mesh, or the bodies of a scene, and the outer surface.
struct OuterOfFiles {
    std::string name;
    std::size_t vertices = 0, triangles = 0;  ///< as given; of a scene those of its bodies, an instance again
    clsdf::Box box{};                         ///< around what is given
    clsdf::OuterSurface surface;
};

/// Reads the files of the argument MESH, a scene or one body, and makes the outer surface. output: a file that must not
/// be one of them. The calls of `call` are those of the search.
OuterOfFiles outer_of_files(const std::vector<std::string>& files, const MeshReading& reading, const SignChoice& sign,
                            const std::string& output, const clsdf::CallOptions& call, Report& report);
