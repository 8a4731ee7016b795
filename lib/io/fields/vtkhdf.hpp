#pragma once

/// The names of a VTKHDF file (VTK's documentation, "VTK file formats", VTKHDF, version 1.0): ImageData, which VTK 9.1
/// and later read.
namespace clsdf::vtkhdf {

inline constexpr const char* root = "VTKHDF";
inline constexpr const char* point_data = "VTKHDF/PointData";
inline constexpr const char* cell_data = "VTKHDF/CellData";
inline constexpr const char* field_data = "VTKHDF/FieldData";

}  // namespace clsdf::vtkhdf
