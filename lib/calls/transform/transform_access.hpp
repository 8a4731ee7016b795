#pragma once

#include <clsdf/distance_transform.hpp>
#include <clsdf/export.hpp>

#include <memory>

namespace clsdf {

class FieldMethod;

/// The way into DistanceTransform for libraries beside the core. Exported: the transform is one of the core library.
struct CLSDF_EXPORT detail::TransformAccess {
    /// A transform with another method than leaned frusta by bricks.
    static DistanceTransform make(Device device, const Mesh& mesh, std::shared_ptr<const FieldMethod> method,
                                  const TransformOptions& options, const CallOptions& call);
    // For scenes.
    static DistanceTransform::State& state(const DistanceTransform& transform) { return transform.state(); }
    static DistanceTransform of(std::unique_ptr<DistanceTransform::State> state);
};

}  // namespace clsdf
