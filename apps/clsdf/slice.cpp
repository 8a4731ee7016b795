#include "command.hpp"
#include "interruption.hpp"
#include "option_values.hpp"
#include "report.hpp"
#include "run_call.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>
#include <clsdf/picture.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>

namespace {

namespace fs = std::filesystem;

using clsdf::picture::Axis;
using clsdf::picture::SlicePictures;

struct SliceOptions {
    std::string field;
    std::string output;
    std::string axis = "z";
    std::optional<std::int64_t> index;
    bool all = false;
    bool mosaic = false;
    bool positive_inside = false;
    clsdf::picture::Options picture;
};

// "slice_007.png" for slice 7 if there are hundreds.
std::string numbered(const std::string& path, std::int64_t index, std::int64_t count) {
    const fs::path file(path);
    const std::size_t digits = fmt::format("{}", count - 1).size();
    return (file.parent_path() /
            fmt::format("{}_{:0{}}{}", file.stem().string(), index, digits, file.extension().string()))
        .string();
}

std::vector<std::string> write_all(const SlicePictures& pictures, Axis axis, std::int64_t count,
                                   const std::string& path, Report& report) {
    std::vector<std::string> files;
    std::int64_t index = 0;
    run_call(report, {.work_writes = true}, [&](const RunningCall& running) {
        for (; index < count && !running.stop.stop_requested(); ++index) {
            files.push_back(numbered(path, index, count));
            pictures.write_slice({axis, index}, files.back());
            running.bar.show(static_cast<double>(index + 1) / static_cast<double>(count));
        }
    });
    if (index < count)
        throw clsdf::Error(clsdf::ErrorCode::cancelled,
                           fmt::format("cancelled; {} of {} pictures were written", index, count));
    return files;
}

ExitStatus run(const SliceOptions& options, Report& report) {
    const Axis axis = clsdf::picture::parse_axis(options.axis);
    SlicePictures::check_path(options.output);
    keep_input(options.field, options.output, "field");
    clsdf::Field field = clsdf::read_field(options.field, {});
    make_negative_inside(field, options.positive_inside, options.field);
    const SlicePictures pictures(field, options.picture);

    std::vector<std::string> files{options.output};
    if (options.all) {
        files = write_all(pictures, axis, field.grid.size[static_cast<std::size_t>(axis)], options.output, report);
    } else if (options.mosaic) {
        pictures.write_mosaic(
            {pictures.middle(Axis::x).index, pictures.middle(Axis::y).index, pictures.middle(Axis::z).index},
            options.output);
    } else {
        pictures.write_slice({axis, options.index.value_or(pictures.middle(axis).index)}, options.output);
    }

    output_is_written();
    report.print("wrote {}\n", files.size() == 1
                                   ? files.front()
                                   : fmt::format("{} pictures, {} to {}", files.size(), files.front(), files.back()));
    report.result = {{"field", options.field}, {"grid", describe(field.grid)}, {"pictures", files}};
    return ExitStatus::done;
}

}  // namespace

Command add_slice(Parser& program) {
    const auto options = std::make_shared<SliceOptions>();
    Parser parser = program.add_subcommand("slice", "Draw a field: colours, iso-lines, axes and a colour bar");
    parser.add("FIELD", options->field, "the field: .nrrd, .npy, .vti, .vtkhdf, .h5, .vdb, .nvdb or .sdf").required();
    parser.add("-o,--output", options->output, "the picture: .png, or .pdf for print").takes("PICTURE").required();
    parser.add("--axis", options->axis, "perpendicular to the slice").takes_one_of({"x", "y", "z"});
    parser.add("--index", options->index, "the slice's sample along the axis, from 0 [the middle]")
        .takes_whole_number("K", 0, most_samples_on_a_side);
    parser.add("--all", options->all, "every slice, as FILE_000.png, FILE_001.png, ...").excludes("--index");
    parser.add("--mosaic", options->mosaic, "the middle slices of the three axes in one picture")
        .excludes("--axis")
        .excludes("--index")
        .excludes("--all");
    add_field_convention_option(parser, options->positive_inside);
    parser.add("--pixels", options->picture.pixels, "of the longer side, without axes and colour bar: 100 to 10000")
        .takes_whole_number("N", 100, 10000);
    parser.set_footer(
        "Inside is blue, outside orange, and the zero line is the strong one; beyond the band the colours are flat "
        "and\n"
        "pale. A field without a sign has colours from yellow to blue and no zero line.\n\n"
        "Examples:\n"
        "  clsdf slice bunny.nrrd -o bunny.png\n"
        "  clsdf slice bunny.nrrd -o bunny.pdf --axis x --index 100\n"
        "  clsdf slice bunny.nrrd -o slices/bunny.png --axis y --all --pixels 600\n"
        "  clsdf slice bunny.nrrd -o bunny.png --mosaic");
    return {parser, [options](Report& report) {
                try {
                    return run(*options, report);
                } catch (const clsdf::Error& error) {
                    throw with_file(error, "field: ", options->field);
                }
            }};
}
