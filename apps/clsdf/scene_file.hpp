#pragma once

#include <clsdf/scene.hpp>
#include <clsdf/topology.hpp>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

/// Many bodies as a file of JSON describes them (docs/scenes.md).
struct SceneFile {
    struct Body {
        std::string name;
        std::vector<std::string> files;   ///< of the mesh; empty: an instance
        std::optional<std::size_t> of{};  ///< the body whose mesh it has
        clsdf::SignRule sign = clsdf::SignRule::automatic;
        clsdf::Pose pose{};
    };

    std::string path;
    std::vector<Body> bodies;

    /// All files, its own first.
    std::vector<std::string> files() const;
};

/// Relative names of meshes begin at the folder of the scene's file. Throws Error(unreadable_input) that names the file
/// and the body.
SceneFile read_scene(const std::string& path);
