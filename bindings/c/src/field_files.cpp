// libclsdf_c_io: files of fields. Messages are kept by libclsdf_c.
#include "handles.hpp"
#include "values.hpp"

#include <clsdf_io.h>

#include <clsdf/io.hpp>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

struct clsdf_field_writer : clsdf::c::Counted<clsdf_field_writer> {
    static constexpr clsdf::c::Kind own_kind = clsdf::c::Kind::field_writer;
    clsdf::FieldWriter writer;
    std::int64_t slice;  ///< samples of a slice

    clsdf_field_writer(clsdf::FieldWriter writer_in, std::int64_t slice_in)
        : writer(std::move(writer_in)), slice(slice_in) {}
};

using namespace clsdf;
using c::guarded;
using c::made;
using c::of;

clsdf_status clsdf_field_read(const char* path, clsdf_field** field) {
    return made(field, "field", [&] { return new clsdf_field(read_field(c::text_of(path, "path"))); });
}

clsdf_status clsdf_field_missing_files(const char* path, char* text, std::int64_t size, std::int64_t* length) {
    return guarded([&] {
        std::string lines;
        for (const std::string& file : missing_field_files(c::text_of(path, "path"))) lines += file + '\n';
        c::write_text(lines, text, size, length);
    });
}

clsdf_status clsdf_field_write(const clsdf_field* field, const char* path) {
    return guarded([&] {
        const clsdf_field& self = of(field);
        const std::string to = c::text_of(path, "path");
        if (self.index_base == 0 || self.field.triangle().empty()) return write_field(self.field, to);
        // Files count from 0.
        std::vector<std::uint32_t> triangles(self.field.triangle().begin(), self.field.triangle().end());
        std::ranges::for_each(triangles, [](std::uint32_t& triangle) { --triangle; });
        FieldSlab values = self.field.slab();
        values.set(Output::triangle, triangles);
        FieldWriter writer(to, self.field, values.outputs());
        writer.append(values);
        writer.finish();
    });
}

clsdf_status clsdf_field_check_path(const char* path, std::uint32_t outputs) {
    return guarded([&] { check_field_path(c::text_of(path, "path"), c::outputs_of(outputs)); });
}

void clsdf_field_writer_retain(clsdf_field_writer* writer) {
    c::retain(writer);
}

void clsdf_field_writer_release(clsdf_field_writer* writer) {
    c::release(writer);
}

clsdf_status clsdf_field_writer_create(const char* path, const clsdf_field_description* description,
                                       std::uint32_t outputs, clsdf_field_writer** writer) {
    return made(writer, "writer", [&] {
        const FieldDescription field = c::description_of(description);
        return new clsdf_field_writer(FieldWriter(c::text_of(path, "path"), field, c::outputs_of(outputs)),
                                      field.grid.size[0] * field.grid.size[1]);
    });
}

clsdf_status clsdf_field_writer_append(clsdf_field_writer* writer, const clsdf_target* values, std::int64_t count,
                                       std::int64_t slices) {
    return guarded([&] {
        clsdf_field_writer& self = of(writer);
        if (slices < 1 || slices > INT64_MAX / self.slice)
            throw c::misuse("slices is " + std::to_string(slices) +
                            "; give at least one slice, and no more than the grid has");
        self.writer.append(c::slab_of(values, count, slices * self.slice));
    });
}

clsdf_status clsdf_field_writer_finish(clsdf_field_writer* writer) {
    return guarded([&] { of(writer).writer.finish(); });
}

void clsdf_io_abandon_unfinished_files() {
    clsdf_abandon_unfinished_files();
    abandon_unfinished_files();
}
