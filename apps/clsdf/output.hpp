#pragma once

#include <clsdf/clsdf.hpp>

#include <nlohmann/json.hpp>

#include <string>

/// Prints a result on standard output. Throws clsdf::Error(output_failure).
void print_result(const nlohmann::ordered_json& result);
void print_result(const std::string& text);

nlohmann::ordered_json describe(const clsdf::Grid& grid);
/// A half width is null if it is infinite.
nlohmann::ordered_json describe(const clsdf::Band& band);

/// "51.5 MB".
std::string human_bytes(double bytes);
/// "12.9 million".
std::string human_count(double count);
/// One line: samples, spacing and origin.
std::string human(const clsdf::Grid& grid);
/// One line: half widths in the mesh's units and in voxels.
std::string human(const clsdf::Band& band, double voxel);
