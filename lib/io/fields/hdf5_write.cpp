#include "core/files.hpp"
#include "io/fields/field_files.hpp"
#include "io/fields/hdf5.hpp"
#include "io/fields/segment_files.hpp"
#include "io/fields/sparse_files.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <utility>

#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif

namespace clsdf::hdf5 {
namespace {

/// The bytes that HDF5 writes without the values of the arrays, in memory. A file of 4 GiB takes a few kilobytes here.
/// If HDF5 1.10 wrote to a full disk itself, it would crash at the end of the program.
class Layout {
public:
    /// For H5Pset_driver: files that are created with this property list are written into this layout, which must
    /// outlive them. The list owns the driver of HDF5's virtual file layer.
    Layout();
    void use(const Handle& access);
    bool is_valid() const { return driver_.is_valid(); }

    /// The file with zeros for the values, which have to be written afterwards.
    void write_to(AtomicFile& file) const;

    void write(std::uint64_t begin, const std::byte* bytes, std::size_t count);
    void read(std::uint64_t begin, std::byte* bytes, std::size_t count) const;
    std::uint64_t end = 0;  ///< of the file, as HDF5 sets it

private:
    using Page = std::array<std::byte, 4096>;

    std::map<std::uint64_t, Page> pages_;
    Handle driver_;
};

// A layout as HDF5 sees it: its own record, and ours behind it.
struct OpenLayout {
    H5FD_t record;
    Layout* layout;
};

OpenLayout* opened(H5FD_t* file) {
    return reinterpret_cast<OpenLayout*>(file);
}

const OpenLayout* opened(const H5FD_t* file) {
    return reinterpret_cast<const OpenLayout*>(file);
}

H5FD_t* open_layout(const char*, unsigned, hid_t access, haddr_t) noexcept {
    const void* const info = H5Pget_driver_info(access);
    if (info == nullptr) return nullptr;
    auto* const file = new (std::nothrow) OpenLayout{};
    if (file == nullptr) return nullptr;
    file->layout = *static_cast<Layout* const*>(info);
    return &file->record;
}

herr_t close_layout(H5FD_t* file) noexcept {
    delete opened(file);
    return 0;
}

herr_t query(const H5FD_t*, unsigned long* flags) noexcept {
    *flags = H5FD_FEAT_AGGREGATE_METADATA;
    return 0;
}

haddr_t end_of_file(const H5FD_t* file, H5FD_mem_t) noexcept {
    return opened(file)->layout->end;
}

herr_t set_end_of_file(H5FD_t* file, H5FD_mem_t, haddr_t end) noexcept {
    opened(file)->layout->end = end;
    return 0;
}

herr_t read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t begin, std::size_t count, void* bytes) noexcept {
    opened(file)->layout->read(begin, static_cast<std::byte*>(bytes), count);
    return 0;
}

herr_t write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t begin, std::size_t count, const void* bytes) noexcept {
    try {
        opened(file)->layout->write(begin, static_cast<const std::byte*>(bytes), count);
        return 0;
    } catch (...) {
        return -1;
    }
}

H5FD_class_t driver_class() {
    H5FD_class_t driver{};
#if H5_VERSION_GE(1, 13, 0)
    driver.version = H5FD_CLASS_VERSION;
    driver.value = 512;  // the first that HDF5 leaves to programs
#endif
    driver.name = "clsdf_layout";
    driver.maxaddr = haddr_t{1} << 62U;
    driver.fc_degree = H5F_CLOSE_WEAK;
    driver.fapl_size = sizeof(void*);  // of the pointer to our layout
    driver.open = open_layout;
    driver.close = close_layout;
    driver.query = query;
    driver.get_eoa = end_of_file;
    driver.set_eoa = set_end_of_file;
    driver.get_eof = end_of_file;
    driver.read = read;
    driver.write = write;
    return driver;
}

hid_t register_driver() {
    static const H5FD_class_t driver = driver_class();
    return H5FDregister(&driver);
}

Layout::Layout() : driver_(register_driver(), H5FDunregister) {}

void Layout::use(const Handle& access) {
    Layout* const self = this;
    H5Pset_driver(access.get(), driver_.get(), &self);
}

void Layout::write(std::uint64_t begin, const std::byte* bytes, std::size_t count) {
    while (count > 0) {
        Page& page = pages_[begin / sizeof(Page)];
        const std::size_t offset = begin % sizeof(Page);
        const std::size_t part = std::min(count, sizeof(Page) - offset);
        std::copy_n(bytes, part, page.begin() + static_cast<std::ptrdiff_t>(offset));
        begin += part;
        bytes += part;
        count -= part;
    }
}

void Layout::read(std::uint64_t begin, std::byte* bytes, std::size_t count) const {
    while (count > 0) {
        const auto page = pages_.find(begin / sizeof(Page));
        const std::size_t offset = begin % sizeof(Page);
        const std::size_t part = std::min(count, sizeof(Page) - offset);
        if (page == pages_.end())
            std::fill_n(bytes, part, std::byte{});
        else
            std::copy_n(page->second.begin() + static_cast<std::ptrdiff_t>(offset), part, bytes);
        begin += part;
        bytes += part;
        count -= part;
    }
}

void Layout::write_to(AtomicFile& file) const {
    for (const auto& [index, page] : pages_) {
        const std::uint64_t begin = index * sizeof(Page);
        if (begin >= end) break;
        file.seek(begin);
        file.write(std::span(page).first(static_cast<std::size_t>(std::min<std::uint64_t>(sizeof(Page), end - begin))));
    }
}

}  // namespace

}  // namespace clsdf::hdf5

namespace clsdf {
namespace {

using hdf5::Handle;

hid_t type_of(ElementType type) {
    switch (type) {
        case ElementType::float64:
            return H5T_IEEE_F64LE;
        case ElementType::uint32:
            return H5T_STD_U32LE;
        case ElementType::int32:
            return H5T_STD_I32LE;
        case ElementType::int64:
            return H5T_STD_I64LE;
        case ElementType::uint8:
            return H5T_STD_U8LE;
        default:
            return H5T_IEEE_F32LE;
    }
}

// z, y, x and the components of a sample.
std::vector<hsize_t> shape_of(const Grid& grid, const OutputInfo& info) {
    std::vector<hsize_t> shape(grid.size.rbegin(), grid.size.rend());
    if (info.components > 1) shape.push_back(static_cast<hsize_t>(info.components));
    return shape;
}

/// An array of the file. Its attributes are origin and spacing, if it has any.
struct NewArray {
    std::string name;
    ElementType type;
    std::vector<hsize_t> shape;
    std::optional<std::pair<Vec3, Vec3>> origin_and_spacing;
};

/// HDF5 lays out the file and writes everything but the values: contiguous arrays, whose offsets it returns. The
/// structure has checksums (file format 1.8) and no times, so the same field has the same bytes.
class H5Layout {
public:
    explicit H5Layout(std::string path) : path_(std::move(path)) {}

    /// Writes all but the values and returns the offset of each array's values; 0 if it has none.
    std::vector<std::uint64_t> write(AtomicFile& target, const std::string& description,
                                     const std::vector<NewArray>& arrays) const {
        const hdf5::Session session;
        hdf5::Layout layout;
        if (!layout.is_valid()) fail();
        std::vector<std::uint64_t> offsets = lay_out(layout, description, arrays);
        layout.write_to(target);
        return offsets;
    }

private:
    std::vector<std::uint64_t> lay_out(hdf5::Layout& layout, const std::string& description,
                                       const std::vector<NewArray>& arrays) const {
        const Handle access = checked(hdf5::access());
        layout.use(access);
        check(H5Pset_libver_bounds(access.get(), H5F_LIBVER_V18, H5F_LIBVER_LATEST));
        const Handle creation = checked({H5Pcreate(H5P_FILE_CREATE), H5Pclose});
        check(H5Pset_obj_track_times(creation.get(), false));
        Handle file = checked({H5Fcreate("layout", H5F_ACC_TRUNC, creation.get(), access.get()), H5Fclose});
        write_text(file.get(), "clsdf", description);
        std::vector<std::uint64_t> offsets;
        offsets.reserve(arrays.size());
        for (const NewArray& array : arrays) offsets.push_back(write_array(file.get(), array));
        if (!file.close()) fail();
        return offsets;
    }

    std::uint64_t write_array(hid_t file, const NewArray& made) const {
        const Handle space =
            checked({H5Screate_simple(static_cast<int>(made.shape.size()), made.shape.data(), nullptr), H5Sclose});
        const Handle creation = checked({H5Pcreate(H5P_DATASET_CREATE), H5Pclose});
        check(H5Pset_layout(creation.get(), H5D_CONTIGUOUS));
        check(H5Pset_alloc_time(creation.get(), H5D_ALLOC_TIME_EARLY));
        check(H5Pset_fill_time(creation.get(), H5D_FILL_TIME_NEVER));
        check(H5Pset_obj_track_times(creation.get(), false));
        const Handle array = checked({H5Dcreate2(file, made.name.c_str(), type_of(made.type), space.get(), H5P_DEFAULT,
                                                 creation.get(), H5P_DEFAULT),
                                      H5Dclose});
        if (made.origin_and_spacing) {
            write_triple(array.get(), "origin", made.origin_and_spacing->first);
            write_triple(array.get(), "spacing", made.origin_and_spacing->second);
        }
        if (std::ranges::find(made.shape, hsize_t{0}) != made.shape.end()) return 0;
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

// The XDMF text, which gives ParaView and VisIt the positions of the samples. XDMF has the order of HDF5: z, y, x.
std::string xdmf_text(const std::string& path, const Grid& grid, const std::vector<OutputInfo>& infos) {
    const Vec3 origin = grid.position(0, 0, 0);
    const auto triple = [](const auto& values) { return fmt::format("{} {} {}", values[2], values[1], values[0]); };
    std::string attributes;
    for (const OutputInfo& info : infos)
        attributes += fmt::format(
            "      <Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"Node\">\n"
            "        <DataItem Dimensions=\"{}\" NumberType=\"{}\" Precision=\"{}\" Format=\"HDF\">{}:/{}</DataItem>\n"
            "      </Attribute>\n",
            info.name,
            info.components == 1   ? "Scalar"
            : info.components == 3 ? "Vector"
                                   : "Matrix",
            fmt::join(shape_of(grid, info), " "),
            is_whole(info.type) ? (info.type == ElementType::uint8 ? "UChar" : "UInt") : "Float", bytes_of(info.type),
            escaped_for_xml(file_name(path)), info.name);
    return fmt::format(
        "<?xml version=\"1.0\"?>\n"
        "<Xdmf Version=\"3.0\">\n"
        "  <Domain>\n"
        "    <Grid Name=\"field\" GridType=\"Uniform\">\n"
        "      <Time Value=\"0\"/>\n"  // PyVista reads no file without one
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
    H5Writer(const std::string& path, const FieldDescription& field, OutputSet outputs)
        : infos_(infos_of(outputs)),
          slice_(static_cast<std::uint64_t>(field.grid.size[0]) * static_cast<std::uint64_t>(field.grid.size[1])),
          xdmf_(xdmf_path(path)),
          file_(path) {
        xdmf_.write(xdmf_text(path, field.grid, infos_));
        std::vector<NewArray> arrays;
        for (const OutputInfo& info : infos_)
            arrays.push_back({info.name, info.type, shape_of(field.grid, info),
                              std::pair(field.grid.position(0, 0, 0), field.grid.spacing)});
        offsets_ = H5Layout(path).write(file_, description_text(field), arrays);
    }

    void append(const FieldSlab& slab, std::int64_t first_slice) override {
        for (std::size_t i = 0; i < infos_.size(); ++i) {
            const OutputInfo& info = infos_[i];
            file_.seek(offsets_[i] + static_cast<std::uint64_t>(first_slice) * slice_ * info.sample_bytes());
            write_little_endian(file_, slab.bytes(info.output), bytes_of(info.type));
        }
    }

    void finish() override {
        const std::array<AtomicFile*, 2> files{&xdmf_, &file_};
        AtomicFile::commit_all(files);
    }

private:
    std::vector<OutputInfo> infos_;
    std::uint64_t slice_;
    std::vector<std::uint64_t> offsets_;
    AtomicFile xdmf_;
    AtomicFile file_;
};

/// HDF5 must know the number of bricks before it lays out the file, so values wait in unfinished files.
class SparseH5Writer : public SparseFormatWriter {
public:
    SparseH5Writer(const std::string& path, const FieldDescription& field, OutputSet outputs)
        : path_(path), field_(field), infos_(infos_of(outputs)), file_(path) {
        for (std::size_t i = 0; i < infos_.size(); ++i) spills_.emplace_back(path);
    }

    void append(const SparseSlab& slab) override {
        for (std::size_t i = 0; i < infos_.size(); ++i) spills_[i].append(slab.values.bytes(infos_[i].output));
        bricks_.insert(bricks_.end(), slab.bricks.begin(), slab.bricks.end());
        runs_.insert(runs_.end(), slab.inside.begin(), slab.inside.end());
    }

    void finish() override {
        const std::pair lattice(field_.grid.origin, field_.grid.spacing);
        std::vector<NewArray> arrays{{bricks_name, ElementType::int64, {bricks_.size(), 3}, lattice},
                                     {runs_name, ElementType::int64, {runs_.size(), 4}, {}}};
        for (const OutputInfo& info : infos_) {
            const std::vector<std::int64_t> shape = sparse_shape(bricks_.size(), info);
            arrays.push_back({info.name, info.type, {shape.begin(), shape.end()}, {}});
        }
        const std::vector<std::uint64_t> offsets = H5Layout(path_).write(file_, description_text(field_), arrays);
        write(offsets[0], std::as_bytes(std::span(bricks_)), sizeof(std::int64_t));
        write(offsets[1], std::as_bytes(std::span(runs_)), sizeof(std::int64_t));
        std::vector<std::byte> part;
        for (std::size_t i = 0; i < infos_.size(); ++i) {
            constexpr std::uint64_t most = std::uint64_t{1} << 22;
            for (std::uint64_t begin = 0; begin < spills_[i].size(); begin += most) {
                part.resize(static_cast<std::size_t>(std::min(most, spills_[i].size() - begin)));
                spills_[i].read(begin, part);
                write(offsets[2 + i] + begin, part, bytes_of(infos_[i].type));
            }
        }
        file_.commit();
        remove_xdmf();
    }

private:
    /// A dense field that was in the file has left a file that describes its arrays.
    void remove_xdmf() const {
        std::error_code error;
        std::filesystem::remove(xdmf_path(path_), error);
        if (error)
            throw Error(ErrorCode::output_failure,
                        fmt::format("cannot remove '{}', which describes the former content of '{}': {}",
                                    xdmf_path(path_), path_, error.message()));
    }

    void write(std::uint64_t offset, std::span<const std::byte> values, std::size_t width) {
        if (values.empty()) return;
        file_.seek(offset);
        write_little_endian(file_, values, width);
    }

    std::string path_;
    FieldDescription field_;
    std::vector<OutputInfo> infos_;
    AtomicFile file_;
    std::deque<SpillFile> spills_;  // of each output
    std::vector<Index3> bricks_;
    std::vector<BrickRun> runs_;
};

}  // namespace

std::unique_ptr<FormatWriter> h5_writer(const std::string& path, const FieldDescription& field, OutputSet outputs) {
    return std::make_unique<H5Writer>(path, field, outputs);
}

std::unique_ptr<SparseFormatWriter> sparse_h5_writer(const std::string& path, const FieldDescription& field,
                                                     OutputSet outputs) {
    return std::make_unique<SparseH5Writer>(path, field, outputs);
}

void write_h5_arrays(const std::string& path, const std::string& description, std::span<const FileArray> arrays) {
    AtomicFile file(path);
    std::vector<NewArray> layout;
    for (const FileArray& array : arrays)
        layout.push_back({array.name, array.type, {array.shape.begin(), array.shape.end()}, {}});
    const std::vector<std::uint64_t> offsets = H5Layout(path).write(file, description, layout);
    for (std::size_t n = 0; n < arrays.size(); ++n) {
        if (arrays[n].bytes.empty()) continue;
        file.seek(offsets[n]);
        write_little_endian(file, arrays[n].bytes, bytes_of(arrays[n].type));
    }
    file.commit();
}

void check_h5(const std::string& path, OutputSet) {
    check_utf8(path, "the .xdmf file, which names the .h5 file,");
}

}  // namespace clsdf
