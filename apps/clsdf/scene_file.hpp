#pragma once

#include "json.hpp"
#include "option_values.hpp"
#include "report.hpp"

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

/// The meshes of a scene.
struct SceneMeshes {
    std::vector<clsdf::Mesh> meshes;
    std::vector<std::size_t> mesh_of;  ///< of each body

    std::size_t triangles() const;
};

/// Throws Error(invalid_argument) for options that a scene's file has, or that are of one mesh.
void refuse_beside_scene(const std::vector<std::string>& meshes, const SignChoice& sign,
                         const std::vector<std::string>& with);
SceneMeshes read_meshes(const SceneFile& file, const MeshReading& reading, Report& report);
/// With the bodies in the order of the file.
clsdf::Scene make_scene(const SceneFile& file, const SceneMeshes& meshes, const clsdf::Device& device,
                        const clsdf::CallOptions& call, clsdf::Surface surface = clsdf::Surface::given);
/// Names, meshes, triangles and sign rules of the bodies.
Json describe(const SceneFile& file, const SceneMeshes& meshes, const clsdf::Scene& scene);

/// Relative names of meshes begin at the folder of the scene's file. Throws Error(unreadable_input) that names the file
/// and the body.
SceneFile read_scene(const std::string& path);
