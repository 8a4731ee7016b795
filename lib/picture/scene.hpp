#pragma once

#include "picture/camera.hpp"
#include "picture/surface_shading.hpp"
#include "picture/traced_samples.hpp"
#include "picture/tracer.hpp"

#include <optional>
#include <vector>

namespace clsdf::picture {

/// A surface of a field, and the view of it. Points and lengths are in the mesh's units, from the field's first sample.
class Scene {
public:
    /// As SurfacePictures.
    Scene(const Field& field, const Device& device, std::optional<double> offset);

    const Field& field() const { return field_; }
    const TracedSamples& samples() const { return samples_; }
    const Tracer& tracer() const { return tracer_; }
    double offset() const { return offset_; }
    const Vec3& origin() const { return origin_; }
    Axis upright() const { return upright_; }

    /// Throws Error(invalid_argument) if an option makes no sense.
    Camera camera(const SurfaceOptions& options) const;
    /// Colours, and iso-lines at round distances with a minimum gap.
    Manner manner(const Camera& camera) const;
    SurfaceShading shading(const SurfaceOptions& options, const Camera& camera, const Manner& manner) const;
    /// `rays` in each direction of a pixel.
    RenderView view(const SurfaceOptions& options, const Camera& camera, const SurfaceShading& shading, int rays) const;

    double position_of(const Cut& cut) const;
    Vec3 position_of(const RenderHit& hit) const;

private:
    void find_solid();
    bool has_room_for_gradients() const;

    const Field& field_;
    TracedSamples samples_;
    double offset_;
    Tracer tracer_;
    Vec3 origin_;               // of the field's first sample, in the mesh's space
    std::vector<Vec3> points_;  // points that must be in the picture
    Box solid_;                 // their box
    Axis upright_ = Axis::z;
};

}  // namespace clsdf::picture
