#pragma once

#include <clsdf/arrays.hpp>
#include <clsdf/fractions.hpp>
#include <clsdf/segments.hpp>

#include <array>
#include <cstddef>
#include <initializer_list>
#include <vector>

/// The columns of rows: one table for the caller's arrays on the host and the device, plans, and files. A new column of
/// a link or of a cut cell is a member of Links or CellFraction, one of LinkTargets or FractionRows, and a row here.
namespace clsdf {

/// Types that an array may have: up to three; the first is that of an array without a type, and that of the values.
struct ElementTypes {
    std::array<ElementType, 3> types{};
    std::size_t count = 0;

    // NOLINTNEXTLINE(google-explicit-constructor): a list of types
    constexpr ElementTypes(std::initializer_list<ElementType> given) {
        for (const ElementType type : given) types[count++] = type;
    }
    constexpr const ElementType* begin() const { return types.data(); }
    constexpr const ElementType* end() const { return types.data() + count; }
};

/// The values of a column: the numbers of a row lie side by side.
struct ColumnValues {
    const std::byte* first = nullptr;
    std::size_t stride = 0;  ///< bytes from a row to the next one
    std::size_t count = 0;   ///< rows
};

/// A column of rows. Targets: the caller's arrays.
template <typename RowsOf, typename TargetsOf>
struct RowColumn {
    using Rows = RowsOf;
    using Targets = TargetsOf;

    const char* name;    ///< in files: "q"
    const char* phrase;  ///< in messages: "the array of q"
    OutputArray Targets::*target;
    ElementTypes types;
    std::array<std::size_t, 2> shape;  ///< of a row: {} one number, {3} three, {6, 2} two in each of six
    ColumnValues (*values)(const Rows&);
    const char* item = nullptr;           ///< in files whose rows are structures: "sample"; null: there is no such file
    float (*as_float)(double) = nullptr;  ///< how doubles are rounded for an array of floats; null: to the nearest

    constexpr std::size_t components() const { return (shape[0] == 0 ? 1 : shape[0]) * (shape[1] == 0 ? 1 : shape[1]); }
};

namespace detail {

/// Of a member of Links, a vector.
template <auto member>
ColumnValues values_of_vector(const Links& links) {
    const auto& vector = links.*member;
    return {reinterpret_cast<const std::byte*>(vector.data()), sizeof vector[0], vector.size()};
}

/// Of a member of CellFraction.
template <auto member>
ColumnValues values_of_cells(const std::vector<CellFraction>& cells) {
    if (cells.empty()) return {};
    return {reinterpret_cast<const std::byte*>(&(cells.front().*member)), sizeof(CellFraction), cells.size()};
}

}  // namespace detail

using LinkColumn = RowColumn<Links, LinkTargets>;

inline constexpr std::array link_columns{
    LinkColumn{"samples",
               "the array of samples",
               &LinkTargets::samples,
               {ElementType::int32},
               {3},
               detail::values_of_vector<&Links::samples>,
               "sample"},
    LinkColumn{"directions",
               "the array of directions",
               &LinkTargets::directions,
               {ElementType::uint8},
               {},
               detail::values_of_vector<&Links::directions>,
               "direction"},
    LinkColumn{"q",
               "the array of q",
               &LinkTargets::q,
               {ElementType::float64, ElementType::float32},
               {},
               detail::values_of_vector<&Links::q>,
               "q",
               as_float_part},
    LinkColumn{"triangles",
               "the array of triangles",
               &LinkTargets::triangles,
               {ElementType::uint32, ElementType::int32},
               {},
               detail::values_of_vector<&Links::triangles>,
               "triangle"},
    LinkColumn{"counts",
               "the array of counts",
               &LinkTargets::counts,
               {ElementType::uint32, ElementType::int32},
               {},
               detail::values_of_vector<&Links::counts>,
               "count"},
    LinkColumn{"flags",
               "the array of flags",
               &LinkTargets::flags,
               {ElementType::uint8},
               {},
               detail::values_of_vector<&Links::flags>,
               "flags"},
};

using CellColumn = RowColumn<std::vector<CellFraction>, FractionRows>;

inline constexpr ElementTypes real_types{ElementType::float64, ElementType::float32};

inline constexpr std::array cell_columns{
    CellColumn{"cells",
               "the array of cells",
               &FractionRows::cells,
               {ElementType::int32},
               {3},
               detail::values_of_cells<&CellFraction::cell>},
    CellColumn{"pieces",
               "the array of pieces",
               &FractionRows::pieces,
               {ElementType::uint32, ElementType::int32},
               {},
               detail::values_of_cells<&CellFraction::pieces>},
    CellColumn{"volume",
               "the array of volumes",
               &FractionRows::volume,
               real_types,
               {},
               detail::values_of_cells<&CellFraction::volume>},
    CellColumn{"centroid",
               "the array of centroids",
               &FractionRows::centroid,
               real_types,
               {3},
               detail::values_of_cells<&CellFraction::centroid>},
    CellColumn{"area",
               "the array of areas",
               &FractionRows::area,
               real_types,
               {},
               detail::values_of_cells<&CellFraction::area>},
    CellColumn{"vector_area",
               "the array of vector areas",
               &FractionRows::vector_area,
               real_types,
               {3},
               detail::values_of_cells<&CellFraction::vector_area>},
    CellColumn{"surface_centroid",
               "the array of the surface's centroids",
               &FractionRows::surface_centroid,
               real_types,
               {3},
               detail::values_of_cells<&CellFraction::surface_centroid>},
    CellColumn{"face_fractions",
               "the array of fractions of faces",
               &FractionRows::face_fractions,
               real_types,
               {6},
               detail::values_of_cells<&CellFraction::face_fractions>},
    CellColumn{"face_centroids",
               "the array of centroids of faces",
               &FractionRows::face_centroids,
               real_types,
               {6, 2},
               detail::values_of_cells<&CellFraction::face_centroids>},
};

}  // namespace clsdf
