#pragma once

#include <clsdf/grid.hpp>

#include <cairo.h>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace clsdf::picture {

/// Red, green and blue, 0 ... 1, sRGB.
using Colour = std::array<double, 3>;

/// A colour for every distance. Signed: blue inside and orange outside, stronger with the distance, equally on both
/// sides. Readers with any colour vision can tell them apart; in grey copies iso-lines help. Unsigned: from yellow over
/// green to blue. Beyond the band: flat and paler. NaN is grey.
class Colours {
public:
    /// `lower` <= 0 <= `upper` are the least and the greatest distance that occur.
    Colours(double lower, double upper, const Band& band, bool has_sign);

    Colour operator()(double distance) const;

    /// The flat tones.
    Colour beyond_outside() const;
    Colour beyond_inside() const;

private:
    double reach_;
    double inside_;
    double outside_;
    bool has_sign_;
};

/// A point on paper, in pixels: right, down.
using Point = std::array<double, 2>;

struct Rectangle {
    double left = 0;
    double top = 0;
    double width = 0;
    double height = 0;

    double right() const { return left + width; }
    double bottom() const { return top + height; }
};

struct Pen {
    double width = 1;
    Colour colour{};
    double opacity = 1;
    std::vector<double> dashes;  ///< lengths of dash and gap; none: a line without gaps
};

/// The position of the anchor in a text.
enum class Place { start, middle, end };

struct TextStyle {
    double size = 12;
    Place horizontal = Place::start;
    Place vertical = Place::end;  ///< end: the point is on the base line; start: at the top of the capitals
    bool bold = false;
    bool upwards = false;  ///< turned by a quarter; the places turn with it
    Colour colour{};
};

/// Rows of pixels from the top, each 0x00RRGGBB.
struct Raster {
    int width = 0;
    int height = 0;
    std::vector<std::uint32_t> pixels;
};

/// An unbounded canvas: the picture becomes as large as the drawing. Lengths are in pixels. Text is UTF-8, in DejaVu
/// Sans or the nearest font; on a machine without fonts it is drawn in strokes, and in ASCII. Functions throw
/// Error(out_of_memory).
class Canvas {
public:
    Canvas();

    void draw(std::span<const Point> line, const Pen& pen);
    void draw(const Rectangle& outline, const Pen& pen);
    void fill(const Rectangle& area, const Colour& colour);
    /// At whole pixels, unscaled.
    void place(const Raster& raster, int left, int top);
    void write(const std::string& text, const Point& at, const TextStyle& style);
    double width_of(const std::string& text, const TextStyle& style) const;

    /// While it lives, nothing is drawn outside the rectangle.
    class Clip {
    public:
        Clip(Canvas& canvas, const Rectangle& area);
        ~Clip();
        Clip(const Clip&) = delete;
        Clip& operator=(const Clip&) = delete;

    private:
        Canvas& canvas_;
    };

    /// The drawing on white with a margin around it, as the bytes of a file.
    std::string png(double margin) const;
    /// The same, `points_per_pixel` points (1/72 inch) large per pixel.
    std::string pdf(double margin, double points_per_pixel) const;

    /// A file of just these pixels, without paper: each 0xAARRGGBB, the colours multiplied by the alpha.
    static std::string png_of(const Raster& raster);

private:
    struct Release {
        void operator()(cairo_surface_t* surface) const;
        void operator()(cairo_t* context) const;
    };
    using Surface = std::unique_ptr<cairo_surface_t, Release>;
    using Context = std::unique_ptr<cairo_t, Release>;

    static Surface image_of(const Raster& raster, cairo_format_t format);
    Rectangle sheet(double margin) const;
    void replay(cairo_surface_t* target, const Rectangle& sheet, double scale) const;
    /// The text in the characters that the chosen font has.
    std::string choose_font(const std::string& text, const TextStyle& style) const;

    Surface recording_;
    Context context_;
};

/// The path's ending in lower case, e.g. ".png". Throws Error(unsupported) if it is none of `endings`.
std::string ending_of(const std::string& path, std::initializer_list<std::string_view> endings);

/// Throws Error(output_failure) if no file can be written there. Leaves nothing behind.
void check_writable(const std::string& path);

/// Complete, or not at all. Throws Error(output_failure).
void write_file(const std::string& path, const std::string& bytes);

}  // namespace clsdf::picture
