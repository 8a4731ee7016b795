#include "handles.hpp"
#include "index_base.hpp"
#include "values.hpp"

#include <clsdf/mesh_files.hpp>

#include <memory>
#include <vector>

using namespace clsdf;
using c::given;
using c::guarded;
using c::made;
using c::of;

clsdf_status clsdf_field_create(const clsdf_field_description* description, std::uint32_t outputs,
                                clsdf_field** field) {
    return made(field, "field",
                [&] { return new clsdf_field(Field(c::description_of(description), c::outputs_of(outputs))); });
}

clsdf_status clsdf_field_describe(const clsdf_field* field, clsdf_field_description* description) {
    return guarded([&] { c::write_given(c::as_c(of(field).field), description, "clsdf_field_description"); });
}

clsdf_status clsdf_field_outputs(const clsdf_field* field, std::uint32_t* outputs) {
    return guarded([&] { given(outputs, "outputs") = of(field).field.outputs().bits(); });
}

clsdf_status clsdf_field_array(const clsdf_field* field, std::int32_t output, clsdf_array* array) {
    return guarded([&] {
        const OutputInfo& info = info_of(static_cast<Output>(output));
        clsdf_array result = CLSDF_ARRAY_INIT;
        result.type = static_cast<std::int32_t>(info.type);
        for (const clsdf_target& target : c::as_c(of(field).field.slab()))
            if (target.output == output) result = target.array;
        given(array, "array") = result;
    });
}

clsdf_status clsdf_field_set_index_base(clsdf_field* field, std::int32_t index_base) {
    return guarded([&] {
        clsdf_field& self = of(field);
        const std::int32_t base = c::checked_index_base(index_base);
        for (const std::span<std::uint32_t> numbers : {self.field.triangle(), self.field.body()})
            for (std::uint32_t& number : numbers)
                number += static_cast<std::uint32_t>(base) - static_cast<std::uint32_t>(self.index_base);
        self.index_base = base;
    });
}

clsdf_status clsdf_field_set_groups(clsdf_field* field, const clsdf_mesh* mesh) {
    return guarded([&] {
        const FaceGroups& groups = of(mesh).mesh.groups();
        of(field).field.groups = groups.empty() ? nullptr : std::make_shared<const FaceGroups>(groups);
    });
}

clsdf_status clsdf_points_read(const char* path, clsdf_points** points) {
    return made(points, "points", [&] {
        auto result = std::make_unique<clsdf_points>();
        result->positions = read_points(c::text_of(path, "path"));
        return result.release();
    });
}

clsdf_status clsdf_points_data(const clsdf_points* points, const double** positions, std::int64_t* count) {
    return guarded([&] {
        const std::vector<Vec3>& from = of(points).positions;
        if (positions != nullptr) *positions = from.empty() ? nullptr : from.front().data();
        if (count != nullptr) *count = static_cast<std::int64_t>(from.size());
    });
}

clsdf_status clsdf_points_write(const double* positions, std::int64_t count, const clsdf_target* results,
                                std::int64_t result_count, const char* path, std::uint32_t outputs) {
    return guarded([&] {
        c::elements(positions, count, "positions");
        static_assert(c::is_triple<Vec3, double>);
        write_points({reinterpret_cast<const Vec3*>(positions), static_cast<std::size_t>(count)},
                     c::slab_of(results, result_count, count), c::text_of(path, "path"), c::outputs_of(outputs));
    });
}

clsdf_status clsdf_points_check_path(const char* path) {
    return guarded([&] { check_points_path(c::text_of(path, "path")); });
}
