#pragma once

#include <clsdf/mesh.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace clsdf::bench {

/// The meshes of every benchmark: meshes of CGAL's data, the paper's sphere, and a noisy sphere.
const std::vector<std::string>& standard_meshes();

/// Every name that load_mesh() accepts: these, then the other ones of make_shape().
std::vector<std::string> mesh_names();

/// A mesh by one of those names or by its file. Meshes of CGAL's data are read from `folder`; if one is missing,
/// Error(unreadable_input) says how to get it. `seed` is that of the noisy sphere.
Mesh load_mesh(const std::string& name_or_file, const std::string& folder, std::uint64_t seed);

/// "bunny00" for "meshes/bunny00.off".
std::string short_name(const std::string& name_or_file);

/// A unit sphere of 20 frequency^2 triangles, an icosahedron's faces divided evenly; each vertex is moved along its
/// radius by up to `noise` mean edge lengths, inwards or outwards. It never cuts itself.
Mesh noisy_sphere(std::uint32_t frequency, double noise, std::uint64_t seed);

/// In the mesh's units, squared.
double triangle_area(const Mesh& mesh, std::size_t triangle);
double mean_triangle_area(const Mesh& mesh);

/// Splits each triangle into four at the midpoints of its edges: the same surface.
Mesh split_triangles(const Mesh& mesh);

}  // namespace clsdf::bench
