#include "field/description.hpp"
#include "field/formats.hpp"
#include "field/hdf5_layout.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <utility>

namespace clsdf {
namespace {

using hdf5::Handle;

hid_t type_of(ValueType type) {
    return type == ValueType::uint32 ? H5T_STD_U32LE : H5T_IEEE_F32LE;
}

// z, y, x and the components of a sample.
std::vector<hsize_t> shape_of(const Grid& grid, const OutputKind& kind) {
    std::vector<hsize_t> shape(grid.size.rbegin(), grid.size.rend());
    if (kind.components > 1) shape.push_back(static_cast<hsize_t>(kind.components));
    return shape;
}

/// HDF5 lays out the file and writes everything but the values: contiguous arrays, whose places it then tells, with
/// checksums over all else (its file format of 1.8), and no times, so that the same field has the same bytes.
class H5Layout {
public:
    explicit H5Layout(std::string path) : path_(std::move(path)) {}

    /// Writes all but the values and returns the offset of each output's.
    std::vector<std::uint64_t> write(AtomicFile& target, const FieldDescription& field,
                                     const std::vector<OutputKind>& kinds) const {
        const hdf5::Session session;
        hdf5::Layout layout;
        if (!layout.is_valid()) fail();
        std::vector<std::uint64_t> offsets = lay_out(layout, field, kinds);
        layout.write_to(target);
        return offsets;
    }

private:
    std::vector<std::uint64_t> lay_out(hdf5::Layout& layout, const FieldDescription& field,
                                       const std::vector<OutputKind>& kinds) const {
        const Handle access = checked(hdf5::access());
        layout.use(access);
        check(H5Pset_libver_bounds(access.get(), H5F_LIBVER_V18, H5F_LIBVER_LATEST));
        const Handle creation = checked({H5Pcreate(H5P_FILE_CREATE), H5Pclose});
        check(H5Pset_obj_track_times(creation.get(), false));
        Handle file = checked({H5Fcreate("layout", H5F_ACC_TRUNC, creation.get(), access.get()), H5Fclose});
        write_text(file.get(), "clsdf", description_text(field));
        std::vector<std::uint64_t> offsets;
        offsets.reserve(kinds.size());
        for (const OutputKind& kind : kinds) offsets.push_back(write_array(file.get(), kind, field.grid));
        if (!file.close()) fail();
        return offsets;
    }

    std::uint64_t write_array(hid_t file, const OutputKind& kind, const Grid& grid) const {
        const std::vector<hsize_t> shape = shape_of(grid, kind);
        const Handle space =
            checked({H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose});
        const Handle creation = checked({H5Pcreate(H5P_DATASET_CREATE), H5Pclose});
        check(H5Pset_layout(creation.get(), H5D_CONTIGUOUS));
        check(H5Pset_alloc_time(creation.get(), H5D_ALLOC_TIME_EARLY));
        check(H5Pset_fill_time(creation.get(), H5D_FILL_TIME_NEVER));
        check(H5Pset_obj_track_times(creation.get(), false));
        const Handle array = checked(
            {H5Dcreate2(file, kind.name, type_of(kind.type), space.get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
             H5Dclose});
        write_triple(array.get(), "origin", grid.position(0, 0, 0));
        write_triple(array.get(), "spacing", grid.spacing);
        const haddr_t offset = H5Dget_offset(array.get());
        if (offset == HADDR_UNDEF) fail();
        return offset;
    }

    void write_triple(hid_t object, const char* name, const Vec3& values) const {
        const hsize_t count = 3;
        const Handle space = checked({H5Screate_simple(1, &count, nullptr), H5Sclose});
        write_attribute(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, space, values.data());
    }

    void write_text(hid_t object, const char* name, const std::string& text) const {
        const Handle space = checked({H5Screate(H5S_SCALAR), H5Sclose});
        const Handle type = checked({H5Tcopy(H5T_C_S1), H5Tclose});
        check(H5Tset_size(type.get(), text.size() + 1));
        check(H5Tset_cset(type.get(), H5T_CSET_UTF8));
        write_attribute(object, name, type.get(), type.get(), space, text.c_str());
    }

    void write_attribute(hid_t object, const char* name, hid_t stored, hid_t given, const Handle& space,
                         const void* values) const {
        const Handle attribute =
            checked({H5Acreate2(object, name, stored, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose});
        check(H5Awrite(attribute.get(), given, values));
    }

    Handle checked(Handle handle) const {
        if (!handle.is_valid()) fail();
        return handle;
    }

    void check(herr_t result) const {
        if (result < 0) fail();
    }

    [[noreturn]] void fail() const {
        throw Error(ErrorCode::output_failure,
                    fmt::format("cannot write '{}': HDF5: {}", path_, hdf5::Session::reason()));
    }

    std::string path_;
};

std::string escaped_for_xml(std::string_view text) {
    std::string result;
    for (const char letter : text) {
        if (letter == '&')
            result += "&amp;";
        else if (letter == '<')
            result += "&lt;";
        else if (letter == '>')
            result += "&gt;";
        else
            result += letter;
    }
    return result;
}

// What tells ParaView and VisIt where the samples lie. XDMF orders everything as HDF5 does: z, y, x.
std::string xdmf_text(const std::string& path, const Grid& grid, const std::vector<OutputKind>& kinds) {
    const Vec3 origin = grid.position(0, 0, 0);
    const auto triple = [](const auto& values) { return fmt::format("{} {} {}", values[2], values[1], values[0]); };
    std::string attributes;
    for (const OutputKind& kind : kinds)
        attributes += fmt::format(
            "      <Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"Node\">\n"
            "        <DataItem Dimensions=\"{}\" NumberType=\"{}\" Precision=\"{}\" Format=\"HDF\">{}:/{}</DataItem>\n"
            "      </Attribute>\n",
            kind.name, kind.components > 1 ? "Vector" : "Scalar", fmt::join(shape_of(grid, kind), " "),
            kind.type == ValueType::uint32 ? "UInt" : "Float", width_of(kind.type), escaped_for_xml(file_name(path)),
            kind.name);
    return fmt::format(
        "<?xml version=\"1.0\"?>\n"
        "<Xdmf Version=\"3.0\">\n"
        "  <Domain>\n"
        "    <Grid Name=\"field\" GridType=\"Uniform\">\n"
        "      <Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"{}\"/>\n"
        "      <Geometry GeometryType=\"ORIGIN_DXDYDZ\">\n"
        "        <DataItem Dimensions=\"3\" NumberType=\"Float\" Precision=\"8\" Format=\"XML\">{}</DataItem>\n"
        "        <DataItem Dimensions=\"3\" NumberType=\"Float\" Precision=\"8\" Format=\"XML\">{}</DataItem>\n"
        "      </Geometry>\n"
        "{}"
        "    </Grid>\n"
        "  </Domain>\n"
        "</Xdmf>\n",
        triple(grid.size), triple(origin), triple(grid.spacing), attributes);
}

std::string xdmf_path(const std::string& path) {
    return std::filesystem::path(path).replace_extension(".xdmf").string();
}

class H5Writer : public FormatWriter {
public:
    H5Writer(const std::string& path, const FieldDescription& field, const Outputs& outputs)
        : kinds_(kinds_of(outputs)),
          slice_(static_cast<std::uint64_t>(field.grid.size[0]) * static_cast<std::uint64_t>(field.grid.size[1])),
          xdmf_(xdmf_path(path)),
          file_(path) {
        xdmf_.write(xdmf_text(path, field.grid, kinds_));
        offsets_ = H5Layout(path).write(file_, field, kinds_);
    }

    void append(const FieldSlab& slab, std::int64_t first_slice) override {
        for (std::size_t i = 0; i < kinds_.size(); ++i) {
            const OutputKind& kind = kinds_[i];
            file_.seek(offsets_[i] + static_cast<std::uint64_t>(first_slice) * slice_ * kind.sample_bytes());
            write_little_endian(file_, kind.bytes(slab), width_of(kind.type));
        }
    }

    void finish() override {
        xdmf_.commit();
        file_.commit();
    }

private:
    std::vector<OutputKind> kinds_;
    std::uint64_t slice_;
    std::vector<std::uint64_t> offsets_;
    AtomicFile xdmf_;
    AtomicFile file_;
};

}  // namespace

std::unique_ptr<FormatWriter> h5_writer(const std::string& path, const FieldDescription& field,
                                        const Outputs& outputs) {
    return std::make_unique<H5Writer>(path, field, outputs);
}

}  // namespace clsdf
