#pragma once

#include "frusta/frusta.hpp"
#include "topology/device_topology.hpp"
#include "topology/topology.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace clsdf::engine {

/// The faces of a mesh that exact decisions depend on, as a mesh of their own: those that the host measures and all at
/// their edges, and those around vertices with a gap. So the host needs neither topology nor positions of the whole.
struct HostPart {
    MeshTopology topology;             ///< `order` and `faces.vertices` have the caller's numbers
    std::vector<std::uint32_t> faces;  ///< ascending: of each its number in the whole mesh
    std::vector<std::uint32_t> vertices;
    LeftToHost left;  ///< by the part's numbers
    Frusta frusta;    ///< of the faces, slopes of left.faces alone; its vertices and point sites
};

/// Answers of kernels about the faces and the vertices of a mesh, CLSDF_FACE_... and CLSDF_VERTEX_..., and its
/// positions.
struct DeviceAnswers {
    const cl::Buffer& of_faces;
    const cl::Buffer& of_vertices;
    const cl::Buffer& positions;
};

/// Finds what the kernels leave to the host. Waits twice. Nothing if that is a large share of the mesh. Throws Error.
std::optional<HostPart> host_part(const DeviceSetUp& set_up, const DeviceTopology& topology,
                                  const DeviceAnswers& answers);

}  // namespace clsdf::engine
