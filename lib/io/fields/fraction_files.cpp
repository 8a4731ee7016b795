// Files of fractions of cells.
#include "core/files.hpp"
#include "core/refuse.hpp"
#include "io/fields/segment_files.hpp"
#include "io/meshes/raw_values.hpp"

#include <clsdf/fractions.hpp>
#include <clsdf/io.hpp>
#include <clsdf/row_tables.hpp>

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace clsdf {

namespace {

/// Arrays that are made for a file.
class Arrays {
public:
    /// A column of rows.
    void add(const CellColumn& column, const std::vector<CellFraction>& rows) {
        const ColumnValues values = column.values(rows);
        const ElementType type = *column.types.begin();
        const std::size_t width = column.components() * bytes_of(type);
        std::vector<std::byte>& bytes = own_.emplace_back(rows.size() * width);
        for (std::size_t row = 0; row < rows.size(); ++row)
            std::memcpy(bytes.data() + row * width, values.first + row * values.stride, width);
        std::vector<std::int64_t> shape{static_cast<std::int64_t>(rows.size())};
        for (const std::size_t n : column.shape)
            if (n != 0) shape.push_back(static_cast<std::int64_t>(n));
        all_.push_back({column.name, type, std::move(shape), bytes});
    }
    /// The array must live as long as this.
    template <typename Values>
    void add(const char* name, ElementType type, std::vector<std::int64_t> shape, const Values& values) {
        all_.push_back({name, type, std::move(shape), std::as_bytes(std::span(values))});
    }
    const std::vector<FileArray>& all() const { return all_; }

private:
    std::vector<FileArray> all_;
    std::deque<std::vector<std::byte>> own_;
};

void write_rows(const Fractions& found, const std::string& path) {
    Arrays arrays;
    for (const CellColumn& column : cell_columns) arrays.add(column, found.cells);
    const auto [nx, ny, nz] = found.counts();
    std::vector<std::uint8_t> full(nx * ny * nz);
    for (std::size_t n = 0; n < full.size(); ++n) full[n] = found.is_full(n) ? 1 : 0;
    arrays.add("full", ElementType::uint8,
               {static_cast<std::int64_t>(nz), static_cast<std::int64_t>(ny), static_cast<std::int64_t>(nx)}, full);
    arrays.add("origin", ElementType::float64, {3}, found.grid.origin);
    arrays.add("spacing", ElementType::float64, {3}, found.grid.spacing);
    arrays.add("size", ElementType::int64, {3}, found.grid.size);
    arrays.add("first", ElementType::int64, {3}, found.grid.first);
    if (ending_of(path) == ".h5")
        write_h5_arrays(path, R"({"kind": "fractions"})", arrays.all());
    else
        write_npz(path, arrays.all());
}

/// An array of all cells in VTK's ImageData.
struct CellArray {
    const char* name;
    const char* type;
    std::size_t components;
    std::size_t width;  ///< bytes of a number
    std::function<std::vector<std::byte>()> make;
};

/// An array of values that the cells have which the surface does not meet, with the rows put in. It is made when it is
/// written.
template <typename Value, typename Uncut, typename Cut>
CellArray cell_array(const Fractions& found, const char* name, const char* type, std::size_t components, Uncut uncut,
                     Cut cut) {
    const auto make = [&found, components, uncut, cut] {
        const auto [nx, ny, nz] = found.counts();
        std::vector<std::byte> bytes(nx * ny * nz * components * sizeof(Value));
        const auto put = [&](std::size_t cell, std::size_t component, Value value) {
            std::memcpy(bytes.data() + (cell * components + component) * sizeof value, &value, sizeof value);
        };
        for (std::size_t cell = 0; cell < nx * ny * nz; ++cell)
            for (std::size_t n = 0; n < components; ++n) put(cell, n, uncut(cell, n));
        for (const CellFraction& row : found.cells) {
            std::array<std::size_t, 3> at{};
            for (std::size_t d = 0; d < 3; ++d) at[d] = static_cast<std::size_t>(row.cell[d] - found.grid.first[d]);
            for (std::size_t n = 0; n < components; ++n) put((at[2] * ny + at[1]) * nx + at[0], n, cut(row, n));
        }
        return bytes;
    };
    return {name, type, components, sizeof(Value), make};
}

void write_vti(const Fractions& found, const std::string& path) {
    const auto counts = found.counts();
    for (const std::size_t count : counts)
        if (count > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
            refuse_unsupported(
                "{}: VTK counts the cells of an axis in 32 bits, and {} are too many; choose .npz "
                "or .h5",
                path, count);
    const auto middle = [&](std::size_t cell, std::size_t n) {
        if (!found.options.centroids_as_points) return 0.0;
        const Vec3 low = found.grid.position(static_cast<std::int64_t>(cell % counts[0]),
                                             static_cast<std::int64_t>(cell / counts[0] % counts[1]),
                                             static_cast<std::int64_t>(cell / counts[0] / counts[1]));
        return low[n] + 0.5 * found.grid.spacing[n];
    };
    const auto nothing = [](std::size_t, std::size_t) { return 0.0; };
    using Cell = CellFraction;
    const std::array arrays{
        cell_array<double>(
            found, "volume", "Float64", 1, [&](std::size_t cell, std::size_t) { return found.is_full(cell); },
            [](const Cell& cell, std::size_t) { return cell.volume; }),
        cell_array<std::uint8_t>(
            found, "type", "UInt8", 1,
            [&](std::size_t cell, std::size_t) { return static_cast<std::uint8_t>(found.is_full(cell)); },
            [](const Cell&, std::size_t) { return static_cast<std::uint8_t>(CellType::cut); }),
        cell_array<std::uint32_t>(
            found, "pieces", "UInt32", 1, [](std::size_t, std::size_t) { return 0U; },
            [](const Cell& cell, std::size_t) { return cell.pieces; }),
        cell_array<double>(found, "area", "Float64", 1, nothing,
                           [](const Cell& cell, std::size_t) { return cell.area; }),
        cell_array<double>(found, "vector_area", "Float64", 3, nothing,
                           [](const Cell& cell, std::size_t n) { return cell.vector_area[n]; }),
        cell_array<double>(found, "centroid", "Float64", 3, middle,
                           [](const Cell& cell, std::size_t n) { return cell.centroid[n]; }),
        cell_array<double>(
            found, "surface_centroid", "Float64", 3,
            [&](std::size_t, std::size_t) { return found.options.no_surface_centroid; },
            [](const Cell& cell, std::size_t n) { return cell.surface_centroid[n]; })};
    const std::string extent = fmt::format("0 {} 0 {} 0 {}", counts[0], counts[1], counts[2]);
    const Vec3 origin = found.grid.position(0, 0, 0), &spacing = found.grid.spacing;
    std::string text = fmt::format(
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
        "  <ImageData WholeExtent=\"{0}\" Origin=\"{1} {2} {3}\" Spacing=\"{4} {5} {6}\">\n"
        "    <Piece Extent=\"{0}\">\n      <CellData Scalars=\"volume\">\n",
        extent, origin[0], origin[1], origin[2], spacing[0], spacing[1], spacing[2]);
    const std::uint64_t cells = counts[0] * counts[1] * counts[2];
    std::uint64_t offset = 0;
    for (const CellArray& array : arrays) {
        text += fmt::format(
            "        <DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" "
            "offset=\"{}\"/>\n",
            array.type, array.name, array.components, offset);
        offset += sizeof offset + cells * array.components * array.width;
    }
    text += "      </CellData>\n    </Piece>\n  </ImageData>\n  <AppendedData encoding=\"raw\">\n_";
    AtomicFile file(path);
    file.write(text);
    for (const CellArray& array : arrays) {
        const std::vector<std::byte> bytes = array.make();
        const std::uint64_t size = bytes.size();
        write_little_endian(file, std::as_bytes(std::span(&size, 1)), sizeof size);
        write_little_endian(file, bytes, array.width);
    }
    file.write(std::string("\n  </AppendedData>\n</VTKFile>\n"));
    file.commit();
}

}  // namespace

void check_fractions_path(const std::string& path) {
    if (const std::string ending = ending_of(path); ending != ".npz" && ending != ".h5" && ending != ".vti")
        refuse_unsupported("'{}': fractions of cells are written as .npz, .h5 or .vti; choose one of them", path);
}

void write_fractions(const Fractions& found, const std::string& path) {
    check_fractions_path(path);
    if (ending_of(path) == ".vti")
        write_vti(found, path);
    else
        write_rows(found, path);
}

}  // namespace clsdf
