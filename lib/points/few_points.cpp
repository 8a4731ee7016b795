#include "points/few_points.hpp"

#include "core/floating_point.hpp"
#include "core/parallel.hpp"
#include "core/stopwatch.hpp"
#include "points/one_lane.hpp"
#include "points/signs_by_host.hpp"

#include <algorithm>
#include <array>
#include <numeric>

// Inlines all that a function calls, for CLSDF_SEVERAL_TARGETS.
#ifdef __GNUC__
#define CLSDF_FLATTEN __attribute__((flatten))
#else
#define CLSDF_FLATTEN
#endif

namespace clsdf::points {

namespace {

template <typename Value>
const Value* values_of(const device::BufferPool::Lease& lease) {
    return static_cast<const Value*>(lease.on_host());
}
template <typename Value>
const Value* values_of(const std::shared_ptr<const device::BufferPool::Lease>& lease) {
    return lease ? values_of<Value>(*lease) : nullptr;
}

one_lane::PointMesh sources_of(const PointInputs& inputs) {
    const engine::WideTree& tree = *inputs.leaves->tree;
    return {tree.nodes.data() + tree.shape.count[0], inputs.leaves->on_host(),
            values_of<Polyhedron>(inputs.mesh->polyhedra), values_of<PointFace>(inputs.mesh->faces)};
}

/// As the kernel nearest_of_points does.
CLSDF_SEVERAL_TARGETS CLSDF_FLATTEN void find_nearest(const PointInputs& inputs,
                                                      std::span<const one_lane::double3> points, double most,
                                                      std::uint32_t& near, std::uint32_t* faces, double* squared) {
    const one_lane::PointMesh sources = sources_of(inputs);
    const PointTree& tree = inputs.leaves->tree->shape;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const one_lane::NearestFace found = one_lane::nearest_face(tree, sources, points[i], most, near);
        faces[i] = one_lane::lowest_face(sources.faces, found.face);
        squared[i] = found.squared;
        if (found.face != CLSDF_NO_FACE) near = found.face;
    }
}

/// From the caller's sources into packed arrays.
one_lane::Finishing finishing_of(const FinishingSources& sources, const targets::HostArrays& arrays) {
    std::uint32_t wanted = 0, in_double = 0;
    for_each_output(
        [&](const OutputInfo& row, const targets::HostArray& array) {
            if (row.output != Output::distance && array.is_wanted) wanted |= bit_of(row);
            if (array.in_double) in_double |= bit_of(row);
        },
        arrays);
    const auto bytes_of = [&](Output output) { return reinterpret_cast<std::uint8_t*>(arrays[output].data); };
    one_lane::Finishing finishing{};
    finishing.how = sources.how.finish(wanted, in_double);
    finishing.polyhedra = sources.polyhedra;
    finishing.sites = sources.sites;
    finishing.normals = sources.normals;
    finishing.of_distance = reinterpret_cast<double*>(arrays[Output::distance].data);
#define SET_OUTPUT(name, content, element, components, number) finishing.of_##name = bytes_of(Output::name);
    CLSDF_OUTPUTS(SET_OUTPUT)
#undef SET_OUTPUT
    return finishing;
}

}  // namespace

void bring_to_host(const PointInputs& inputs) {
    sources_of(inputs);
    values_of<TriangleSites>(inputs.sites->names);
    values_of<float>(inputs.sites->normals);
}

PointTimes answer_points(const PointInputs& inputs, std::span<const Vec3> points, double half_width,
                         const targets::HostArrays& arrays) {
    const DefaultFloatingPoint as_kernels;
    const Stopwatch watch;
    const engine::PointMesh& mesh = *inputs.on_host;
    std::array<one_lane::double3, most_few_points> in_units;
    std::array<std::uint32_t, most_few_points> faces, order;
    std::array<double, most_few_points> squared;
    std::array<std::uint8_t, most_few_points> signs;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto& [x, y, z] = mesh.in_units(points[i]);
        in_units[i] = {x, y, z};
    }
    std::uint32_t near = CLSDF_NO_FACE;
    find_nearest(inputs, std::span(in_units).first(points.size()), search_limit(mesh, half_width), near, faces.data(),
                 squared.data());
    std::iota(order.begin(), order.begin() + points.size(), 0U);
    std::fill_n(signs.begin(), points.size(), std::uint8_t{CLSDF_POINT_UNDECIDED});
    const Stopwatch sign_watch;
    find_signs({mesh, *inputs.leaves->tree}, inputs.sign,
               {points, std::span(order).first(points.size()), std::span(squared).first(points.size())}, signs);
    const double sign_seconds = sign_watch.seconds();
    const one_lane::Finishing finishing = finishing_of(finishing_sources(inputs), arrays);
    auto* const distance = reinterpret_cast<float*>(arrays[Output::distance].data);
    for (std::size_t i = 0; i < points.size(); ++i)
        one_lane::finish_point(&finishing, distance, in_units[i], faces[i], signs[i], nullptr, half_width, i);
    return {watch.seconds() - sign_seconds, sign_seconds};
}

FinishingSources finishing_sources(const PointInputs& inputs) {
    const engine::PointFaces& mesh = *inputs.mesh;
    return {engine::Finishing(mesh.lattice, inputs.sites, inputs.is_inside_out), values_of<Polyhedron>(mesh.polyhedra),
            values_of<TriangleSites>(inputs.sites->names), values_of<float>(inputs.sites->normals)};
}

void finish_on_host(const FinishingSources& sources, const Vec3& sample, std::uint32_t polyhedron, std::uint8_t sign,
                    double half_width, const targets::HostArrays& arrays) {
    const one_lane::Finishing finishing = finishing_of(sources, arrays);
    one_lane::finish_point(&finishing, reinterpret_cast<float*>(arrays[Output::distance].data),
                           {sample[0], sample[1], sample[2]}, polyhedron, sign, nullptr, half_width, 0);
}

NearestOfPoint find_nearest(const PointInputs& inputs, const Vec3& in_units, double most, std::uint32_t& near) {
    const one_lane::double3 point{in_units[0], in_units[1], in_units[2]};
    NearestOfPoint found{};
    find_nearest(inputs, std::span(&point, 1), most, near, &found.face, &found.squared);
    return found;
}

}  // namespace clsdf::points
