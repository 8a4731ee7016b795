#include "interruption.hpp"
#include "option_values.hpp"
#include "segments.hpp"

#include <clsdf/io.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace {

struct CrossingsOptions : SegmentOptions {
    bool counts = false;
};

ExitStatus run(const CrossingsOptions& options, Report& report) {
    clsdf::check_crossings_path(options.grid.output);
    clsdf::Crossings crossings;
    const SegmentRun made =
        run_segments(options, report,
                     [&](const clsdf::DistanceTransform& transform, const clsdf::Grid& grid,
                         const clsdf::CallOptions& call, clsdf::TransformStatistics& statistics) {
                         require_memory_of_sides(grid);
                         require_sign(transform.sign(), transform.topology(), options.grid.mesh, options.grid.sign,
                                      "crossings need", "");
                         crossings = transform.crossings(grid, {.with_counts = options.counts}, call, &statistics);
                     });
    clsdf::write_crossings(crossings, made.grid, options.grid.output, made.groups_or_null());
    output_is_written();
    std::array<std::size_t, 3> crossed{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        crossed[axis] = static_cast<std::size_t>(
            std::ranges::count_if(crossings.axes[axis].coordinates, [](double x) { return !std::isnan(x); }));
    report.print("done    {}, {} and {} crossed edges along x, y and z in {:.3f} s\n", crossed[0], crossed[1],
                 crossed[2], made.seconds);
    report.print("wrote   {}\n", options.grid.output);
    if (crossed == std::array<std::size_t, 3>{})
        report.warn(warning_of_nothing("no edge meets the surface", made.grid, made.box));
    report.result = describe(options, made);
    report.result["crossed"] = crossed;
    return ExitStatus::done;
}

}  // namespace

Command add_crossings(Parser& program) {
    const auto options = std::make_shared<CrossingsOptions>();
    Parser parser = program.add_subcommand("crossings", "Find where the edges of a grid meet the surface");
    add_segment_options(parser, *options, "the crossings: .npz or .h5");
    parser.begin_group("Crossings");
    parser.add("--counts", options->counts, "the number of walls on each edge, too");
    parser.set_footer(
        "An edge joins two neighbouring samples. It has a crossing, a coordinate along its axis and a triangle, if "
        "and\n"
        "only if they are on different sides; else the coordinate is nan.\n\n"
        "Examples:\n"
        "  clsdf crossings bunny.off -o bunny.npz\n"
        "  clsdf crossings part.stl -o part.h5 --box -1,-1,-1,1,1,1 --cells 64");
    return {parser, [options](Report& report) { return run(*options, report); }};
}
