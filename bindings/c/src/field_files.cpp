// libclsdf_c_io: files of fields. Messages are kept by libclsdf_c.
#include "handles.hpp"
#include "index_base.hpp"
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

struct clsdf_sparse_writer : clsdf::c::Counted<clsdf_sparse_writer> {
    static constexpr clsdf::c::Kind own_kind = clsdf::c::Kind::sparse_writer;
    clsdf::SparseFieldWriter writer;

    explicit clsdf_sparse_writer(clsdf::SparseFieldWriter writer_in) : writer(std::move(writer_in)) {}
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
        if (self.index_base == 0) return write_field(self.field, to);
        c::ShiftedValues shifted;
        const FieldSlab values = shifted(self.field.slab(), -self.index_base);
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

clsdf_status clsdf_sparse_field_read(const char* path, clsdf_sparse_field** field) {
    return made(field, "field", [&]() -> clsdf_sparse_field* {
        OutputSet all;
        for (const OutputInfo& info : output_table()) all.insert(info.output);
        auto read = read_sparse_field(c::text_of(path, "path"), all);
        return read ? new clsdf_sparse_field(std::move(*read)) : nullptr;
    });
}

clsdf_status clsdf_sparse_field_write(const clsdf_sparse_field* field, const char* path) {
    return guarded([&] {
        const clsdf_sparse_field& self = of(field);
        c::ShiftedValues shifted;
        SparseSlab layers = self.field.slab();
        layers.values = shifted(layers.values, -self.index_base);
        SparseFieldWriter writer(c::text_of(path, "path"), self.field, layers.values.outputs());
        writer.append(layers);
        writer.finish();
    });
}

void clsdf_sparse_writer_retain(clsdf_sparse_writer* writer) {
    c::retain(writer);
}

void clsdf_sparse_writer_release(clsdf_sparse_writer* writer) {
    c::release(writer);
}

clsdf_status clsdf_sparse_writer_create(const char* path, const clsdf_field_description* description,
                                        std::uint32_t outputs, clsdf_sparse_writer** writer) {
    return made(writer, "writer", [&] {
        return new clsdf_sparse_writer(
            SparseFieldWriter(c::text_of(path, "path"), c::description_of(description), c::outputs_of(outputs)));
    });
}

clsdf_status clsdf_sparse_writer_append(clsdf_sparse_writer* writer, const clsdf_sparse_slab* slab) {
    return guarded([&] { of(writer).writer.append(c::sparse_slab_of(slab)); });
}

clsdf_status clsdf_sparse_writer_finish(clsdf_sparse_writer* writer) {
    return guarded([&] { of(writer).writer.finish(); });
}

void clsdf_io_abandon_unfinished_files() {
    clsdf_abandon_unfinished_files();
    abandon_unfinished_files();
}
