#include "outer_surface.hpp"

#include "devices.hpp"
#include "scene_file.hpp"

#include <clsdf/clsdf.hpp>

#include <algorithm>

namespace {

OuterOfFiles outer_of_scene(const std::vector<std::string>& files, const MeshReading& reading, const SignChoice& sign,
                            const std::string& output, const clsdf::CallOptions& call, Report& report) {
    refuse_beside_scene(files, sign, {});
    const SceneFile file = read_scene(files.front());
    keep_mesh(file.files(), output);
    const SceneMeshes meshes = read_meshes(file, reading, report);
    const clsdf::Scene scene = make_scene(file, meshes, open_device({}, report), call);
    OuterOfFiles of_scene{.name = file.path, .box = scene.box(), .surface = scene.outer(call).surface};
    for (const std::size_t number : meshes.mesh_of) {
        of_scene.vertices += meshes.meshes[number].vertices().size();
        of_scene.triangles += meshes.meshes[number].triangles().size();
    }
    return of_scene;
}

}  // namespace

OuterOfFiles outer_of_files(const std::vector<std::string>& files, const MeshReading& reading, const SignChoice& sign,
                            const std::string& output, const clsdf::CallOptions& call, Report& report) {
    if (std::ranges::any_of(files, is_scene_file)) return outer_of_scene(files, reading, sign, output, call, report);
    keep_mesh(files, output);
    const clsdf::Mesh mesh = read_body(files, reading, report);
    return {.name = mesh.name(),
            .vertices = mesh.vertices().size(),
            .triangles = mesh.triangles().size(),
            .box = mesh.box(),
            .surface = clsdf::outer(mesh, parse_sign(sign), call)};
}
