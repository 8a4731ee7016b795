#include "interruption.hpp"
#include "segments.hpp"

#include <clsdf/io.hpp>

#include <fmt/format.h>

#include <memory>

using clsdf::Error;
using clsdf::ErrorCode;
using clsdf::LinkDirection;

namespace {

struct LinksOptions : SegmentOptions {
    std::string directions = "D3Q19";
    std::string order = "waLBerla";
    bool faces = false;
    bool between = false;
};

std::vector<LinkDirection> directions_of(const LinksOptions& options) {
    if (options.directions.starts_with("D3Q")) return clsdf::stencil(options.directions, options.order);
    const auto numbers = parse_list<std::int32_t>(options.directions);
    if (!numbers || numbers->size() % 3 != 0)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("--directions: expected D3Q15, D3Q19, D3Q27, or three whole numbers for each, as "
                                "1,0,0,-1,0,0, not '{}'",
                                options.directions));
    std::vector<LinkDirection> directions(numbers->size() / 3);
    for (std::size_t n = 0; n < numbers->size(); ++n) directions[n / 3][n % 3] = (*numbers)[n];
    return directions;
}

ExitStatus run(const LinksOptions& options, Report& report) {
    clsdf::check_links_path(options.grid.output);
    const std::vector<LinkDirection> directions = directions_of(options);
    clsdf::Links links;
    const SegmentRun made = run_segments(
        options, report,
        [&](const clsdf::DistanceTransform& transform, const clsdf::Grid& grid, const clsdf::CallOptions& call,
            clsdf::TransformStatistics& statistics) {
            links = transform.links(
                grid, directions,
                {.hits = options.faces ? clsdf::Hits::faces : clsdf::Hits::walls, .with_between = options.between},
                call, &statistics);
        });
    clsdf::write_links(links, made.grid, directions, options.grid.output);
    output_is_written();
    report.print("done    {} links in {:.3f} s\n", links.size(), made.seconds);
    report.print("wrote   {}\n", options.grid.output);
    report.result = describe(options, made);
    report.result["links"] = links.size();
    report.result["directions"] = directions;
    return ExitStatus::done;
}

}  // namespace

Command add_links(Parser& program) {
    const auto options = std::make_shared<LinksOptions>();
    Parser parser = program.add_subcommand("links", "Find where the links of a lattice meet the surface");
    add_segment_options(parser, *options, "the links: .npz, .h5 or .npy");
    parser.begin_group("Links");
    parser.add("--directions", options->directions, "D3Q15, D3Q19, D3Q27, or up to 32 whole vectors, as 1,0,0,-1,0,0")
        .takes_text("LIST");
    parser.add("--order", options->order, "of the directions of a name: as this code has them")
        .takes_one_of({"OpenLB", "waLBerla", "lbmpy", "Palabos", "XLB"});
    parser.add("--faces", options->faces,
               "all faces as given, also of a mesh without a sign; else where the side changes");
    parser.add("--between", options->between, "also links with both ends outside and a body between them");
    parser.set_footer(
        "A link has a row if and only if its ends are on different sides: its sample, which is outside, its\n"
        "direction, q (the part up to the wall, 0 to 1), triangle, number of walls and flags.\n\n"
        "Examples:\n"
        "  clsdf links bunny.off -o bunny.npz\n"
        "  clsdf links bunny.off -o bunny.h5 --directions D3Q27 --order OpenLB --resolution 128\n"
        "  clsdf links wing.stl -o wing.npy --spacing 0.01 --directions 1,0,0,-1,0,0");
    return {parser, [options](Report& report) { return run(*options, report); }};
}
