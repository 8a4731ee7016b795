#pragma once

#include "picture/camera.hpp"
#include "picture/panel.hpp"
#include "picture/tracer.hpp"

#include "render.h"

#include <clsdf/picture.hpp>

#include <optional>
#include <vector>

namespace clsdf::picture {

/// Red, green and blue in proportion to the light, and how much of the pixel is covered.
struct Light {
    std::array<double, 3> parts{};
    double cover = 0;
};

/// Computes the light that comes back along a ray from its hit. The surface has one colour, a key light from the upper
/// left, a weaker one from the right, and light from all around; the inside of an opened solid has the colours of
/// slices, unlit, with iso-lines.
class SurfaceShading {
public:
    SurfaceShading(const ViewFrame& frame, const Manner& manner, const Colour& surface, double offset, double voxel);

    /// Draws a line at the intersection of cuts; positions are in samples from the field's first one.
    void mark_cut(Axis axis, double position, double spacing);

    /// Unit vector to the key light, in the mesh's space.
    const Vec3& key() const { return key_; }
    /// Tangent of half the angle that the light subtends.
    static constexpr float key_spread = 0.18F;

    /// `pixel`: the side of a pixel there, in the mesh's units.
    Light operator()(const RenderHit& hit, double pixel) const;

private:
    std::array<double, 3> lit(const RenderHit& hit) const;
    std::array<double, 3> opened(const RenderHit& hit, double pixel) const;

    ViewFrame frame_;
    const Manner& manner_;
    std::array<double, 3> surface_;
    double offset_;
    double voxel_;
    struct Marked {
        int axis;
        double position;
        double spacing;
    };
    std::vector<Marked> cuts_;
    Vec3 key_;
    Vec3 fill_;
    Vec3 half_way_;  // between the key light and the viewer
};

/// The pixel 0xAARRGGBB, colours multiplied by the alpha, as cairo wants them.
std::uint32_t pixel_of(const Light& light, bool transparent);

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
