#pragma once

#include "core/atomic_file.hpp"
#include "field/hdf5.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>

namespace clsdf::hdf5 {

/// What HDF5 writes of a file when the values of its arrays are left out, in memory. A file of 4 GiB takes some
/// kilobytes here; and where a disk is full, HDF5 1.10 would crash when the program ends.
class Layout {
public:
    /// For H5Pset_driver: files that are created with this list are this layout, which must live as long as they do.
    /// Holds the driver of HDF5's virtual file layer as long as it lives itself.
    Layout();
    void use(const Handle& access);
    bool is_valid() const { return driver_.is_valid(); }

    /// Zeros stand for what is left out. The values have to be written afterwards.
    void write_to(AtomicFile& file) const;

    void write(std::uint64_t begin, const std::byte* bytes, std::size_t count);
    void read(std::uint64_t begin, std::byte* bytes, std::size_t count) const;
    std::uint64_t end = 0;  ///< of the file, as HDF5 sets it

private:
    using Page = std::array<std::byte, 4096>;

    std::map<std::uint64_t, Page> pages_;
    Handle driver_;
};

}  // namespace clsdf::hdf5
