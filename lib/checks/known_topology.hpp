#pragma once

#include <clsdf/mesh.hpp>

#include "topology/device_topology.hpp"

#include <optional>
#include <string>

namespace clsdf::checks {

/// A small mesh with all that kernels look for in a topology: vertices of equal coordinates, in use and not, edges of
/// one, two and three faces and of both orientations, faces with a repeated vertex, several parts, and more vertices,
/// faces and corners than a work-group takes.
Mesh mesh_of_known_topology();

/// Makes the topology of a mesh by kernels, from arrays of the host and of the device, and by the host; and the boxes
/// of its clusters. Describes, in a sentence, what differs; nothing if all bytes are the same. Throws Error.
std::optional<std::string> topology_difference(const engine::DeviceSetUp& set_up, const Mesh& mesh);

/// The same of the vertices that the sign's sweep has for some clusters of that small mesh.
std::optional<std::string> sweep_difference(const engine::DeviceSetUp& set_up);

}  // namespace clsdf::checks
