#pragma once

#include "core/outputs.hpp"
#include "io/meshes/raw_values.hpp"

#include <clsdf/field.hpp>
#include <clsdf/grid.hpp>

#include <hdf5.h>

#include <array>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace clsdf::hdf5 {

/// While it lives, no other thread is in HDF5, which need not be thread-safe, and HDF5 prints nothing.
class Session {
public:
    Session();
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    /// HDF5's message of the call that failed last.
    static std::string reason();

private:
    std::lock_guard<std::mutex> lock_;
    H5E_auto2_t print_ = nullptr;  // the setting of the calling program
    void* print_data_ = nullptr;
};

/// A handle and the function that closes it.
class Handle {
public:
    Handle(hid_t id, herr_t (*closing)(hid_t)) : id_(id), close_(closing) {}
    Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    ~Handle() { close(); }

    hid_t get() const { return id_; }
    bool is_valid() const { return id_ >= 0; }
    /// Whether it closed without an error.
    bool close() { return id_ < 0 || close_(std::exchange(id_, H5I_INVALID_HID)) >= 0; }

private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

/// The property list for opening files: without locks, which some file systems do not support.
Handle access();

/// An array that is looked for.
struct WantedArray {
    std::string name;
    std::string description;  ///< of its values
    ElementType type;
    std::vector<std::string> axes;  ///< slowest first

    explicit WantedArray(const OutputInfo& info, std::vector<std::string> axes_of_samples = {"z", "y", "x"})
        : name(info.name), description(info.description), type(info.type), axes(std::move(axes_of_samples)) {
        if (info.components > 1) axes.emplace_back("component");
    }
    WantedArray(std::string name_in, std::string description_in, ElementType type_in, std::vector<std::string> axes_in)
        : name(std::move(name_in)), description(std::move(description_in)), type(type_in), axes(std::move(axes_in)) {}
};

/// The type and the offsets of an array in an HDF5 file. A contiguous array has no chunks, and its values lie in a row.
/// A chunked array has each chunk once.
struct StoredArray {
    struct Chunk {
        std::array<std::uint64_t, 4> first{};  ///< in order of the shape; of three dimensions the last is 0
        std::uint64_t offset = 0;
    };

    std::vector<std::int64_t> shape;  ///< as the axes that are wanted
    RawValues values;
    std::vector<Chunk> chunks;
    std::array<std::uint64_t, 4> chunk_shape{};  ///< of three dimensions the last is 1
};

/// The parts of an HDF5 file that a field needs. Every function throws Error(unreadable_input).
class Source {
public:
    Source() = default;
    Source(const Source&) = delete;
    Source& operator=(const Source&) = delete;
    virtual ~Source() = default;

    /// Whether there is an array or a group of that path: "distance", "VTKHDF/PointData".
    virtual bool has(const std::string& path) const = 0;
    /// The array must have the number of dimensions and the type of values that are wanted.
    virtual StoredArray array(const WantedArray& wanted) const = 0;
    /// An attribute of an array or a group: `count` numbers, described by `what`.
    virtual std::vector<double> numbers(const std::string& object, const std::string& name, std::size_t count,
                                        const char* what) const = 0;
    /// A text of fixed length: an attribute of a group, "" for the file's own.
    virtual std::optional<std::string> text(const std::string& group, const std::string& name) const = 0;

    /// Three numbers along x, y, z.
    Vec3 triple(const std::string& object, const std::string& name) const {
        const std::vector<double> found = numbers(object, name, 3, "three numbers along x, y, z");
        return {found[0], found[1], found[2]};
    }
};

/// Opens a file in the format before HDF5 1.8, HDF5's default (superblock of version 0 or 1). It has no checksums, and
/// HDF5 itself may crash if it is damaged. So clsdf has its own reader, which knows the part of the format that fields
/// need and checks every number. The file must outlive the source.
std::unique_ptr<Source> open_without_checksums(InputFile& file);

/// Calls f with the parts of a file, by the reader of its format.
void with_source(const std::string& path, const std::function<void(InputFile&, const Source&)>& f);

/// Reads an output of a field's samples from an array of three axes, which may be chunked, and one more for components.
/// Throws Error(unreadable_input).
void read_samples(InputFile& file, const Source& source, const WantedArray& wanted, const OutputInfo& info,
                  Field& field);

}  // namespace clsdf::hdf5
