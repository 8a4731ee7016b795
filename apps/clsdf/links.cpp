#include "interruption.hpp"
#include "option_values.hpp"
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
    std::string hits = "walls";
    bool between = false;
};

/// Whether the directions are those of a stencil.
bool is_named(const LinksOptions& options) {
    return options.directions.starts_with("D3Q");
}

std::vector<LinkDirection> directions_of(const LinksOptions& options) {
    if (is_named(options)) return clsdf::stencil(options.directions, options.order);
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

/// Options that others leave without an effect are refused.
void check_effects(const LinksOptions& options, bool is_order_given) {
    if (options.between && parse_hits(options.hits) == clsdf::Hits::faces)
        throw Error(ErrorCode::invalid_argument,
                    "--between has no effect with --hits faces, which has a row for every link that meets a face, also "
                    "with a body between its ends; leave out one of the two");
    if (is_order_given && !is_named(options))
        throw Error(
            ErrorCode::invalid_argument,
            fmt::format("--order {} has no effect with --directions {}, whose vectors stay in the order in which "
                        "they are given; leave it out, or name D3Q15, D3Q19 or D3Q27",
                        options.order, options.directions));
}

ExitStatus run(const LinksOptions& options, bool is_order_given, Report& report) {
    check_effects(options, is_order_given);
    clsdf::check_links_path(options.grid.output);
    const std::vector<LinkDirection> directions = directions_of(options);
    clsdf::Links links;
    const SegmentRun made =
        run_segments(options, report,
                     [&](const clsdf::DistanceTransform& transform, const clsdf::Grid& grid,
                         const clsdf::CallOptions& call, clsdf::TransformStatistics& statistics) {
                         require_memory_of_sides(grid);
                         if (parse_hits(options.hits) == clsdf::Hits::walls)
                             require_sign(transform.sign(), transform.topology(), options.grid.mesh, options.grid.sign,
                                          "--hits walls needs", "choose --hits faces");
                         links = transform.links(grid, directions,
                                                 {.hits = parse_hits(options.hits), .with_between = options.between},
                                                 call, &statistics);
                     });
    clsdf::write_links(links, made.grid, directions, options.grid.output, made.groups_or_null());
    output_is_written();
    report.print("done    {} links in {:.3f} s\n", links.size(), made.seconds);
    report.print("wrote   {}\n", options.grid.output);
    if (links.size() == 0) report.warn(warning_of_nothing("no link meets the surface", made.grid, made.box));
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
    add_hits_option(parser, options->hits);
    parser.add("--between", options->between, "also links with both ends outside and a body between them");
    parser.set_footer(
        "A link has a row if and only if its ends are on different sides: its sample, which is outside, its\n"
        "direction, q (the part up to the wall, 0 to 1), triangle, number of walls and flags.\n\n"
        "Examples:\n"
        "  clsdf links bunny.off -o bunny.npz\n"
        "  clsdf links bunny.off -o bunny.h5 --directions D3Q27 --order OpenLB --resolution 128\n"
        "  clsdf links wall.stl inlet.stl block.stl -o duct.npy --sign parity --with group\n"
        "  clsdf links wing.stl -o wing.npy --spacing 0.01 --directions 1,0,0,-1,0,0");
    return {parser, [options, parser](Report& report) { return run(*options, parser.has("--order"), report); }};
}
