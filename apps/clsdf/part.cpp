#include "command.hpp"
#include "compute.hpp"
#include "devices.hpp"
#include "interruption.hpp"
#include "option_values.hpp"
#include "report.hpp"
#include "scratch_memory.hpp"
#include "segments.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/error.hpp>
#include <clsdf/part_files.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace {

struct PartChoice {
    SegmentOptions segments;  ///< whose grid has the band, too
    std::string cuts;
    std::string boxes;  ///< a file; empty: cuts
    std::uint64_t ghosts = 0;
    std::string moves = "0";  ///< a length: the margin of the parts
    std::string memory;       ///< bytes; empty: as much as it takes
    std::string scratch;      ///< a folder; empty: that of the output
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

/// The boxes of a file: six numbers a line, between blanks or commas.
std::vector<clsdf::Box> read_boxes(const std::string& path) {
    std::ifstream file(path);
    if (!file)
        throw clsdf::Error(clsdf::ErrorCode::unreadable_input,
                           fmt::format("{}: {}", path, std::generic_category().message(errno)));
    std::vector<clsdf::Box> boxes;
    std::string line;
    for (std::size_t number = 1; std::getline(file, line); ++number) {
        std::ranges::replace_if(
            line, [](char letter) { return letter == ' ' || letter == '\t' || letter == '\r'; }, ',');
        std::string list;
        std::ranges::unique_copy(line, std::back_inserter(list), [](char a, char b) { return a == ',' && b == ','; });
        if (list.ends_with(',')) list.pop_back();
        if (list.starts_with(',')) list.erase(0, 1);
        if (list.empty() || list.starts_with('#')) continue;
        const auto numbers = parse_list<double>(list);
        if (!numbers || numbers->size() != 6)
            throw clsdf::Error(
                clsdf::ErrorCode::unreadable_input,
                fmt::format("{}:{}: a box is six numbers, X0 Y0 Z0 X1 Y1 Z1; found '{}'", path, number, line));
        const auto& n = *numbers;
        boxes.push_back({{n[0], n[1], n[2]}, {n[3], n[4], n[5]}});
    }
    if (boxes.empty()) throw clsdf::Error(clsdf::ErrorCode::unreadable_input, fmt::format("{}: there is no box", path));
    return boxes;
}

/// For the program, the driver and its compiler.
constexpr std::size_t least_memory = 400'000'000;

/// Null without --memory.
std::unique_ptr<ScratchMemory> scratch_memory(const PartChoice& choice) {
    if (choice.memory.empty()) return nullptr;
    const std::size_t memory = parse_bytes("--memory", choice.memory);
    if (memory < least_memory)
        throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                           fmt::format("--memory: {} is too little, as the program alone takes up to {}; give more",
                                       choice.memory, human_bytes(least_memory)));
    std::string folder = choice.scratch;
    if (folder.empty()) folder = std::filesystem::path(choice.segments.grid.output).parent_path().string();
    return std::make_unique<ScratchMemory>(folder.empty() ? "." : folder, memory);
}

/// The parts of the blocks or boxes, which are written as they are made.
class Parts {
public:
    Parts(const PartChoice& choice, clsdf::PartWriter& file)
        : request_(choice.segments.grid),
          ghosts_(static_cast<std::int64_t>(choice.ghosts)),
          moves_(clsdf::Length::parse(choice.moves, "--moves")),
          file_(file) {
        if (!choice.boxes.empty())
            boxes_ = read_boxes(choice.boxes);
        else if (!choice.cuts.empty())
            cuts_ = parse_triple<std::int64_t>("--cuts", choice.cuts, "three whole numbers, as 4,2,2", true);
        else
            throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                               "--cuts: without it, --boxes must name a file of the parts' boxes");
    }

    void make(const clsdf::DistanceTransform& transform, const clsdf::Grid& grid, const clsdf::CallOptions& call) {
        const clsdf::Band band = request_.band_on(grid, transform.box());
        half_width = std::max(band.inside, band.outside);
        if (!std::isfinite(half_width) || half_width == 0)
            throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                               "--band: a part has the faces within a half width, which must be finite and above "
                               "0; choose one, as 10% or 5v");
        margin = moves_.resolve(grid.voxel(), transform.box().longest_side());
        const double spacing = std::ranges::max(grid.spacing);
        const auto add = [&](const clsdf::Box& box, Json described) {
            if (call.should_stop()) throw clsdf::Error(clsdf::ErrorCode::cancelled, "stopped");
            const std::vector<std::byte> bytes = transform.restrict_to({box, half_width, spacing}, margin).part_bytes();
            file_.append(bytes);
            described["bytes"] = bytes.size();
            list.push_back(std::move(described));
            total += bytes.size();
            most = std::max(most, bytes.size());
        };
        for (const clsdf::Box& box : boxes_) add(box, {{"box", {{"lower", box.lower}, {"upper", box.upper}}}});
        if (!boxes_.empty()) return;
        for (const clsdf::Grid& block : blocks_of(grid, cuts_, ghosts_)) add(block.box(), {{"grid", describe(block)}});
    }

    Json list = Json::array();
    double half_width = 0, margin = 0;
    std::size_t total = 0, most = 0;  ///< bytes of all parts, and of one

private:
    ComputeRequest request_;
    std::vector<clsdf::Box> boxes_;  // empty: cuts
    std::array<std::int64_t, 3> cuts_{};
    std::int64_t ghosts_;
    clsdf::Length moves_;
    clsdf::PartWriter& file_;
};

ExitStatus run(const PartChoice& choice, Report& report) {
    const std::unique_ptr<ScratchMemory> scratch = scratch_memory(choice);
    clsdf::PartWriter file(choice.segments.grid.output);
    Parts parts(choice, file);
    SegmentRun made;
    try {
        made = run_segments(
            choice.segments, report,
            [&](const clsdf::DistanceTransform& transform, const clsdf::Grid& grid, const clsdf::CallOptions& call,
                clsdf::TransformStatistics&) { parts.make(transform, grid, call); });
    } catch (const clsdf::Error& error) {
        if (scratch && error.code() == clsdf::ErrorCode::out_of_memory) scratch->throw_if_full();
        throw;
    }
    file.finish();
    output_is_written();
    report.print("parts   {}, up to {} each; half width {:g}\n", parts.list.elements().size(),
                 human_bytes(static_cast<double>(parts.most)), parts.half_width);
    if (parts.margin > 0) report.print("margin  {:g}, the longest way of a vertex\n", parts.margin);
    report.print("wrote   {} ({})\n", choice.segments.grid.output, human_bytes(static_cast<double>(parts.total)));
    report.result = describe(choice.segments, made);
    report.result["half_width"] = parts.half_width;
    report.result["margin"] = parts.margin;
    report.result["parts"] = std::move(parts.list);
    if (scratch) {
        const ScratchMemory::Use use = scratch->use();
        report.print("memory  {}, and {} on disk\n", human_bytes(static_cast<double>(use.most_resident)),
                     human_bytes(static_cast<double>(use.most_bytes)));
        if (use.missed > 0)
            report.warn(fmt::format("arrays of {} stayed in memory, for lack of open files; allow more (ulimit -n)",
                                    human_bytes(static_cast<double>(use.missed))));
        report.result["memory"] = {{"resident_bytes", use.most_resident},
                                   {"scratch_bytes", use.most_bytes},
                                   {"blocks", use.blocks},
                                   {"missed_bytes", use.missed},
                                   {"waited_seconds", use.waited}};
    }
    return ExitStatus::done;
}

}  // namespace

Command add_part(Parser& program) {
    const auto choice = std::make_shared<PartChoice>();
    Parser parser = program.add_subcommand("part", "Prepare a mesh for the ranks of a parallel program");
    ComputeOptions& own = choice->segments.grid;
    add_mesh_argument(parser, own.mesh);
    parser.add("-o,--output", own.output, "the parts: .h5").takes("FILE").in_usage().required();
    parser.add("--cuts", choice->cuts, "blocks of the grid along x, y, z").takes_text("N[,N,N]").in_usage();
    parser.add("--boxes", choice->boxes, "instead: boxes of the parts, a line X0 Y0 Z0 X1 Y1 Z1 each")
        .takes("FILE")
        .excludes("--cuts");
    parser.add("--ghosts", choice->ghosts, "samples around each block, on all sides")
        .takes_whole_number("N", 0, most_samples_on_a_side)
        .excludes("--boxes");
    parser.add("--band", own.band, "the largest distance asked for").takes_text("LENGTH");
    parser.add("--moves", choice->moves, "the longest way of a vertex in later positions").takes_text("LENGTH");
    parser.add("--memory", choice->memory, "the most memory; larger arrays lie in files of --scratch")
        .takes_text("BYTES");
    parser.add("--scratch", choice->scratch, "the folder of these files, which have no names [that of the output]")
        .takes_text("FOLDER")
        .needs("--memory");
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
        "the whole mesh in memory, or with --memory in files of a scratch folder.\n\n"
        "Examples:\n"
        "  clsdf part bunny.off -o parts.h5 --cuts 2,2,1 --resolution 256 --band 5v --ghosts 2\n"
        "  clsdf part city.stl -o parts.h5 --cuts 8,8,2 --box 0,0,0,800,800,200 --cells 1600,1600,400 --band 10\n"
        "  clsdf part city.stl -o parts.h5 --cuts 8,8,2 --spacing 0.5 --band 10 --memory 2G --scratch /scratch");
    return {parser, [choice](Report& report) { return run(*choice, report); }};
}
