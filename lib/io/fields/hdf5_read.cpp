#include "io/fields/field_files.hpp"
#include "io/fields/hdf5.hpp"
#include "io/fields/sparse_files.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>

namespace clsdf::hdf5 {

namespace {

std::mutex& one_at_a_time() {
    static std::mutex mutex;
    return mutex;
}

/// HDF5 1.10 does not free the header of an object that it finds damaged. At the end of the process it waits for the
/// header in vain and prints a message, unless printing is off.
class QuietEnd {
public:
    QuietEnd() { H5open(); }  // destructors run in reverse order
    ~QuietEnd() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }
    QuietEnd(const QuietEnd&) = delete;
    QuietEnd& operator=(const QuietEnd&) = delete;
};

}  // namespace

Session::Session() : lock_(one_at_a_time()) {
    static const QuietEnd quiet_end;
    H5Eget_auto2(H5E_DEFAULT, &print_, &print_data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Session::~Session() {
    H5Eset_auto2(H5E_DEFAULT, print_, print_data_);
}

std::string Session::reason() {
    std::string text = "an unknown error";
    // The first one is where it began.
    const H5E_walk2_t take = [](unsigned, const H5E_error2_t* error, void* result) -> herr_t {
        if (error->desc != nullptr) *static_cast<std::string*>(result) = error->desc;
        return 1;
    };
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take, &text);
    return text;
}

Handle access() {
    Handle list(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
#if H5_VERSION_GE(1, 10, 7)
    H5Pset_file_locking(list.get(), false, true);
#endif
    return list;
}

}  // namespace clsdf::hdf5

namespace clsdf {

namespace {

using hdf5::Handle;
using hdf5::StoredArray;
using hdf5::WantedArray;

constexpr std::size_t largest_description = std::size_t{1} << 20;
constexpr std::string_view signature = "\x89HDF\r\n\x1a\n";

/// Reads the offsets of the values by HDF5, from files whose structure has checksums. HDF5 does not check other files.
class WithChecksums : public hdf5::Source {
public:
    explicit WithChecksums(InputFile& file) : file_(file), root_(open(file)) {}

    bool has(const std::string& path) const override {
        // HDF5 wants the groups that it is in to be there.
        for (std::size_t end = path.find('/'); end != std::string::npos; end = path.find('/', end + 1))
            if (H5Lexists(root_.get(), path.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
        return H5Lexists(root_.get(), path.c_str(), H5P_DEFAULT) > 0;
    }

    StoredArray array(const WantedArray& wanted) const override {
        const std::string& name = wanted.name;
        if (!has(name)) file_.fail(fmt::format("there is no dataset '/{}'", name));
        const Handle array = opened(name);
        const Handle creation(H5Dget_create_plist(array.get()), H5Pclose);
        if (H5Pget_external_count(creation.get()) != 0) fail(name, "its values are in another file; save them in this");
        if (H5Pget_nfilters(creation.get()) != 0)
            fail(name, "its values are compressed; save them without filters (h5repack -f NONE -l CONTI)");
        if (H5Pget_layout(creation.get()) == H5D_CHUNKED)
            fail(name, "its values are in chunks of HDF5's newer format; save it contiguous (h5repack -l CONTI)");
        if (H5Pget_layout(creation.get()) != H5D_CONTIGUOUS)
            fail(name, "its values are neither contiguous nor in chunks; save it contiguous (h5repack -l CONTI)");
        StoredArray stored;
        stored.shape = shape_of(array, wanted);
        stored.values = type_of(array, wanted);
        if (std::ranges::find(stored.shape, 0) != stored.shape.end()) return stored;
        const haddr_t offset = H5Dget_offset(array.get());
        if (offset == HADDR_UNDEF) fail(name, "it has no values");
        stored.values.offset = offset;
        stored.values.bytes = H5Dget_storage_size(array.get());
        return stored;
    }

    std::vector<double> numbers(const std::string& object, const std::string& name, std::size_t count,
                                const char* what) const override {
        const Handle opened_object = opened_any(object);
        if (H5Aexists(opened_object.get(), name.c_str()) <= 0)
            fail(object, fmt::format("attribute '{}' is missing; state {}", name, what));
        const Handle attribute(H5Aopen(opened_object.get(), name.c_str(), H5P_DEFAULT), H5Aclose);
        const Handle space(H5Aget_space(attribute.get()), H5Sclose);
        const Handle type(H5Aget_type(attribute.get()), H5Tclose);
        std::vector<double> result(count);
        const H5T_class_t kind_of_type = H5Tget_class(type.get());
        if (H5Sget_simple_extent_npoints(space.get()) != static_cast<hssize_t>(count) ||
            (kind_of_type != H5T_FLOAT && kind_of_type != H5T_INTEGER) ||
            H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, result.data()) < 0)
            fail(object, fmt::format("attribute '{}' is not {}", name, what));
        return result;
    }

    std::optional<std::string> text(const std::string& group, const std::string& name) const override {
        const Handle opened_group = opened_any(group);
        if (H5Aexists(opened_group.get(), name.c_str()) <= 0) return std::nullopt;
        const Handle attribute(H5Aopen(opened_group.get(), name.c_str(), H5P_DEFAULT), H5Aclose);
        const Handle type(H5Aget_type(attribute.get()), H5Tclose);
        const Handle space(H5Aget_space(attribute.get()), H5Sclose);
        const std::size_t size = H5Tget_size(type.get());
        std::string text(std::min(size, largest_description), '\0');
        if (H5Tget_class(type.get()) != H5T_STRING || H5Tis_variable_str(type.get()) != 0 ||
            H5Sget_simple_extent_npoints(space.get()) != 1 || size > largest_description ||
            H5Aread(attribute.get(), type.get(), text.data()) < 0)
            file_.fail(fmt::format("attribute '{}' is not one text of fixed length", name));
        return text.substr(0, text.find('\0'));
    }

private:
    static Handle open(InputFile& file) {
        const Handle access = hdf5::access();
        Handle root(H5Fopen(file.path().c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose);
        if (!root.is_valid()) file.fail("HDF5: " + hdf5::Session::reason());
        return root;
    }

    Handle opened(const std::string& name) const {
        Handle array(H5Dopen2(root_.get(), name.c_str(), H5P_DEFAULT), H5Dclose);
        if (!array.is_valid()) fail(name, "HDF5: " + hdf5::Session::reason());
        return array;
    }

    /// A group or an array.
    Handle opened_any(const std::string& path) const {
        Handle object(H5Oopen(root_.get(), path.empty() ? "/" : path.c_str(), H5P_DEFAULT), H5Oclose);
        if (!object.is_valid()) fail(path, "HDF5: " + hdf5::Session::reason());
        return object;
    }

    std::vector<std::int64_t> shape_of(const Handle& array, const WantedArray& wanted) const {
        const Handle space(H5Dget_space(array.get()), H5Sclose);
        std::vector<hsize_t> shape(wanted.axes.size());
        if (H5Sget_simple_extent_ndims(space.get()) != static_cast<int>(shape.size()) ||
            H5Sget_simple_extent_dims(space.get(), shape.data(), nullptr) < 0)
            fail(wanted.name, fmt::format("it has not {} dimensions: {}", shape.size(), fmt::join(wanted.axes, ", ")));
        return {shape.begin(), shape.end()};
    }

    RawValues type_of(const Handle& array, const WantedArray& wanted) const {
        const Handle type(H5Dget_type(array.get()), H5Tclose);
        const auto is = [&](hid_t other) { return H5Tequal(type.get(), other) > 0; };
        RawValues values;
        if (is(H5T_IEEE_F32LE) || is(H5T_IEEE_F32BE))
            values.type = ElementType::float32;
        else if (is(H5T_IEEE_F64LE) || is(H5T_IEEE_F64BE))
            values.type = ElementType::float64;
        else if (is(H5T_STD_U32LE) || is(H5T_STD_U32BE))
            values.type = ElementType::uint32;
        else if (is(H5T_STD_I64LE) || is(H5T_STD_I64BE))
            values.type = ElementType::int64;
        else if (is(H5T_STD_U8LE) || is(H5T_STD_U8BE))
            values.type = ElementType::uint8;
        else
            fail(wanted.name, "its values are neither floats nor doubles nor indices of 8, 32 or 64 bits");
        if (!reads_as(values.type, wanted.type))
            fail(wanted.name, fmt::format("{} is of another type", wanted.description));
        values.order = H5Tget_order(type.get()) == H5T_ORDER_BE ? std::endian::big : std::endian::little;
        return values;
    }

    [[noreturn]] void fail(const std::string& array, const std::string& what) const {
        file_.fail(fmt::format("dataset '/{}': {}", array, what));
    }

    InputFile& file_;
    Handle root_;
};

/// The version of the superblock, 0 and 1 of which have no checksums.
int version_of(InputFile& file) {
    const std::string beginning = file.beginning(signature.size() + 1);
    if (!beginning.starts_with(signature)) file.fail(R"(not an HDF5 file: it does not begin with "\x89HDF")");
    if (beginning.size() == signature.size()) file.fail("the file is truncated");
    return static_cast<unsigned char>(beginning.back());
}

using Place = std::array<std::size_t, 4>;  // the last axis has values side by side

/// Three dimensions become the last three.
template <class Numbers>
Place padded(const Numbers& numbers, std::size_t dimensions, std::size_t padding) {
    Place place;
    place.fill(padding);
    for (std::size_t i = 0; i < dimensions; ++i) place[4 - dimensions + i] = static_cast<std::size_t>(numbers[i]);
    return place;
}

void read_chunks(InputFile& file, const StoredArray& array, ElementType wanted, std::span<std::byte> room) {
    const std::size_t width = bytes_of(wanted);
    const std::size_t dimensions = array.shape.size();
    const Place shape = padded(array.shape, dimensions, 1);
    const Place edges = padded(array.chunk_shape, dimensions, 1);
    const std::size_t count = edges[0] * edges[1] * edges[2] * edges[3];
    std::vector<std::byte> stored(count * bytes_of(array.values.type));
    std::vector<std::byte> converted(count * width);
    for (const StoredArray::Chunk& chunk : array.chunks) {
        file.read(chunk.offset, stored);
        convert_values(stored, array.values, wanted, converted);
        const Place first = padded(chunk.first, dimensions, 0);
        Place size;
        for (std::size_t axis = 0; axis < 4; ++axis) size[axis] = std::min(edges[axis], shape[axis] - first[axis]);
        for (std::size_t a = 0; a < size[0]; ++a)
            for (std::size_t b = 0; b < size[1]; ++b)
                for (std::size_t c = 0; c < size[2]; ++c) {
                    const std::size_t from = ((a * edges[1] + b) * edges[2] + c) * edges[3];
                    const std::size_t to =
                        (((first[0] + a) * shape[1] + first[1] + b) * shape[2] + first[2] + c) * shape[3] + first[3];
                    std::ranges::copy(std::span(converted).subspan(from * width, size[3] * width),
                                      room.begin() + static_cast<std::ptrdiff_t>(to * width));
                }
    }
}

}  // namespace

void hdf5::read_samples(InputFile& file, const Source& source, const WantedArray& wanted, const OutputInfo& info,
                        Field& field) {
    const StoredArray array = source.array(wanted);
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (array.shape[2 - axis] != field.grid.size[axis] ||
            (array.shape.size() > 3 && array.shape[3] != static_cast<std::int64_t>(info.components)))
            file.fail(fmt::format("dataset '/{}': the shape ({}) is not that of the grid", wanted.name,
                                  fmt::join(array.shape, ", ")));
    if (array.chunks.empty()) {
        checked_count(file, array.values, array.shape);
        read_output(file, array.values, info, field);
    } else {
        read_chunks(file, array, info.type, allocate_output(info, field));
    }
}

void hdf5::with_source(const std::string& path, const std::function<void(InputFile&, const Source&)>& f) {
    InputFile file(path);
    if (version_of(file) < 2) return f(file, *open_without_checksums(file));
    const Session session;
    f(file, WithChecksums(file));
}

namespace {

Field read_dense(InputFile& file, const hdf5::Source& source, OutputSet wanted) {
    const OutputInfo& distance = info_of(Output::distance);
    Field field;
    field.band = Band::full();
    field.sign = SignRule::automatic;
    const std::vector<std::int64_t> shape = source.array(WantedArray(distance)).shape;
    field.grid.size = {shape[2], shape[1], shape[0]};
    field.grid.origin = source.triple(distance.name, "origin");
    field.grid.spacing = source.triple(distance.name, "spacing");
    field.grid.validate();
    if (const std::optional<std::string> text = source.text("", "clsdf"))
        field = parse_description(file.path() + ": attribute 'clsdf'", *text, field.grid).field;
    hdf5::read_samples(file, source, WantedArray(distance), distance, field);
    for (const OutputInfo& info : extra_outputs())
        if (wanted.contains(info.output) && source.has(info.name))
            hdf5::read_samples(file, source, WantedArray(info), info, field);
    return field;
}

/// The values of an array of a sparse field, whose first axis has any length.
StoredArray sparse_array(InputFile& file, const hdf5::Source& source, const WantedArray& wanted,
                         std::vector<std::int64_t> shape) {
    StoredArray array = source.array(wanted);
    if (!array.chunks.empty())
        file.fail(fmt::format("dataset '/{}': its values are in chunks; save it contiguous (h5repack -l CONTI)",
                              wanted.name));
    if (shape[0] < 0) shape[0] = array.shape[0];
    if (array.shape != shape || shape[0] < 0)  // 2^63 and more
        file.fail(fmt::format("dataset '/{}': the shape ({}) is not ({})", wanted.name, fmt::join(array.shape, ", "),
                              fmt::join(shape, ", ")));
    if (shape[0] > 0) checked_count(file, array.values, shape);
    return array;
}

SparseField read_sparse(InputFile& file, const hdf5::Source& source, OutputSet wanted) {
    const std::optional<std::string> text = source.text("", "clsdf");
    if (!text) file.fail("attribute 'clsdf' is missing, which states the grid and the band of a sparse field");
    SparseField field;
    static_cast<FieldDescription&>(field) = parse_description(file.path() + ": attribute 'clsdf'", *text).field;
    const auto read = [&](const StoredArray& array, ElementType type, std::span<std::byte> room) {
        if (!room.empty()) read_values(file, array.values, type, room);
    };
    const StoredArray bricks = sparse_array(
        file, source, {bricks_name, "index of the first sample", ElementType::int64, {"brick", "axis"}}, {-1, 3});
    field.bricks.resize(static_cast<std::size_t>(bricks.shape[0]));
    read(bricks, ElementType::int64, std::as_writable_bytes(std::span(field.bricks)));
    const StoredArray runs = sparse_array(
        file, source, {runs_name, "index of the first sample, and bricks", ElementType::int64, {"run", "number"}},
        {-1, 4});
    field.inside.resize(static_cast<std::size_t>(runs.shape[0]));
    read(runs, ElementType::int64, std::as_writable_bytes(std::span(field.inside)));
    for (const OutputInfo& info : output_table()) {
        if (info.output != Output::distance && (!wanted.contains(info.output) || !source.has(info.name))) continue;
        const StoredArray array = sparse_array(file, source, WantedArray(info, {"brick", "z", "y", "x"}),
                                               sparse_shape(field.bricks.size(), info));
        read(array, info.type, field.resize(info.output, field.bricks.size()));
    }
    check_sparse(file, field);
    return field;
}

}  // namespace

Field read_h5(const std::string& path, OutputSet wanted) {
    Field field;
    hdf5::with_source(path, [&](InputFile& file, const hdf5::Source& source) {
        field =
            source.has(bricks_name) ? to_dense(read_sparse(file, source, wanted)) : read_dense(file, source, wanted);
    });
    return field;
}

std::optional<SparseField> read_sparse_h5(const std::string& path, OutputSet wanted) {
    std::optional<SparseField> field;
    hdf5::with_source(path, [&](InputFile& file, const hdf5::Source& source) {
        if (source.has(bricks_name)) field = read_sparse(file, source, wanted);
    });
    return field;
}

}  // namespace clsdf
