#include "mesh_arrays.hpp"

#include "handles.hpp"
#include "values.hpp"

#include <clsdf/mesh_files.hpp>
#include <clsdf/outer.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

using namespace clsdf;
using c::given;
using c::guarded;
using c::made;
using c::of;

namespace {

/// Empty if there was no memory for them.
const std::vector<ShapeName>& shapes() noexcept {
    static const std::vector<ShapeName> names = []() noexcept {
        try {
            return shape_names();
        } catch (const std::bad_alloc&) {
            return std::vector<ShapeName>();
        }
    }();
    return names;
}

}  // namespace

clsdf_status clsdf_mesh_create(const clsdf_mesh_arrays* arrays, clsdf_mesh** mesh) {
    return made(mesh, "mesh", [&] {
        const c::MeshArrays from(arrays);
        return new clsdf_mesh(Mesh(from.view(), from.name()), from.index_base());
    });
}

clsdf_status clsdf_mesh_shape(const char* name, clsdf_mesh** mesh) {
    return made(mesh, "mesh", [&] { return new clsdf_mesh(make_shape(c::text_of(name, "name"))); });
}

clsdf_status clsdf_mesh_read(const char* path, clsdf_mesh** mesh) {
    return made(mesh, "mesh", [&] { return new clsdf_mesh(read_mesh(c::text_of(path, "path"))); });
}

clsdf_status clsdf_mesh_read_files(const char* const* paths, std::int64_t count, const clsdf_read_options* options,
                                   clsdf_mesh** mesh) {
    return made(mesh, "mesh", [&] {
        c::elements(paths, count, "paths");
        std::vector<std::string> files;
        for (std::int64_t i = 0; i < count; ++i) files.emplace_back(c::text_of(paths[i], "paths"));
        return new clsdf_mesh(read_meshes(files, c::read_options_of(options)));
    });
}

clsdf_status clsdf_mesh_weld(const clsdf_mesh* mesh, clsdf_mesh** welded) {
    return made(welded, "welded", [&] {
        const clsdf_mesh& self = of(mesh);
        return new clsdf_mesh(weld(self.mesh), self.index_base);
    });
}

clsdf_status clsdf_mesh_weld_within(const clsdf_mesh* mesh, double tolerance, clsdf_mesh** welded) {
    return made(welded, "welded", [&] {
        const clsdf_mesh& self = of(mesh);
        return new clsdf_mesh(weld(self.mesh, tolerance), self.index_base);
    });
}

clsdf_status clsdf_mesh_close_down(const clsdf_mesh* mesh, double floor, clsdf_mesh** closed) {
    return made(closed, "closed", [&] {
        const clsdf_mesh& self = of(mesh);
        return new clsdf_mesh(close_down(self.mesh, floor), self.index_base);
    });
}

clsdf_status clsdf_mesh_describe_weld(const clsdf_mesh* mesh, const clsdf_mesh* welded, clsdf_weld_report* report,
                                      char* warning, std::int64_t size, std::int64_t* length) {
    return guarded([&] {
        const WeldReport found = describe_weld(of(mesh).mesh, of(welded).mesh);
        const clsdf_weld_report result{sizeof result, static_cast<std::int64_t>(found.lost_faces),
                                       static_cast<std::int64_t>(found.coinciding_faces), found.volume_before,
                                       found.volume_after};
        c::write_struct(result, report, "clsdf_weld_report");
        c::write_text(found.warning, warning, size, length);
    });
}

clsdf_status clsdf_mesh_write(const clsdf_mesh* mesh, const char* path, const std::uint8_t* colours,
                              std::int64_t colour_count) {
    return guarded([&] {
        c::elements(colours, colour_count, "colours");
        static_assert(sizeof(FaceColour) == 3);
        const clsdf_mesh& self = of(mesh);
        if (colour_count == 0 && !self.given_faces.empty())
            return write_mesh(OuterSurface{self.mesh, self.given_faces}, c::text_of(path, "path"));
        write_mesh(self.mesh, c::text_of(path, "path"),
                   {reinterpret_cast<const FaceColour*>(colours), static_cast<std::size_t>(colour_count)});
    });
}

std::int64_t clsdf_shape_count() {
    return static_cast<std::int64_t>(shapes().size());
}

const char* clsdf_shape_name(std::int64_t index) {
    return index < 0 || index >= clsdf_shape_count() ? nullptr : shapes()[static_cast<std::size_t>(index)].name.c_str();
}

const char* clsdf_shape_description(std::int64_t index) {
    return index < 0 || index >= clsdf_shape_count() ? nullptr
                                                     : shapes()[static_cast<std::size_t>(index)].description.c_str();
}

clsdf_status clsdf_mesh_set_positions(clsdf_mesh* mesh, const clsdf_array* positions) {
    return guarded([&] {
        clsdf_mesh& self = of(mesh);
        self.mesh.set_positions(c::input_of(positions, "positions"));
        self.given_faces.clear();  // its parts may meet now
        self.given_bodies.clear();
    });
}

clsdf_status clsdf_mesh_set_index_base(clsdf_mesh* mesh, std::int32_t index_base) {
    return guarded([&] { of(mesh).index_base = c::checked_index_base(index_base); });
}

clsdf_status clsdf_mesh_vertices(const clsdf_mesh* mesh, const double** vertices, std::int64_t* count) {
    return guarded([&] {
        const std::vector<Vec3>& from = of(mesh).mesh.vertices();
        if (vertices != nullptr) *vertices = from.front().data();
        if (count != nullptr) *count = static_cast<std::int64_t>(from.size());
    });
}

clsdf_status clsdf_mesh_triangles(const clsdf_mesh* mesh, const std::uint32_t** triangles, std::int64_t* count) {
    return guarded([&] {
        const std::vector<Triangle>& from = of(mesh).mesh.triangles();
        if (triangles != nullptr) *triangles = from.front().data();
        if (count != nullptr) *count = static_cast<std::int64_t>(from.size());
    });
}

clsdf_status clsdf_mesh_index_base(const clsdf_mesh* mesh, std::int32_t* index_base) {
    return guarded([&] { given(index_base, "index_base") = of(mesh).index_base; });
}

clsdf_status clsdf_mesh_name(const clsdf_mesh* mesh, const char** name) {
    return guarded([&] { given(name, "name") = of(mesh).mesh.name().c_str(); });
}

clsdf_status clsdf_mesh_group_count(const clsdf_mesh* mesh, std::int64_t* count) {
    return guarded([&] { given(count, "count") = static_cast<std::int64_t>(of(mesh).mesh.groups().names.size()); });
}

clsdf_status clsdf_mesh_group_name(const clsdf_mesh* mesh, std::int64_t index, const char** name) {
    return guarded([&] {
        const std::vector<std::string>& names = of(mesh).mesh.groups().names;
        if (index < 0 || static_cast<std::size_t>(index) >= names.size())
            throw c::misuse("index is " + std::to_string(index) + ", and the mesh has " + std::to_string(names.size()) +
                            " groups, counted from 0");
        given(name, "name") = names[static_cast<std::size_t>(index)].c_str();
    });
}

clsdf_status clsdf_mesh_group_numbers(const clsdf_mesh* mesh, const std::uint32_t** numbers, std::int64_t* count) {
    return guarded([&] {
        const std::vector<std::uint32_t>& from = of(mesh).mesh.groups().numbers;
        if (numbers != nullptr) *numbers = from.data();
        if (count != nullptr) *count = static_cast<std::int64_t>(from.size());
    });
}

clsdf_status clsdf_mesh_set_groups(clsdf_mesh* mesh, const char* const* names, std::int64_t name_count,
                                   const std::uint32_t* numbers, std::int64_t count) {
    return guarded([&] {
        c::elements(names, name_count, "names");
        c::elements(numbers, count, "numbers");
        FaceGroups groups;
        for (std::int64_t i = 0; i < name_count; ++i) groups.names.push_back(c::text_of(names[i], "names"));
        groups.numbers.assign(numbers, numbers + count);
        of(mesh).mesh.set_groups(std::move(groups));
    });
}

clsdf_status clsdf_mesh_box(const clsdf_mesh* mesh, clsdf_box* box) {
    return guarded([&] { given(box, "box") = c::as_c(of(mesh).mesh.box()); });
}

clsdf_status clsdf_mesh_hash(const clsdf_mesh* mesh, std::uint64_t* hash) {
    return guarded([&] { given(hash, "hash") = of(mesh).mesh.hash(); });
}

clsdf_status clsdf_mesh_topology(const clsdf_mesh* mesh, clsdf_topology* topology) {
    return guarded([&] { c::write_given(c::as_c(describe_topology(of(mesh).mesh)), topology, "clsdf_topology"); });
}

clsdf_status clsdf_mesh_defects(const clsdf_mesh* mesh, clsdf_defects* defects) {
    return guarded([&] {
        const Defects found = find_defects(of(mesh).mesh);
        const clsdf_defects result{sizeof result, static_cast<std::int64_t>(found.zero_area_faces),
                                   static_cast<std::int64_t>(found.duplicate_faces),
                                   static_cast<std::int64_t>(found.components)};
        c::write_given(result, defects, "clsdf_defects");
    });
}

clsdf_status clsdf_mesh_sign(const clsdf_mesh* mesh, std::int32_t asked, std::int32_t* rule, char* warning,
                             std::int64_t size, std::int64_t* length) {
    return guarded([&] {
        const SignRule wanted = c::sign_rule_of(asked, "asked");
        const ResolvedSignRule resolved = resolve_sign_rule(wanted, describe_topology(of(mesh).mesh));
        given(rule, "rule") = static_cast<std::int32_t>(resolved.rule);
        c::write_text(resolved.warning, warning, size, length);
    });
}
