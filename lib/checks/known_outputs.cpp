#include "checks/known_outputs.hpp"

#include "core/floating_point.hpp"
#include "finish/sites.hpp"
#include "frusta/records.hpp"
#include "lattice/layout_of.hpp"
#include "points/few_points.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

namespace clsdf::checks {

namespace {

using targets::HostArray;
using targets::HostArrays;

// For a number, relative to its size or to 1: floats are rounded, and compilers may fuse multiply-adds.
constexpr double float_tolerance = 1e-6, double_tolerance = 1e-9;

#define CLSDF_COMPONENTS(name, description, element, components, number) +components
constexpr std::size_t all_components = 1 CLSDF_OUTPUTS(CLSDF_COMPONENTS);
#undef CLSDF_COMPONENTS

template <typename Value>
double value_at(const HostArray& array, std::size_t index) {
    Value value{};
    std::memcpy(&value, array.data + index * sizeof(Value), sizeof(Value));
    return static_cast<double>(value);
}

/// Whether every bit of the sample is set.
bool is_left(const OutputInfo& info, const HostArray& array, std::size_t sample) {
    const std::size_t bytes = sample_bytes(info, array.in_double);
    return std::ranges::all_of(std::span(array.data + sample * bytes, bytes),
                               [](std::byte byte) { return byte == std::byte{0xFF}; });
}

/// One vertex, two of an edge, or all three.
bool has_site(const Triangle& face, const Triangle& triangle, std::size_t site) {
    const auto has = [&](std::uint32_t vertex) { return std::ranges::find(face, vertex) != face.end(); };
    if (site < 3) return has(triangle[site]);
    if (site < CLSDF_SITE_OF_FACE) return has(triangle[site - 3]) && has(triangle[(site - 2) % 3]);
    return std::ranges::all_of(triangle, has);
}

}  // namespace

double number_at(const HostArrays& arrays, Output output, std::size_t index) {
    const OutputInfo& info = info_of(output);
    const HostArray& array = arrays[output];
    if (is_real(info)) return array.in_double ? value_at<double>(array, index) : value_at<float>(array, index);
    return bytes_of(info.type) == 1 ? value_at<std::uint8_t>(array, index) : value_at<std::uint32_t>(array, index);
}

KnownOutputs::KnownOutputs(const Mesh& mesh, const Grid& grid)
    : how_(grid, Band::full(), engine::layout_of(grid, Band::full(), SignRule::nonzero),
           std::make_shared<engine::DeviceSites>(), false),
      triangles_(mesh.triangles()),
      polyhedra_(triangles_.size()),
      sites_(triangles_.size()),
      normals_(18 * triangles_.size()) {
    const engine::LatticeView lattice = engine::lattice_of(grid);
    const engine::MeshFaces faces{mesh.vertices(), triangles_, lattice};
    for (std::uint32_t face = 0; face < triangles_.size(); ++face)
        polyhedra_[face] = engine::pack(faces.frame(face), {}, face, mesh.vertices(), triangles_[face], lattice);
    const engine::MeshTopology topology(mesh);
    engine::name_sites(topology, sites_);
    engine::make_pseudonormals(topology, mesh.vertices(), normals_);
}

std::string KnownOutputs::difference_from(std::uint32_t face, const HostArrays& found, const KnownSample& sample,
                                          double error) const {
    std::array<double, all_components> room{};
    std::size_t used = 0;
    HostArrays expected = found;
    for_each_output(
        [&](const OutputInfo& info, HostArray& array) {
            array.in_double |= info.output == Output::distance;
            array.data = reinterpret_cast<std::byte*>(room.data() + used);
            used += info.components;
        },
        expected);
    const DefaultFloatingPoint as_kernels;
    points::finish_on_host({how_, polyhedra_.data(), sites_.data(), normals_.data()}, sample.index, face,
                           sample.distance < 0 ? CLSDF_POINT_INSIDE : CLSDF_POINT_OUTSIDE,
                           std::numeric_limits<double>::infinity(), expected);

    double& distance = room[0];
    if (!(std::abs(distance - sample.distance) <= error))
        return fmt::format("has a site of triangle {} that is {:.7g} away", face, distance);
    distance = std::clamp(distance, -sample.most, sample.most);
    for (const OutputInfo& info : output_table()) {
        const bool in_double = found[info.output].in_double;
        if (info.output == Output::distance && !in_double) continue;  // the polyhedra's
        for (std::size_t c = 0; c < info.components; ++c) {
            const double value = number_at(found, info.output, info.components * sample.at + c),
                         right = number_at(expected, info.output, c);
            // A comparison that a NaN fails, too.
            if (!(std::abs(value - right) <=
                  (in_double ? double_tolerance : float_tolerance) * std::max(1.0, std::abs(right))))
                return fmt::format("has {:.17g} instead of {:.17g} in the {}", value, right, info.name);
        }
    }
    return {};
}

std::string KnownOutputs::difference(const HostArrays& found, const KnownSample& sample, double error) const {
    const auto triangle = static_cast<std::uint32_t>(number_at(found, Output::triangle, sample.at));
    if (triangle == no_triangle) {
        for (const OutputInfo& info : extra_outputs())
            if (!is_left(info, found[info.output], sample.at)) return "has outputs, but no triangle";
        const double distance = number_at(found, Output::distance, sample.at);
        if (found[Output::distance].in_double && std::abs(distance) != sample.most)
            return fmt::format("has the distance {:.17g} beyond the band", distance);
        return {};
    }
    const auto site = static_cast<std::size_t>(number_at(found, Output::site, sample.at));
    std::string difference;
    for (std::uint32_t face = 0; face < triangles_.size(); ++face) {
        if (!has_site(triangles_[face], triangles_[triangle], site)) continue;
        difference = difference_from(face, found, sample, error);
        if (difference.empty()) break;
    }
    return difference;
}

}  // namespace clsdf::checks
