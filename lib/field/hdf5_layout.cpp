#include "field/hdf5_layout.hpp"

#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif

#include <algorithm>
#include <span>

namespace clsdf::hdf5 {
namespace {

// What HDF5 sees of a layout: its own record, and ours behind it.
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

}  // namespace

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

}  // namespace clsdf::hdf5
