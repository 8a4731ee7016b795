#pragma once

#include <clsdf/clsdf.hpp>
#include <clsdf/papers.hpp>

#include <CLI/CLI.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// The options of "clsdf compute" as they are typed.
struct ComputeOptions {
    std::string mesh;
    std::string output;
    std::int64_t resolution = 256;
    std::string spacing;
    std::string size;
    std::string origin;
    std::string margin;
    bool cubic = false;
    bool cell_centred = false;
    std::string band = "10%";
    std::string band_inside;
    std::string band_outside;
    std::string sign = "auto";
    std::vector<std::string> with;
    std::string polyhedra = "leaned";
    std::string scan = "auto";
    std::string device;
    bool dry_run = false;
};

void add_options(CLI::App& parser, ComputeOptions& options);

/// The request of the options, before the mesh is known.
struct ComputeRequest {
    clsdf::GridOptions grid;
    /// A grid stated in full, instead of one around the mesh.
    std::optional<clsdf::Grid> stated_grid;
    clsdf::Length band_inside;
    clsdf::Length band_outside;
    clsdf::SignRule sign = clsdf::SignRule::automatic;
    clsdf::Outputs outputs;
    clsdf::Polyhedra polyhedra = clsdf::Polyhedra::leaned;
    clsdf::Scan scan = clsdf::Scan::bricks;  ///< not automatic

    /// Throws clsdf::Error(invalid_argument) that names the option.
    explicit ComputeRequest(const ComputeOptions& options);

    clsdf::Grid grid_around(const clsdf::Box& box) const;
    clsdf::Band band_on(const clsdf::Grid& samples, const clsdf::Box& box) const;
};
