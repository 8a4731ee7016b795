#pragma once

/// Pictures of a field, in a separate target, clsdf::picture: they are drawn with cairo, which the core library does
/// not need.
#include <clsdf/device.hpp>
#include <clsdf/export.hpp>
#include <clsdf/field.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace clsdf::picture {

/// The axis that a slice is perpendicular to.
enum class Axis : std::int32_t { x = 0, y = 1, z = 2 };

/// "x", "y", "z". parse_axis() throws Error(invalid_argument) for anything else.
CLSDF_EXPORT const char* name_of(Axis axis);
CLSDF_EXPORT Axis parse_axis(const std::string& text);

/// The samples of a field with the same index along one axis; the index counts from the field's first sample.
struct Slice {
    Axis axis = Axis::z;
    std::int64_t index = 0;
};

struct Options {
    /// Pixels on the longer side of the slice, 100 ... 10000; text and lines scale with it. The panels of a mosaic
    /// share it. 1200 pixels fill the width of a printed page.
    int pixels = 1200;
};

/// Draws slices of one field: colours by sign and distance, iso-lines at round values, a strong line where the distance
/// is zero, axes in the mesh's units, and a colour bar. A distance has the same colour in every slice of the field, and
/// all slices along an axis have the same iso-lines. Samples beyond the band have a flat, paler tone by their sign. A
/// field without a sign has colours on one side only and no zero line.
class CLSDF_EXPORT SlicePictures {
public:
    /// Keeps a reference to the field. Throws Error(invalid_argument) if the distances do not fit the grid or are
    /// positive inside (see Field::negate()), or the number of pixels is out of range.
    explicit SlicePictures(const Field& field, const Options& options = {});

    /// The slice through the middle of the grid.
    Slice middle(Axis axis) const;

    /// Writes a .png, or a .pdf whose lines and text are drawn at the printer's own resolution. The file appears
    /// complete or not at all. Throws Error(output_failure), Error(unsupported) for another ending, or
    /// Error(invalid_argument) if the field has no such slice, or one without extent.
    void write_slice(const Slice& slice, const std::string& path) const;

    /// The three slices through sample `at`, side by side on one scale with their axes aligned. Throws what
    /// write_slice() does.
    void write_mosaic(const Index3& at, const std::string& path) const;

    /// Throws the error that a write would throw for the path's ending or folder, before any work is done. Leaves no
    /// file.
    static void check_path(const std::string& path);

private:
    const Field& field_;
    Options options_;
    double lower_ = 0;  // the least and the greatest distance in the field, with 0 between them
    double upper_ = 0;
    bool has_sign_ = false;
};

/// The position of the viewer.
struct View {
    double azimuth = 30;    ///< degrees to the right of the front
    double elevation = 20;  ///< degrees above the horizon, -90 ... 90
    /// The axis that points upwards; none: SurfacePictures::upright(). Seen from the front, x points to the right, or y
    /// if x is up.
    std::optional<Axis> up{};
    bool up_is_negative = false;
    /// Degrees between the directions to the opposite borders of the picture, below 120; 0: a parallel projection.
    double perspective = 0;
};

/// set_direction() takes "front", "back", "left", "right", "side" (right), "top", "bottom", "iso" or
/// "AZIMUTH,ELEVATION" in degrees; set_up() takes "x", "-x", "y", "-y", "z", "-z" or "auto". Both change `view`, and
/// throw Error(invalid_argument) for any other text.
CLSDF_EXPORT void set_direction(View& view, const std::string& text);
CLSDF_EXPORT void set_up(View& view, const std::string& text);

/// Removes the part on the viewer's side of a plane across an axis; with several cuts, the part on that side of all
/// planes.
struct Cut {
    Axis axis = Axis::x;
    std::optional<double> position;  ///< in the mesh's units; none: through the middle of the solid
};

struct SurfaceOptions {
    View view;
    std::vector<Cut> cuts;  ///< at most one across each axis
    /// Pixels, 16 ... 10000 each. A height of 0: the width is the longer side, the other one follows from the view.
    int width = 1200;
    int height = 0;
    int rays = 3;  ///< in each direction of a pixel, 1 ... 8
    /// The surface's red, green and blue, 0 ... 1, sRGB.
    std::array<double, 3> colour{0.80, 0.77, 0.72};
    bool transparent = false;  ///< the background, else white
    bool bare = false;         ///< no title and colour bar beside cuts
    /// Both are called between launches, on the calling thread. If the second one says true, Error(cancelled) is
    /// thrown.
    std::function<void(double fraction)> progress{};
    std::function<bool()> should_stop{};
};

/// The first point that the ray through a pixel's centre meets.
struct Hit {
    enum class Kind : std::int32_t { nothing = 0, surface = 1, cut = 2, border = 3 };
    Kind kind = Kind::nothing;
    Vec3 position{};      ///< in the mesh's units
    Vec3 gradient{};      ///< of the distance there: about a unit vector, outwards
    double distance = 0;  ///< there: the level at the surface, less in a cut or at the end of the grid
};

/// Rows of pixels from the top.
struct Hits {
    int width = 0;
    int height = 0;
    std::vector<Hit> pixels;
};

class Scene;

/// Pictures of the surface on which the distance has one value, found by sphere tracing on the device. The surface is a
/// level set of the samples' trilinear interpolant, for every spacing and band. The slopes between samples bound the
/// steps of a ray, so no surface is passed over. The faces of a cut, and of a solid that reaches the end of the grid,
/// show the distances in the colours of SlicePictures, with iso-lines. Once moved from, every member but assignment and
/// the destructor throws Error(invalid_argument).
class CLSDF_EXPORT SurfacePictures {
public:
    /// Keeps a reference to the field, and copies its samples to the device. `offset`: the surface's distance in the
    /// mesh's units. The default is 0. For a field without a sign it is one voxel (the largest spacing), because such a
    /// distance touches zero without crossing it. Throws Error(invalid_argument) if the distances do not fit the grid
    /// or are not numbers, a side has a single sample, the band ends before the offset, or no surface is in the grid;
    /// Error(out_of_memory) if the field is larger than the device's largest allocation; Error(device_failure).
    SurfacePictures(const Field& field, const Device& device, std::optional<double> offset = {});
    SurfacePictures(SurfacePictures&&) noexcept;
    SurfacePictures& operator=(SurfacePictures&&) noexcept;
    ~SurfacePictures();

    double offset() const;

    /// The axis that probably points upwards: y or z, the one along which the solid stands firmly; z if both,
    /// unless y is clearly firmer; y if neither.
    Axis upright() const;

    /// Throws Error(invalid_argument) if an option makes no sense, Error(cancelled), Error(device_failure).
    Hits hits(const SurfaceOptions& options) const;

    /// Writes a .png, complete or not at all. Throws what hits() does, Error(unsupported) for another ending, or
    /// Error(output_failure).
    void write(const SurfaceOptions& options, const std::string& path) const;

    /// Throws what write() would throw for the path's ending or folder. Leaves nothing behind.
    static void check_path(const std::string& path);

private:
    std::unique_ptr<const Scene> scene_;
};

}  // namespace clsdf::picture
