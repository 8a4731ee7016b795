#pragma once

#include <clsdf/mesh.hpp>

#include <string>
#include <vector>

/// What a program found at points, a row for each of them, from .npy or .csv. A .csv file has the columns that
/// write_points() writes. Both throw as read_points().
namespace clsdf {

/// A number for each point: of the column NAME, or of an .npy file of shape (n,) or (n, 1) and any type of number, or
/// of structures that have the member NAME, as write_points() writes them.
std::vector<double> read_point_numbers(const std::string& path, const char* name);

/// A vector for each point: of the columns NAME_x, NAME_y and NAME_z, or of an .npy file of shape (n, 3) of floats or
/// doubles, or of structures that have the member NAME of three numbers.
std::vector<Vec3> read_point_vectors(const std::string& path, const char* name);

}  // namespace clsdf
