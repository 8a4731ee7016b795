#pragma once

#include "command.hpp"
#include "compute.hpp"

#include <clsdf/clsdf.hpp>

#include <functional>
#include <optional>
#include <string>

/// What the subcommands links and crossings share: a mesh and a grid.
struct SegmentOptions {
    ComputeOptions grid;  ///< those of the grid, the sign, the mesh and its groups alone
};

/// Refuses a grid whose sides of samples need more memory than the machine has.
void require_memory_of_sides(const clsdf::Grid& grid);

void add_segment_options(Parser& parser, SegmentOptions& options, const char* output);

struct SegmentRun {
    clsdf::Grid grid;
    clsdf::Box box{};  ///< around the mesh
    clsdf::SignRule sign = clsdf::SignRule::none;
    double seconds = 0;
    std::string device;
    std::optional<clsdf::FaceGroups> groups{};  ///< if they are asked for

    const clsdf::FaceGroups* groups_or_null() const { return groups ? &*groups : nullptr; }
};

/// Reads the mesh and calls find(transform, grid, call, statistics). Prints what they are.
SegmentRun run_segments(const SegmentOptions& options, Report& report,
                        const std::function<void(const clsdf::DistanceTransform&, const clsdf::Grid&,
                                                 const clsdf::CallOptions&, clsdf::TransformStatistics&)>& find);

Json describe(const SegmentOptions& options, const SegmentRun& run);
