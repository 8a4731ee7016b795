#pragma once

#include "face_sources.h"
#include "frusta/frames.hpp"
#include "frusta/frusta.hpp"
#include "polyhedron.h"

#include <cstddef>
#include <cstdint>
#include <span>

/// The polyhedra as the device reads them, in a lattice's units.
namespace clsdf::engine {

/// Kernels process up to this many consecutive records together, from multiples of their number on. The result of a
/// group must not depend on other records, so records are selected in whole groups.
inline constexpr std::size_t record_group = CLSDF_RECORD_GROUP;

/// So many records, and those that fill the last group: of faces, the last one again.
constexpr std::size_t in_record_groups(std::size_t count) {
    return (count + record_group - 1) / record_group * record_group;
}

/// The record of a polyhedron. corners: the face's vertices.
Polyhedron pack(const TriangleFrame& frame, const FaceSlopes& slopes, std::uint32_t triangle,
                std::span<const Vec3> positions, const Triangle& corners, const LatticeView& lattice);

/// The record of a face.
void write_face_record(const MeshTopology& topology, const Frusta& frusta, const LatticeView& lattice, std::size_t face,
                       Polyhedron& record);

/// The records of point sites that follow each other, from `first` on.
void write_site_records(const MeshTopology& topology, const Frusta& frusta, const LatticeView& lattice,
                        std::size_t first, std::span<Polyhedron> records);

}  // namespace clsdf::engine
