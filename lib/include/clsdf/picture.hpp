#pragma once

/// Pictures of a field. A target of their own, clsdf::picture, because they are drawn with cairo, which the library
/// proper has no use for.
#include <clsdf/field.hpp>

#include <cstdint>
#include <string>

namespace clsdf::picture {

/// The axis that a slice is perpendicular to.
enum class Axis { x, y, z };

/// "x", "y", "z". parse_axis() throws Error(invalid_argument) for anything else.
const char* name_of(Axis axis);
Axis parse_axis(const std::string& text);

/// The samples of a field with the same index along one axis; the index counts from the field's first sample.
struct Slice {
    Axis axis = Axis::z;
    std::int64_t index = 0;
};

struct Options {
    /// Of the drawn samples' longer side, in 100 ... 10000; text and lines grow with it. A mosaic shares it among its
    /// panels. 1200 fill the width of a printed page.
    int pixels = 1200;
};

/// Draws slices of one field: colours by sign and distance, iso-lines at round values, a strong line where the distance
/// is zero, axes in the mesh's units, and a colour bar. A distance has the same colour in every slice of the field, and
/// all slices along an axis have the same iso-lines. What lies beyond the band has a flat, paler tone by its sign. A
/// field without a sign has colours on one side only and no zero line.
class SlicePictures {
public:
    /// Keeps a reference to the field. Throws Error(invalid_argument) where the distances do not fit the grid, or the
    /// number of pixels is out of range.
    explicit SlicePictures(const Field& field, const Options& options = {});

    /// The slice through the middle of the grid.
    Slice middle(Axis axis) const;

    /// Writes a .png, or a .pdf whose lines and text are drawn at the printer's own resolution. The file appears
    /// complete or not at all. Throws Error(output_failure), Error(unsupported) for another ending, or
    /// Error(invalid_argument) where the field has no such slice, or one without extent.
    void write_slice(const Slice& slice, const std::string& path) const;

    /// The three slices through sample `at`, side by side on one scale with their axes aligned. Throws what
    /// write_slice() does.
    void write_mosaic(const Index3& at, const std::string& path) const;

    /// Throws what a write would throw for the path's ending or folder, before any work is done. Leaves nothing behind.
    static void check_output(const std::string& path);

private:
    const Field& field_;
    Options options_;
    double lower_ = 0;  // the least and the greatest distance in the field, with 0 between them
    double upper_ = 0;
    bool has_sign_ = false;
};

}  // namespace clsdf::picture
