#include "command.hpp"
#include "devices.hpp"
#include "interruption.hpp"
#include "option_values.hpp"
#include "report.hpp"
#include "run_call.hpp"

#include "core/real_numbers.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>
#include <clsdf/picture.hpp>

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <memory>
#include <optional>

namespace {

using clsdf::Error;
using clsdf::ErrorCode;
using clsdf::picture::Cut;
using clsdf::picture::SurfaceOptions;
using clsdf::picture::SurfacePictures;

struct RenderOptions {
    std::string field;
    std::string output;
    std::string view = "30,20";
    std::string up = "auto";
    std::string size = "1200";
    std::string colour = "CCC4B8";
    std::vector<std::string> cuts;
    std::string offset;
    std::string device;
    bool positive_inside = false;
    SurfaceOptions picture;
};

template <class Number>
std::optional<Number> parse(std::string_view text) {
    Number number{};
    const auto [stop, error] = clsdf::read_number(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || stop != text.data() + text.size()) return std::nullopt;
    return number;
}

std::optional<double> parse_length(std::string_view text) {
    const auto number = parse<double>(text);
    return number && std::isfinite(*number) ? number : std::nullopt;
}

// "1200" or "1200x900".
void set_size(SurfaceOptions& picture, const std::string& text) {
    const std::size_t cross = text.find('x');
    const auto width = parse<int>(std::string_view(text).substr(0, cross));
    const auto height = cross == std::string::npos ? 0 : parse<int>(std::string_view(text).substr(cross + 1));
    const auto fits = [](int pixels) { return pixels >= 16 && pixels <= 10000; };
    if (!width || !height || !fits(*width) || (cross != std::string::npos && !fits(*height)))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("--size: WxH, or N for the longer side, in pixels from 16 to 10000, not '{}'", text));
    picture.width = *width;
    picture.height = *height;
}

// "CC7744" or "#CC7744".
void set_colour(SurfaceOptions& picture, const std::string& text) {
    const std::string_view digits = std::string_view(text).substr(text.starts_with('#') ? 1 : 0);
    unsigned value = 0;
    const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
    if (error != std::errc() || stop != digits.data() + digits.size() || digits.size() != 6)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("--colour: red, green and blue in six hexadecimal digits, as CC7744, not '{}'", text));
    for (std::size_t i = 0; i < 3; ++i) picture.colour[i] = static_cast<double>(value >> (16 - 8 * i) & 0xFFU) / 255;
}

// "x=0.3", or "x" for the solid's middle.
Cut parse_cut(const std::string& text) {
    const std::size_t equals = text.find('=');
    Cut cut{clsdf::picture::parse_axis(text.substr(0, equals)), {}};
    if (equals == std::string::npos) return cut;
    cut.position = parse_length(std::string_view(text).substr(equals + 1));
    if (!cut.position)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("--cut: an axis and a position, as x=0.3, or x for the middle, not '{}'", text));
    return cut;
}

// The checks that do not need the field come first, so that a mistake is reported at once.
std::optional<double> read_options(RenderOptions& options) {
    set_direction(options.picture.view, options.view);
    set_up(options.picture.view, options.up);
    set_size(options.picture, options.size);
    set_colour(options.picture, options.colour);
    for (const std::string& cut : options.cuts) options.picture.cuts.push_back(parse_cut(cut));
    if (options.offset.empty()) return std::nullopt;
    const auto offset = parse_length(options.offset);
    if (!offset)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("--offset: a finite distance in the mesh's units, not '{}'", options.offset));
    return offset;
}

ExitStatus run(RenderOptions options, Report& report) {
    const std::optional<double> offset = read_options(options);
    SurfacePictures::check_path(options.output);
    keep_input(options.field, options.output, "field");
    clsdf::Field field = clsdf::read_field(options.field, {});
    make_negative_inside(field, options.positive_inside, options.field);
    double level = 0;
    clsdf::picture::Axis upright{};
    std::string device_name;
    run_call(report,
             {.explain = [&](const Error& error) { return with_file(error, "field: ", options.field); },
              .cancelled = "cancelled; no picture was written",
              .work_writes = true},
             [&](const RunningCall& running) {
                 options.picture.should_stop = running.call.should_stop;
                 options.picture.progress = [&](double fraction) { running.bar.show(fraction); };
                 const clsdf::Device device = open_device(options.device, report);
                 const SurfacePictures pictures(field, device, offset);
                 level = pictures.offset();
                 upright = pictures.upright();
                 device_name = device.name();  // it may fail, and then no picture is there
                 pictures.write(options.picture, options.output);
                 output_is_written();
             });
    report.print("wrote {}{}\n", options.output,
                 options.picture.view.up ? "" : fmt::format(", {} upwards (--up)", name_of(upright)));
    report.result = {{"field", options.field}, {"grid", describe(field.grid)},
                     {"offset", level},        {"up", options.picture.view.up ? options.up : name_of(upright)},
                     {"device", device_name},  {"picture", options.output}};
    return ExitStatus::done;
}

}  // namespace

Command add_render(Parser& program) {
    const auto options = std::make_shared<RenderOptions>();
    Parser parser = program.add_subcommand("render", "Draw a field's surface, shaded, whole or cut open");
    parser.add("FIELD", options->field, "the field: .nrrd, .npy, .vti, .vtkhdf, .h5, .vdb, .nvdb or .sdf").required();
    parser.add("-o,--output", options->output, "the picture: .png").takes("PICTURE").required();
    parser
        .add("--view", options->view,
             "direction of the viewer: front, back, left, right, side, top, bottom, iso, or AZIMUTH,ELEVATION "
             "in degrees")
        .takes("VIEW");
    parser
        .add("--up", options->up,
             "the axis that points upwards: auto (z if the solid stands firmly on it and y is not clearly firmer, else "
             "y), x, y, z, -x, -y or -z")
        .takes("AXIS");
    parser.add("--perspective", options->picture.view.perspective, "angle of view in degrees; 0: parallel rays")
        .takes_number_of_0_or_more("DEGREES");
    parser
        .add("--cut", options->cuts,
             "open the solid at a position on an axis, as x=0.3, or in its middle, as x; once an axis at most")
        .takes("AXIS[=X]");
    parser
        .add("--offset", options->offset,
             "draw the surface at this distance, < 0: inside [0; without a sign, one voxel]")
        .takes_text("D");
    add_field_convention_option(parser, options->positive_inside);
    parser.add("--size", options->size, "pixels: WxH, or N for the longer side").takes("SIZE");
    parser.add("--colour", options->colour, "of the surface: six hexadecimal digits").takes("RRGGBB");
    parser.add("--rays", options->picture.rays, "in each direction of a pixel, 1 to 8").takes_whole_number("N", 1, 8);
    parser.add("--transparent", options->picture.transparent, "no background; implies --bare");
    parser.add("--bare", options->picture.bare, "no title and no colour bar beside a cut");
    add_device_option(parser, options->device, "what traces the rays");
    parser.set_footer(
        "A cut removes the part on the viewer's side of a plane, several cuts the part on that side of all planes.\n"
        "The opened inside shows the distances, coloured as by \"clsdf slice\".\n\n"
        "Examples:\n"
        "  clsdf render part.nrrd -o part.png\n"
        "  clsdf render bunny.nrrd -o bunny.png --view front --size 1600x1200\n"
        "  clsdf render bunny.nrrd -o bunny.png --cut z\n"
        "  clsdf render part.nrrd -o corner.png --view iso --cut x=10 --cut y=10 --cut z\n"
        "  clsdf render part.nrrd -o grown.png --offset 0.5 --colour 7799BB");
    return {parser, [options](Report& report) { return run(*options, report); }};
}
