#pragma once

#include "json.hpp"
#include "option_values.hpp"
#include "options.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/papers.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// The options of "clsdf compute" as they are typed.
struct ComputeOptions {
    std::vector<std::string> mesh;
    MeshReading reading;
    std::string output;
    std::int64_t resolution = 256;
    std::string spacing;
    std::string size;
    std::string origin;
    std::string box;
    std::string samples;
    std::string cells;
    std::string margin;
    bool cubic = false;
    bool cell_centred = false;
    std::string band = "10%";
    std::string band_inside;
    std::string band_outside;
    SignChoice sign;
    std::vector<std::string> with;
    bool positive_inside = false;
    bool exact_signs = false;
    std::string polyhedra = "leaned";
    std::string scan = "auto";
    std::string device;
    bool sparse = false;
    bool dry_run = false;
};

void add_options(Parser& parser, ComputeOptions& options);
/// "clsdf compute" of a file of many bodies (compute_scene.cpp).
ExitStatus compute_scene(const ComputeOptions& options, Report& report);
/// An error for too little memory gets the option that makes the grid smaller; others stay.
clsdf::Error with_remedy(const ComputeOptions& options, const clsdf::Error& error);
/// Those of the grid alone. `margin` describes --margin.
void add_grid_options(Parser& parser, ComputeOptions& options, const std::string& margin);

/// The request of the options, before the mesh is known.
struct ComputeRequest {
    clsdf::GridOptions grid;
    /// A grid stated in full, instead of one around the mesh.
    std::optional<clsdf::Grid> stated_grid;
    clsdf::Length band_inside;
    clsdf::Length band_outside;
    bool exact_signs = false;
    clsdf::SignRule sign = clsdf::SignRule::automatic;
    std::optional<double> floor{};  ///< of the rule `below`
    clsdf::Surface surface = clsdf::Surface::given;
    clsdf::OutputSet outputs;
    clsdf::Polyhedra polyhedra = clsdf::Polyhedra::leaned;
    clsdf::Scan scan = clsdf::Scan::bricks;  ///< not automatic

    /// Throws clsdf::Error(invalid_argument) that names the option.
    explicit ComputeRequest(const ComputeOptions& options);

    clsdf::Grid grid_around(const clsdf::Box& box) const;
    clsdf::Band band_on(const clsdf::Grid& samples, const clsdf::Box& box) const;
};

/// The grid, the band and the files of "clsdf compute", once the mesh is known.
struct ComputeLayout {
    const clsdf::Mesh& mesh;
    std::vector<std::string> mesh_files;
    clsdf::Topology topology;
    clsdf::Grid grid;
    clsdf::Band band;
    clsdf::SignRule sign;
    std::optional<double> floor;
    clsdf::Surface surface;
    std::string sign_warning;
    clsdf::OutputSet outputs;
    bool positive_inside;
    clsdf::Polyhedra polyhedra;
    clsdf::Scan scan;
    bool is_sparse;                                   ///< only bricks near the surface are computed and written
    std::shared_ptr<const clsdf::FaceGroups> groups;  ///< null unless they are written
};

/// The result of "clsdf compute".
struct Computation {
    std::string device_name;
    std::string device_platform;
    clsdf::TransformStatistics statistics;
    std::size_t band_samples = 0;
    double read_seconds = 0;
    double setup_seconds = 0;    ///< the device and its context, without its programs
    bool keeps_records = true;   ///< records of program tests are kept: programs are not tested in every process
    double compute_seconds = 0;  ///< until the last slab was computed
    double write_seconds = 0;    ///< for the file; overlaps with computing, but for the last slab
    double field_seconds = 0;    ///< both, from the polyhedra to the complete file
    std::string output;
};

/// Samples strictly within the band's limits: their values differ from those beyond.
std::size_t count_band_samples(const clsdf::FieldDescription& field, const clsdf::FieldSlab& slab);
/// The same of the grid's samples among those of bricks.
std::size_t count_band_samples(const clsdf::FieldDescription& field, const clsdf::SparseSlab& slab);

/// A warning for the user; empty if there is none.
std::string warning_of_polyhedra(const ComputeLayout& layout);
/// A warning if the band is so narrow that a surface made from the field is off.
std::string warning_of_narrow_band(const clsdf::Grid& grid, const clsdf::Band& band, clsdf::SignRule sign);
/// A warning if the box around the mesh is smaller than a voxel, as in another unit.
std::string warning_of_size(const clsdf::Grid& grid, const clsdf::Box& mesh);
/// A warning if the mesh has a sign, and is so thin along an axis that no sample can be inside.
std::string warning_between_samples(const clsdf::Grid& grid, const clsdf::Box& mesh, clsdf::SignRule sign);
/// "no sample lies within the band's limits: the grid reaches from ..., the mesh from ...". nothing: its beginning.
std::string warning_of_nothing(const std::string& nothing, const clsdf::Grid& grid, const clsdf::Box& mesh);
std::string warning_of_memory(const ComputeLayout& layout);
/// Refuses what needs more memory than the machine has, before the work. what: "the links of 9 x 9 x 9 samples".
void require_memory(double bytes, const std::string& what);
/// A warning if the output's format cannot store the band.
std::string warning_of_format(const ComputeLayout& layout, const std::string& output);
std::string warning_of_empty_band(const clsdf::FieldDescription& field, const clsdf::Box& mesh,
                                  std::size_t band_samples);
/// A warning if outputs of an earlier field lie beside this one.
std::string warning_of_stale_outputs(const ComputeLayout& layout, const Computation& computation);

/// Prints the report on standard error.
void print_layout(const ComputeLayout& layout);
void print_memory(const ComputeLayout& layout);
void print_outcome(const ComputeLayout& layout, const Computation& computation);

Json describe_dry_run(const ComputeLayout& layout);
Json describe(const ComputeLayout& layout, const Computation& computation);
