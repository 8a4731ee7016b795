#include "handles.hpp"
#include "values.hpp"

#include <clsdf/outer.hpp>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

using namespace clsdf;
using c::guarded;
using c::made;
using c::of;

namespace {

std::unique_ptr<clsdf_mesh> mesh_of(OuterSurface surface, std::int32_t index_base, clsdf_outer_report* report) {
    const clsdf_outer_report result{sizeof result,
                                    static_cast<std::int64_t>(surface.whole_faces),
                                    static_cast<std::int64_t>(surface.partial_faces),
                                    static_cast<std::int64_t>(surface.hidden_faces),
                                    surface.volume,
                                    surface.area};
    c::write_struct(result, report, "clsdf_outer_report");
    auto mesh = std::make_unique<clsdf_mesh>(std::move(surface.mesh), index_base);
    mesh->given_faces = std::move(surface.faces);
    return mesh;
}

void tell(const std::vector<std::uint32_t>& from, const std::uint32_t** numbers, std::int64_t* count) {
    if (numbers != nullptr) *numbers = from.data();
    if (count != nullptr) *count = static_cast<std::int64_t>(from.size());
}

}  // namespace

clsdf_status clsdf_mesh_outer(const clsdf_mesh* mesh, std::int32_t sign, const clsdf_call_options* call,
                              clsdf_mesh** outer_mesh, clsdf_outer_report* report) {
    return made(outer_mesh, "outer", [&] {
        const clsdf_mesh& self = of(mesh);
        c::check_result(report, "clsdf_outer_report");
        return mesh_of(outer(self.mesh, c::sign_rule_of(sign, "sign"), c::Call(call)), self.index_base, report)
            .release();
    });
}

clsdf_status clsdf_scene_outer(const clsdf_scene* scene, const clsdf_call_options* call, clsdf_mesh** outer_mesh,
                               clsdf_outer_report* report) {
    return made(outer_mesh, "outer", [&] {
        const clsdf_scene& self = of(scene);
        c::check_result(report, "clsdf_outer_report");
        SceneSurface found = self.scene.outer(c::Call(call));
        auto mesh = mesh_of(std::move(found.surface), self.index_base, report);
        mesh->given_bodies = std::move(found.bodies);
        return mesh.release();
    });
}

clsdf_status clsdf_mesh_given_faces(const clsdf_mesh* mesh, const std::uint32_t** faces, std::int64_t* count) {
    return guarded([&] { tell(of(mesh).given_faces, faces, count); });
}

clsdf_status clsdf_mesh_given_bodies(const clsdf_mesh* mesh, const std::uint32_t** bodies, std::int64_t* count) {
    return guarded([&] { tell(of(mesh).given_bodies, bodies, count); });
}
