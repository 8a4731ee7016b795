#include "command.hpp"
#include "compute.hpp"
#include "devices.hpp"
#include "interruption.hpp"
#include "option_values.hpp"
#include "report.hpp"
#include "segments.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/error.hpp>
#include <clsdf/part_files.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace {

struct PartChoice {
    SegmentOptions segments;  ///< whose grid has the band, too
    std::string cuts;
    std::uint64_t ghosts = 0;
    std::string moves = "0";  ///< a length: the margin of the parts
};

/// The blocks of a grid, each with its ghosts, in the order of x, then y, then z.
std::vector<clsdf::Grid> blocks_of(const clsdf::Grid& grid, const std::array<std::int64_t, 3>& cuts,
                                   std::int64_t ghosts) {
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (cuts[axis] < 1 || cuts[axis] > grid.size[axis])
            throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                               fmt::format("--cuts: {} blocks along {} of {} samples; choose 1 to {}", cuts[axis],
                                           "xyz"[axis], grid.size[axis], grid.size[axis]));
    std::vector<clsdf::Grid> blocks;
    for (std::int64_t z = 0; z < cuts[2]; ++z)
        for (std::int64_t y = 0; y < cuts[1]; ++y)
            for (std::int64_t x = 0; x < cuts[0]; ++x) {
                clsdf::Grid block = grid;
                const std::array<std::int64_t, 3> place{x, y, z};
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const std::int64_t begin = grid.size[axis] * place[axis] / cuts[axis],
                                       end = grid.size[axis] * (place[axis] + 1) / cuts[axis];
                    block.first[axis] = grid.first[axis] + begin - ghosts;
                    block.size[axis] = end - begin + 2 * ghosts;
                }
                blocks.push_back(block);
            }
    return blocks;
}

ExitStatus run(const PartChoice& choice, Report& report) {
    const ComputeOptions& own = choice.segments.grid;
    const auto cuts = parse_triple<std::int64_t>("--cuts", choice.cuts, "three whole numbers, as 4,2,2", true);
    const ComputeRequest request(own);
    const clsdf::Length moves = clsdf::Length::parse(choice.moves, "--moves");
    clsdf::PartWriter file(own.output);
    Json parts = Json::array();
    double half_width = 0, margin = 0;
    std::size_t count = 0, total = 0, most = 0;  // of parts, and their bytes
    const SegmentRun made = run_segments(
        choice.segments, report,
        [&](const clsdf::DistanceTransform& transform, const clsdf::Grid& grid, const clsdf::CallOptions& call,
            clsdf::TransformStatistics&) {
            const clsdf::Band band = request.band_on(grid, transform.box());
            half_width = std::max(band.inside, band.outside);
            if (!std::isfinite(half_width) || half_width == 0)
                throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                                   "--band: a part has the faces within a half width, which must be finite and above "
                                   "0; choose one, as 10% or 5v");
            margin = moves.resolve(grid.voxel(), transform.box().longest_side());
            for (const clsdf::Grid& block : blocks_of(grid, cuts, static_cast<std::int64_t>(choice.ghosts))) {
                if (call.should_stop()) throw clsdf::Error(clsdf::ErrorCode::cancelled, "stopped");
                const clsdf::DistanceTransform part =
                    transform.restrict_to({block.box(), half_width, std::ranges::max(block.spacing)}, margin);
                const std::vector<std::byte> bytes = part.part_bytes();
                file.append(bytes);
                parts.push_back({{"grid", describe(block)}, {"bytes", bytes.size()}});
                ++count;
                total += bytes.size();
                most = std::max(most, bytes.size());
            }
        });
    file.finish();
    output_is_written();
    report.print("parts   {}, up to {} each; half width {:g}\n", count, human_bytes(static_cast<double>(most)),
                 half_width);
    if (margin > 0) report.print("margin  {:g}, the longest way of a vertex\n", margin);
    report.print("wrote   {} ({})\n", own.output, human_bytes(static_cast<double>(total)));
    report.result = describe(choice.segments, made);
    report.result["half_width"] = half_width;
    report.result["margin"] = margin;
    report.result["parts"] = std::move(parts);
    return ExitStatus::done;
}

}  // namespace

Command add_part(Parser& program) {
    const auto choice = std::make_shared<PartChoice>();
    Parser parser = program.add_subcommand("part", "Prepare a mesh for the ranks of a parallel program");
    ComputeOptions& own = choice->segments.grid;
    add_mesh_argument(parser, own.mesh);
    parser.add("-o,--output", own.output, "the parts: .h5").takes("FILE").in_usage().required();
    parser.add("--cuts", choice->cuts, "blocks of the grid along x, y, z").takes_text("N[,N,N]").in_usage().required();
    parser.add("--ghosts", choice->ghosts, "samples around each block, on all sides")
        .takes_whole_number("N", 0, most_samples_on_a_side);
    parser.add("--band", own.band, "the largest distance asked for").takes_text("LENGTH");
    parser.add("--moves", choice->moves, "the longest way of a vertex in later positions").takes_text("LENGTH");
    add_grid_options(parser, own, "room around the mesh [--band]");
    parser.begin_group("Options");
    add_sign_options(parser, own.sign);
    add_placement_options(parser, own.reading);
    add_weld_option(parser, own.reading);
    add_skip_option(parser, own.reading);
    add_device_option(parser, own.device, "what prepares the mesh");
    parser.set_footer(
        "Block x, y, z of the cuts is part x + NX (y + NY z) of the file. A rank reads it (clsdf::read_part() of C++, "
        "or\n"
        "the dataset part_N by HDF5) and makes its transform of it, without the mesh: docs/parallel.md. This program "
        "has\n"
        "the whole mesh in memory.\n\n"
        "Examples:\n"
        "  clsdf part bunny.off -o parts.h5 --cuts 2,2,1 --resolution 256 --band 5v --ghosts 2\n"
        "  clsdf part city.stl -o parts.h5 --cuts 8,8,2 --box 0,0,0,800,800,200 --cells 1600,1600,400 --band 10");
    return {parser, [choice](Report& report) { return run(*choice, report); }};
}
