#include "core/refuse.hpp"
#include "picture/canvas.hpp"
#include "picture/panel.hpp"
#include "picture/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace clsdf::picture {
namespace {

namespace fs = std::filesystem;

constexpr double page = 1000;        // units on the longer side of what is drawn
constexpr double margin = 24;        // around everything
constexpr double panel_gap = 64;     // between the panels of a mosaic, for the titles of the lower ones
constexpr double bar_gap = 40;       // between panel and colour bar
constexpr double least_bar = 340;    // the height of a colour bar beside a flat panel
constexpr int most_levels = 24;      // iso-lines, about; half as many on one side
constexpr double line_gap = 6;       // minimum between iso-lines, because the gradient of a distance is at most 1
constexpr double print_width = 468;  // points on the longer side of what is drawn: 6.5 inches

bool is_pdf(const std::string& path) {
    return ending_of(path, {".png", ".pdf"}) == ".pdf";
}

void write_picture(const Canvas& canvas, double unit, const std::string& path) {
    write_file(path, is_pdf(path) ? canvas.pdf(margin * unit, print_width / (page * unit)) : canvas.png(margin * unit));
}

// The settings that the slices and mosaics of one field share.
class Drawing {
public:
    Drawing(const Field& field, double lower, double upper, bool has_sign, int pixels)
        : field_(field),
          bar_{lower, upper, has_sign && lower <= -static_cast<double>(static_cast<float>(field.band.inside)),
               upper >= static_cast<double>(static_cast<float>(field.band.outside)),
               has_sign ? "signed distance (mesh units)" : "distance (mesh units)"},
          manner_(Colours(lower, upper, field.band, has_sign), has_sign, static_cast<double>(pixels) / page) {}

    void slice(const Plane& plane, const Slice& slice, const std::string& path) {
        const double sides[] = {plane.upper[0] - plane.lower[0], plane.upper[1] - plane.lower[1]};
        const double scale = page * manner_.unit / std::max(sides[0], sides[1]);
        choose_levels(scale);
        const Rectangle panel{0, 0, whole(sides[0] * scale), whole(sides[1] * scale)};
        draw_plane(canvas_, plane, panel, manner_);
        draw_axis_below(canvas_, plane, panel, manner_, false);
        draw_axis_left(canvas_, plane, panel, manner_, false);

        const double height = std::max(panel.height, whole(units(least_bar)));
        draw_colour_bar(canvas_, bar_,
                        {panel.right() + whole(units(bar_gap)), std::floor((panel.height - height) / 2),
                         whole(units(colour_bar_width)), height},
                        manner_);
        // Above the panel and above a colour bar that is taller.
        const double base = std::min(0.0, std::floor((panel.height - height) / 2)) - units(20);
        canvas_.write(description(), {0, base}, small());
        canvas_.write(position_text(slice) + fmt::format(", sample {} of 0 … {}", slice.index,
                                                         field_.grid.size[static_cast<std::size_t>(slice.axis)] - 1),
                      {0, base - units(27)}, small());
        write_title({0, base - units(64)});
        write_picture(canvas_, manner_.unit, path);
    }

    // Two columns and two rows: y and z slices above one another share x, z and x slices beside one another share y.
    void mosaic(const Index3& at, const std::string& path) {
        const Plane top = plane_of(field_, {Axis::y, at[1]}, {Axis::x, Axis::z});
        const Plane left = plane_of(field_, {Axis::z, at[2]}, {Axis::x, Axis::y});
        const Plane right = plane_of(field_, {Axis::x, at[0]}, {Axis::z, Axis::y});
        const double x = left.upper[0] - left.lower[0];
        const double y = left.upper[1] - left.lower[1];
        const double z = right.upper[0] - right.lower[0];
        const double scale = units(page - panel_gap) / std::max(x + z, y + z);
        choose_levels(scale);
        const double gap = whole(units(panel_gap));
        const Rectangle upper_left{0, 0, whole(x * scale), whole(z * scale)};
        const Rectangle lower_left{0, upper_left.bottom() + gap, upper_left.width, whole(y * scale)};
        const Rectangle lower_right{lower_left.right() + gap, lower_left.top, whole(z * scale), lower_left.height};

        panel(top, {Axis::y, at[1]}, upper_left, true, false);
        panel(left, {Axis::z, at[2]}, lower_left, false, false);
        panel(right, {Axis::x, at[0]}, lower_right, false, true);
        cross(upper_left, fraction(at, 0), 1 - fraction(at, 2));
        cross(lower_left, fraction(at, 0), 1 - fraction(at, 1));
        cross(lower_right, fraction(at, 2), 1 - fraction(at, 1));

        const double height = std::max(upper_left.height, whole(units(least_bar)));
        const Rectangle bar{lower_right.left, upper_left.bottom() - height, whole(units(colour_bar_width)), height};
        draw_colour_bar(canvas_, bar_, bar, manner_);
        const double base = std::min(upper_left.top - units(20 + 27), bar.top) - units(24);
        canvas_.write(description(), {0, base}, small());
        write_title({0, base - units(37)});
        write_picture(canvas_, manner_.unit, path);
    }

private:
    double units(double length) const { return length * manner_.unit; }

    static double whole(double pixels) { return std::max(1.0, std::round(pixels)); }

    // `scale`: pixels per mesh unit.
    void choose_levels(double scale) {
        const double range = bar_.upper - bar_.lower;
        double least = std::max(range / (manner_.zero_line ? most_levels : most_levels / 2), units(line_gap) / scale);
        // A band that is narrow on paper has at least one line on either side.
        while (round_step(least) >= std::max(-bar_.lower, bar_.upper)) least /= 2;
        // A level at the end of the band would follow the stairs of its samples.
        const double room = 1e-6 * range;
        manner_.levels =
            scale_with_step(std::min(0.0, bar_.lower + room), std::max(0.0, bar_.upper - room), round_step(least));
    }

    TextStyle small() const { return {0.86 * units(text_size), Place::start, Place::end, false, false, faint_ink}; }

    void write_title(const Point& at) {
        const std::string name = fs::path(field_.mesh_name).filename().string();
        canvas_.write(name.empty() ? "Distance field" : printable(name, 48), at,
                      {1.4 * units(text_size), Place::start, Place::end, true, false, ink});
    }

    std::string position_text(const Slice& slice) const {
        Index3 sample{};
        const auto axis = static_cast<std::size_t>(slice.axis);
        sample[axis] = slice.index;
        const double position = field_.grid.position(sample[0], sample[1], sample[2])[axis];
        // The rounding of a position that is meant to be zero.
        const bool zero = std::abs(position) < 1e-9 * field_.grid.spacing[axis];
        return fmt::format("{} = {}", name_of(slice.axis), number(zero ? 0 : position, 6));
    }

    std::string description() const {
        const auto& [nx, ny, nz] = field_.grid.size;
        const auto& [hx, hy, hz] = field_.grid.spacing;
        std::string text =
            fmt::format("{} × {} × {} samples, {} apart", nx, ny, nz,
                        hx == hy && hy == hz ? number(hx, 4)
                                             : fmt::format("{}, {}, {}", number(hx, 4), number(hy, 4), number(hz, 4)));
        if (bar_.beyond_inside || bar_.beyond_outside) text += "; band " + band_text();
        const std::vector<double>& values = manner_.levels.values;
        if (values.size() > 1) text += fmt::format("; iso-lines every {}", number(values[1] - values[0], 4));
        return text;
    }

    std::string band_text() const {
        const double inside = field_.band.inside, outside = field_.band.outside;
        if (std::isinf(inside) && bar_.lower < 0) return fmt::format("everything inside … {}", number(outside, 4));
        return fmt::format("{} … {}", bar_.lower < 0 ? number(-inside, 4) : "0",
                           std::isinf(outside) ? "everything outside" : number(outside, 4));
    }

    void panel(const Plane& plane, const Slice& slice, const Rectangle& area, bool bare_below, bool bare_left) {
        draw_plane(canvas_, plane, area, manner_);
        draw_axis_below(canvas_, plane, area, manner_, bare_below);
        draw_axis_left(canvas_, plane, area, manner_, bare_left);
        canvas_.write(position_text(slice), {area.left, area.top - units(12)}, small());
    }

    // The position of the sample between the first and the last one of its axis.
    double fraction(const Index3& at, std::size_t axis) const {
        return static_cast<double>(at[axis]) / static_cast<double>(field_.grid.size[axis] - 1);
    }

    // The lines in which the two other slices cut this one.
    void cross(const Rectangle& area, double right, double down) {
        const Pen pen{units(1.5), ink, 0.8, {units(7), units(6)}};
        const double x = area.left + right * area.width;
        const double y = area.top + down * area.height;
        const Point upright[] = {{x, area.top}, {x, area.bottom()}};
        const Point level[] = {{area.left, y}, {area.right(), y}};
        canvas_.draw(upright, pen);
        canvas_.draw(level, pen);
    }

    const Field& field_;
    ColourBar bar_;
    Manner manner_;
    Canvas canvas_;
};

}  // namespace

SlicePictures::SlicePictures(const Field& field, const Options& options) : field_(field), options_(options) {
    check_field(field);
    if (options.pixels < 100 || options.pixels > 10000)
        refuse("a picture of {} pixels; choose 100 to 10000", options.pixels);
    float lower = 0;
    float upper = 0;
    bool negative = false;
    for (const float distance : field.distance()) {
        if (!std::isfinite(distance)) continue;
        lower = std::min(lower, distance);
        upper = std::max(upper, distance);
        negative = negative || std::signbit(distance);
    }
    lower_ = static_cast<double>(lower);
    upper_ = static_cast<double>(upper);
    if (lower_ == upper_) upper_ = field.grid.voxel();
    // A file of another program may not state whether its distances have signs.
    has_sign_ = field.sign == SignRule::automatic ? negative : field.sign != SignRule::none;
}

Slice SlicePictures::middle(Axis axis) const {
    return {axis, field_.grid.size[static_cast<std::size_t>(axis)] / 2};
}

void SlicePictures::write_slice(const Slice& slice, const std::string& path) const {
    check_path(path);
    const Plane plane = plane_of(field_, slice, axes_beside(slice.axis));
    Drawing(field_, lower_, upper_, has_sign_, options_.pixels).slice(plane, slice, path);
}

void SlicePictures::write_mosaic(const Index3& at, const std::string& path) const {
    check_path(path);
    Drawing(field_, lower_, upper_, has_sign_, options_.pixels).mosaic(at, path);
}

void SlicePictures::check_path(const std::string& path) {
    is_pdf(path);
    check_writable(path);
}

}  // namespace clsdf::picture
