#include "io/fields/segment_files.hpp"

#include "core/files.hpp"
#include "io/meshes/npy_header.hpp"

#include <clsdf/error.hpp>
#include <clsdf/io.hpp>
#include <clsdf/row_tables.hpp>

#include <fmt/format.h>

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <deque>

namespace clsdf {

namespace {

/// The bytes of numbers, least first, which is how these files have them.
class Bytes {
public:
    template <typename Number>
    Bytes& add(Number number) {
        for (std::size_t i = 0; i < sizeof number; ++i)
            bytes_.push_back(static_cast<char>(static_cast<std::uint64_t>(number) >> (8 * i) & 0xffU));
        return *this;
    }
    Bytes& add_text(const std::string& text) {
        bytes_ += text;
        return *this;
    }
    const std::string& text() const { return bytes_; }

private:
    std::string bytes_;
};

std::uint32_t with_crc(std::uint32_t crc, std::span<const std::byte> bytes) {
    if (bytes.empty()) return crc;  // crc32_z(crc, null, 0) is 0
    return static_cast<std::uint32_t>(crc32_z(crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

constexpr std::uint64_t most_of_old_zip = 0xffffffff;

/// A file of the archive.
struct Entry {
    std::string name, header;  ///< header: of the .npy file
    std::uint64_t size, begin;
    std::uint32_t crc;

    bool is_large() const { return size >= most_of_old_zip; }
    bool is_far() const { return begin >= most_of_old_zip; }

    /// From the version to the lengths; is_central: with the place.
    Bytes description(bool is_central) const {
        const bool with_extra = is_large() || (is_central && is_far());
        const auto old_size = static_cast<std::uint32_t>(std::min(size, most_of_old_zip));
        Bytes extra;
        if (is_large()) extra.add(size).add(size);
        if (is_central && is_far()) extra.add(begin);
        Bytes bytes;
        bytes.add(is_central ? std::uint32_t{0x02014b50} : std::uint32_t{0x04034b50});
        if (is_central) bytes.add(std::uint16_t{45});
        // Not compressed, of 1 January 1980.
        bytes.add(std::uint16_t{45}).add(std::uint16_t{0}).add(std::uint16_t{0}).add(std::uint16_t{0});
        bytes.add(std::uint16_t{0x21}).add(crc).add(old_size).add(old_size);
        bytes.add(static_cast<std::uint16_t>(name.size()));
        bytes.add(static_cast<std::uint16_t>(with_extra ? extra.text().size() + 4 : 0));
        if (is_central) {
            bytes.add(std::uint16_t{0}).add(std::uint16_t{0}).add(std::uint16_t{0}).add(std::uint32_t{0});
            bytes.add(static_cast<std::uint32_t>(std::min(begin, most_of_old_zip)));
        }
        bytes.add_text(name);
        if (with_extra)
            bytes.add(std::uint16_t{1}).add(static_cast<std::uint16_t>(extra.text().size())).add_text(extra.text());
        return bytes;
    }
};

}  // namespace

void write_npz(const std::string& path, std::span<const FileArray> arrays) {
    AtomicFile file(path);
    std::vector<Entry> entries;
    std::uint64_t place = 0;
    const auto write = [&](const std::string& text) {
        file.write(text);
        place += text.size();
    };
    for (const FileArray& array : arrays) {
        Entry entry{array.name + ".npy", npy_header(fmt::format("'{}'", npy_name_of(array.type)), array.shape), 0,
                    place, 0};
        entry.size = entry.header.size() + array.bytes.size();
        entry.crc = with_crc(with_crc(0, std::as_bytes(std::span(entry.header))), array.bytes);
        write(entry.description(false).text());
        write(entry.header);
        file.write(array.bytes);
        place += array.bytes.size();
        entries.push_back(std::move(entry));
    }
    const std::uint64_t directory = place;
    for (const Entry& entry : entries) write(entry.description(true).text());
    const std::uint64_t size = place - directory;
    if (directory >= most_of_old_zip) {
        const std::uint64_t end = place;
        write(Bytes()
                  .add(std::uint32_t{0x06064b50})
                  .add(std::uint64_t{44})
                  .add(std::uint16_t{45})
                  .add(std::uint16_t{45})
                  .add(std::uint32_t{0})
                  .add(std::uint32_t{0})
                  .add(std::uint64_t{entries.size()})
                  .add(std::uint64_t{entries.size()})
                  .add(size)
                  .add(directory)
                  .add(std::uint32_t{0x07064b50})
                  .add(std::uint32_t{0})
                  .add(end)
                  .add(std::uint32_t{1})
                  .text());
    }
    write(Bytes()
              .add(std::uint32_t{0x06054b50})
              .add(std::uint32_t{0})
              .add(static_cast<std::uint16_t>(entries.size()))
              .add(static_cast<std::uint16_t>(entries.size()))
              .add(static_cast<std::uint32_t>(size))
              .add(static_cast<std::uint32_t>(std::min(directory, most_of_old_zip)))
              .add(std::uint16_t{0})
              .text());
    file.commit();
}

namespace {

/// The arrays of a file, and those of their values that are made for it.
class Arrays {
public:
    template <typename Value>
    void add(const std::string& name, ElementType type, std::vector<std::int64_t> shape,
             const std::vector<Value>& values) {
        all_.push_back({name, type, std::move(shape), std::as_bytes(std::span(values))});
    }
    template <typename Value, std::size_t N>
    void add_three(const std::string& name, ElementType type, const std::array<Value, N>& values) {
        all_.push_back({name, type, {N}, std::as_bytes(std::span(values))});
    }
    /// The rows must live as long as this, and lie one after another.
    template <typename Column>
    void add(const Column& column, const typename Column::Rows& rows) {
        const ColumnValues values = column.values(rows);
        std::vector<std::int64_t> shape{static_cast<std::int64_t>(values.count)};
        for (const std::size_t n : column.shape)
            if (n != 0) shape.push_back(static_cast<std::int64_t>(n));
        all_.push_back({column.name, *column.types.begin(), std::move(shape),
                        std::span(values.first, values.count * values.stride)});
    }
    /// The group of each triangle.
    void add_groups(const std::string& name, std::vector<std::int64_t> shape,
                    const std::vector<std::uint32_t>& triangles, const FaceGroups& groups) {
        std::vector<std::uint32_t>& numbers = groups_.emplace_back();
        numbers.reserve(triangles.size());
        for (const std::uint32_t triangle : triangles) numbers.push_back(groups.of(triangle));
        add(name, ElementType::uint32, std::move(shape), numbers);
    }
    /// A byte for each sample.
    void add(const SampleSides& sides) {
        std::vector<std::uint8_t>& bytes = own_.emplace_back();
        bytes.resize(sides.sample_count());
        for (std::size_t n = 0; n < bytes.size(); ++n) bytes[n] = sides.is_inside(n) ? 1 : 0;
        add("inside", ElementType::uint8, {sides.size[2], sides.size[1], sides.size[0]}, bytes);
    }
    /// The grid must live as long as this.
    void add(const Grid& grid) {
        add_three("origin", ElementType::float64, grid.origin);
        add_three("spacing", ElementType::float64, grid.spacing);
        add_three("size", ElementType::int64, grid.size);
        add_three("first", ElementType::int64, grid.first);
    }

    void write(const std::string& path, const char* kind) const {
        if (ending_of(path) == ".h5")
            write_h5_arrays(path, fmt::format(R"({{"kind": "{}"}})", kind), all_);
        else
            write_npz(path, all_);
    }

private:
    std::vector<FileArray> all_;
    std::deque<std::vector<std::uint8_t>> own_;
    std::deque<std::vector<std::uint32_t>> groups_;
};

/// Whether the group of each link's triangle follows this column.
bool have_groups(const LinkColumn& column) {
    return column.target == &LinkTargets::triangles;
}

/// NumPy's name for a type.
const char* npy_type(ElementType type) {
    switch (type) {
        case ElementType::uint8:
            return "|u1";
        case ElementType::int32:
            return "<i4";
        case ElementType::uint32:
            return "<u4";
        default:
            return "<f8";
    }
}

/// A row for each link, as one structure.
void write_npy(const Links& links, const std::string& path, const FaceGroups* groups) {
    std::string fields;
    std::size_t row = 0;
    const auto add_field = [&](const char* name, ElementType type, std::size_t components) {
        fields += fmt::format("{}('{}', '{}'{})", fields.empty() ? "" : ", ", name, npy_type(type),
                              components == 1 ? "" : fmt::format(", ({},)", components));
        row += components * bytes_of(type);
    };
    for (const LinkColumn& column : link_columns) {
        add_field(column.item, *column.types.begin(), column.components());
        if (groups != nullptr && have_groups(column)) add_field("group", ElementType::uint32, 1);
    }
    std::vector<std::byte> rows(row * links.size());
    std::byte* to = rows.data();
    const auto put = [&](const void* from, std::size_t bytes) {
        std::memcpy(to, from, bytes);
        to += bytes;
    };
    for (std::size_t n = 0; n < links.size(); ++n)
        for (const LinkColumn& column : link_columns) {
            const ColumnValues values = column.values(links);
            put(values.first + n * values.stride, values.stride);
            if (groups == nullptr || !have_groups(column)) continue;
            const std::uint32_t group = groups->of(links.triangles[n]);
            put(&group, sizeof group);
        }
    AtomicFile file(path);
    file.write(npy_header("[" + fields + "]", {static_cast<std::int64_t>(links.size())}));
    file.write(rows);
    file.commit();
}

}  // namespace

void check_links_path(const std::string& path) {
    if (const std::string ending = ending_of(path); ending != ".npz" && ending != ".h5" && ending != ".npy")
        throw Error(ErrorCode::unsupported,
                    fmt::format("'{}': links are written as .npz, .h5 or .npy; choose one of them", path));
}

void check_crossings_path(const std::string& path) {
    if (const std::string ending = ending_of(path); ending != ".npz" && ending != ".h5")
        throw Error(ErrorCode::unsupported,
                    fmt::format("'{}': crossings are written as .npz or .h5; choose one of them", path));
}

namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& reason) {
    throw Error(ErrorCode::invalid_argument, fmt::format("'{}' is not written: {}", path, reason));
}

std::string text_of(const Index3& size) {
    return fmt::format("{} x {} x {}", size[0], size[1], size[2]);
}

void check_sides(const SampleSides& inside, const Grid& grid, const std::string& path) {
    if (inside.size != grid.size)
        refuse(path, fmt::format("`inside` has {} samples and the grid {}; pass the grid that was asked for",
                                 text_of(inside.size), text_of(grid.size)));
    if (const std::size_t bytes = (inside.sample_count() + 7) / 8; inside.bits.size() < bytes)
        refuse(path, fmt::format("`inside` has {} bytes of bits; {} are needed", inside.bits.size(), bytes));
}

/// Throws Error(invalid_argument) if the file would contradict itself.
void check_links(const Links& links, const Grid& grid, std::span<const LinkDirection> directions,
                 const std::string& path) {
    for (const LinkColumn& column : link_columns)
        if (const std::size_t size = column.values(links).count; size != links.size())
            refuse(path, fmt::format("`{}` has {} rows and `q` {}", column.name, size, links.size()));
    check_sides(links.inside, grid, path);
    for (std::size_t n = 0; n < links.size(); ++n) {
        if (links.directions[n] >= directions.size())
            refuse(path, fmt::format("link {} has direction {}, and the stencil {} directions; pass the stencil that "
                                     "was asked for",
                                     n, links.directions[n], directions.size()));
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (const std::int64_t offset = links.samples[n][axis] - grid.first[axis];
                offset < 0 || offset >= grid.size[axis])
                refuse(path, fmt::format("link {} begins at sample ({}, {}, {}), which is not in the grid; pass the "
                                         "grid that was asked for",
                                         n, links.samples[n][0], links.samples[n][1], links.samples[n][2]));
    }
}

/// The same.
void check_crossings(const Crossings& crossings, const Grid& grid, const std::string& path) {
    check_sides(crossings.inside, grid, path);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const EdgeCrossings& edges = crossings.axes[axis];
        Index3 size = grid.size;
        --size[axis];
        if (edges.size != size)
            refuse(path,
                   fmt::format("there are {} edges along {}, and the grid has {}; pass the grid that was asked for",
                               text_of(edges.size), "xyz"[axis], text_of(size)));
        const auto count = static_cast<std::size_t>(size[0] * size[1] * size[2]);
        if (edges.coordinates.size() != count || edges.triangles.size() != count ||
            (!edges.counts.empty() && edges.counts.size() != count))
            refuse(
                path,
                fmt::format("the arrays along {} have {}, {} and {} items; each needs one for each of {} edges",
                            "xyz"[axis], edges.coordinates.size(), edges.triangles.size(), edges.counts.size(), count));
    }
}

}  // namespace

void write_links(const Links& links, const Grid& grid, std::span<const LinkDirection> directions,
                 const std::string& path, const FaceGroups* groups) {
    check_links_path(path);
    check_links(links, grid, directions, path);
    if (ending_of(path) == ".npy") return write_npy(links, path, groups);
    const auto count = static_cast<std::int64_t>(links.size());
    const std::vector<LinkDirection> stencil(directions.begin(), directions.end());
    Arrays arrays;
    for (const LinkColumn& column : link_columns) {
        arrays.add(column, links);
        if (groups != nullptr && have_groups(column)) arrays.add_groups("groups", {count}, links.triangles, *groups);
    }
    arrays.add("stencil", ElementType::int32, {static_cast<std::int64_t>(stencil.size()), 3}, stencil);
    arrays.add(links.inside);
    arrays.add(grid);
    arrays.write(path, "links");
}

void write_crossings(const Crossings& crossings, const Grid& grid, const std::string& path, const FaceGroups* groups) {
    check_crossings_path(path);
    check_crossings(crossings, grid, path);
    Arrays arrays;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const EdgeCrossings& edges = crossings.axes[axis];
        const std::vector<std::int64_t> shape{edges.size[2], edges.size[1], edges.size[0]};
        const std::string name(1, "xyz"[axis]);
        arrays.add(name, ElementType::float64, shape, edges.coordinates);
        arrays.add(name + "_triangles", ElementType::uint32, shape, edges.triangles);
        if (groups != nullptr) arrays.add_groups(name + "_groups", shape, edges.triangles, *groups);
        if (!edges.counts.empty()) arrays.add(name + "_counts", ElementType::uint32, shape, edges.counts);
    }
    arrays.add(crossings.inside);
    arrays.add(grid);
    arrays.write(path, "crossings");
}

}  // namespace clsdf
