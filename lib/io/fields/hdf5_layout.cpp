#include "io/fields/hdf5_layout.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <new>
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

/// HDF5 lays out the file and writes everything but the values of the arrays.
class LayoutWriter {
public:
    explicit LayoutWriter(const std::string& path) : path_(path) {}

    std::vector<std::uint64_t> lay_out(Layout& layout, const NewContent& content) const {
        const Handle access = checked(hdf5::access());
        layout.use(access);
        check(H5Pset_libver_bounds(access.get(), H5F_LIBVER_V18, H5F_LIBVER_LATEST));
        const Handle creation = checked({H5Pcreate(H5P_FILE_CREATE), H5Pclose});
        check(H5Pset_obj_track_times(creation.get(), false));
        Handle file = checked({H5Fcreate("layout", H5F_ACC_TRUNC, creation.get(), access.get()), H5Fclose});
        write_attributes(file.get(), content.attributes);
        for (const NewGroup& group : content.groups) write_group(file.get(), group);
        std::vector<std::uint64_t> offsets;
        offsets.reserve(content.arrays.size());
        for (const NewArray& array : content.arrays) offsets.push_back(write_array(file.get(), array));
        if (!file.close()) fail();
        return offsets;
    }

    [[noreturn]] void fail() const {
        throw Error(ErrorCode::output_failure, fmt::format("cannot write '{}': HDF5: {}", path_, Session::reason()));
    }

private:
    void write_group(hid_t file, const NewGroup& made) const {
        const Handle creation = checked({H5Pcreate(H5P_GROUP_CREATE), H5Pclose});
        check(H5Pset_obj_track_times(creation.get(), false));
        const Handle group =
            checked({H5Gcreate2(file, made.name.c_str(), H5P_DEFAULT, creation.get(), H5P_DEFAULT), H5Gclose});
        write_attributes(group.get(), made.attributes);
    }

    std::uint64_t write_array(hid_t file, const NewArray& made) const {
        const Handle array = made_array(file, made.name, type_of(made.type), made.shape);
        write_attributes(array.get(), made.attributes);
        if (std::ranges::find(made.shape, hsize_t{0}) != made.shape.end()) return 0;
        const haddr_t offset = H5Dget_offset(array.get());
        if (offset == HADDR_UNDEF) fail();
        return offset;
    }

    Handle made_array(hid_t file, const std::string& name, hid_t type, const std::vector<hsize_t>& shape) const {
        const Handle space =
            checked({H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose});
        const Handle creation = checked({H5Pcreate(H5P_DATASET_CREATE), H5Pclose});
        check(H5Pset_layout(creation.get(), H5D_CONTIGUOUS));
        check(H5Pset_alloc_time(creation.get(), H5D_ALLOC_TIME_EARLY));
        check(H5Pset_fill_time(creation.get(), H5D_FILL_TIME_NEVER));
        check(H5Pset_obj_track_times(creation.get(), false));
        return checked(
            {H5Dcreate2(file, name.c_str(), type, space.get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT), H5Dclose});
    }

    void write_attributes(hid_t object, const std::vector<NewAttribute>& attributes) const {
        for (const NewAttribute& made : attributes)
            std::visit([&](const auto& value) { write_value(object, made.name, value); }, made.value);
    }

    void write_value(hid_t object, const std::string& name, const std::vector<double>& values) const {
        write_numbers(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values);
    }

    void write_value(hid_t object, const std::string& name, const std::vector<std::int64_t>& values) const {
        write_numbers(object, name, H5T_STD_I64LE, H5T_NATIVE_INT64, values);
    }

    void write_value(hid_t object, const std::string& name, const std::string& text) const {
        write_text(object, name, text, text_type(text.size() + 1, H5T_CSET_UTF8, H5T_STR_NULLTERM));
    }

    void write_value(hid_t object, const std::string& name, const NewAttribute::Ascii& ascii) const {
        write_text(object, name, ascii.text, text_type(ascii.text.size(), H5T_CSET_ASCII, H5T_STR_NULLPAD));
    }

    void write_value(hid_t object, const std::string& name, const std::vector<std::string>& texts) const {
        std::size_t length = 0;
        for (const std::string& text : texts) length = std::max(length, text.size() + 1);
        std::string letters;
        for (const std::string& text : texts) letters += text + std::string(length - text.size(), '\0');
        const hsize_t count = texts.size();
        const Handle space = checked({H5Screate_simple(1, &count, nullptr), H5Sclose});
        const Handle type = text_type(length, H5T_CSET_UTF8, H5T_STR_NULLTERM);
        write_attribute(object, name, type.get(), type.get(), space, letters.data());
    }

    template <class Number>
    void write_numbers(hid_t object, const std::string& name, hid_t stored, hid_t given,
                       const std::vector<Number>& values) const {
        const hsize_t count = values.size();
        const Handle space = checked({H5Screate_simple(1, &count, nullptr), H5Sclose});
        write_attribute(object, name, stored, given, space, values.data());
    }

    void write_text(hid_t object, const std::string& name, const std::string& text, const Handle& type) const {
        const Handle space = checked({H5Screate(H5S_SCALAR), H5Sclose});
        write_attribute(object, name, type.get(), type.get(), space, text.c_str());
    }

    Handle text_type(std::size_t size, H5T_cset_t letters, H5T_str_t end) const {
        Handle type = checked({H5Tcopy(H5T_C_S1), H5Tclose});
        check(H5Tset_size(type.get(), size));
        check(H5Tset_cset(type.get(), letters));
        check(H5Tset_strpad(type.get(), end));
        return type;
    }

    void write_attribute(hid_t object, const std::string& name, hid_t stored, hid_t given, const Handle& space,
                         const void* values) const {
        const Handle attribute =
            checked({H5Acreate2(object, name.c_str(), stored, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose});
        check(H5Awrite(attribute.get(), given, values));
    }

    Handle checked(Handle handle) const {
        if (!handle.is_valid()) fail();
        return handle;
    }

    void check(herr_t result) const {
        if (result < 0) fail();
    }

    const std::string& path_;
};

}  // namespace

std::vector<std::uint64_t> write_layout(AtomicFile& target, const std::string& path, const NewContent& content) {
    const Session session;
    const LayoutWriter writer(path);
    Layout layout;
    if (!layout.is_valid()) writer.fail();
    std::vector<std::uint64_t> offsets = writer.lay_out(layout, content);
    layout.write_to(target);
    return offsets;
}

std::vector<hsize_t> shape_of(const Grid& grid, const OutputInfo& info) {
    std::vector<hsize_t> shape(grid.size.rbegin(), grid.size.rend());
    if (info.components > 1) shape.push_back(static_cast<hsize_t>(info.components));
    return shape;
}

}  // namespace clsdf::hdf5
