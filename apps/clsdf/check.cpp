#include "check_points.hpp"
#include "command.hpp"
#include "compute.hpp"
#include "option_values.hpp"
#include "outer_surface.hpp"
#include "report.hpp"
#include "scene_file.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>
#include <clsdf/reference.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>

namespace {

using clsdf::reference::CheckReport;

struct Options {
    std::string mesh;
    std::vector<std::string> more;  ///< further files of the mesh, and last the field
    MeshReading reading;
    clsdf::reference::CheckOptions check;
    std::optional<double> floor{};
    std::string surface = "given";
    bool complete = false;
    bool positive_inside = false;
    PointsToCheck points;

    std::vector<std::string> meshes() const { return mesh_files(mesh, more); }
    const std::string& field() const { return more.back(); }
};

Json describe_report(const CheckReport& report, const clsdf::Grid& grid) {
    Json findings = Json::array();
    for (const CheckReport::Finding& finding : report.findings) {
        const auto& [i, j, k] = finding.sample;
        Json described = {{"what", finding.what}, {"sample", finding.sample}, {"position", grid.position(i, j, k)}};
        if (finding.of_distance) described.update({{"expected", finding.expected}, {"found", finding.found}});
        findings.push_back(std::move(described));
    }
    Json wrong_outputs;
    for (const clsdf::OutputInfo& info : extra_outputs()) wrong_outputs[info.name] = report.wrong(info.output);
    return {{"passed", report.passed()},
            {"samples", report.samples},
            {"band_samples", report.band_samples},
            {"wrong_values", report.wrong_values},
            {"wrong_signs", report.wrong_signs},
            {"missed", report.missed},
            {"leaked", report.leaked},
            {"wrong_outputs", wrong_outputs},
            {"max_error_voxels", report.max_error_voxels},
            {"max_error_ulp", report.max_error_ulp},
            {"rms_error_voxels", report.rms_error_voxels},
            {"findings", findings}};
}

// No note for a field that passes: the same mesh may have many names.
std::string note_on_the_mesh(const std::vector<std::string>& mesh, const clsdf::Field& field) {
    const std::string name = std::filesystem::path(field.mesh_name).filename().string();
    if (name.empty() || name == names_of(mesh)) return {};
    // A file's text must not reach the terminal as it is.
    std::string printable = name.substr(0, 80);
    std::ranges::replace_if(
        printable, [](unsigned char letter) { return letter < 0x20 || letter > 0x7E; }, '?');
    return fmt::format("the field says it was made from '{}', and was held against {}", printable, paths_of(mesh));
}

// Fields of other programs may be positive inside: then the negated field has the right sign everywhere.
template <typename Check>
std::string note_on_signs(const Check& check, const CheckReport& report, clsdf::Field field, bool was_said_positive) {
    if (report.wrong_signs * 10 < report.samples * 9 || report.wrong_signs == 0) return {};
    field.negate();
    field.positive_inside = false;
    if (check(field).wrong_signs > 0) return {};
    return was_said_positive ? "all signs are opposite: the field is negative inside; leave out --positive-inside"
                             : "all signs are opposite: positive inside? Check it with --positive-inside; other "
                               "subcommands take the field to be negative inside";
}

// Samples beyond a band that the file does not state have its limits, which are the field's extreme values.
std::string note_on_the_band(const CheckReport& report, const clsdf::Field& field) {
    if (field.band != clsdf::Band::full() || report.findings.empty() || report.wrong_signs > 0) return {};
    const auto [lowest, highest] = std::ranges::minmax(field.distance());
    for (const CheckReport::Finding& finding : report.findings) {
        const double limit = finding.expected < 0 ? lowest : highest;
        const bool is_at_limit = finding.found == limit;
        if (!finding.of_distance || !is_at_limit || std::abs(finding.found) > std::abs(finding.expected)) return {};
    }
    return fmt::format(
        "the first wrong samples have the field's smallest or largest value, {} or {}; if these are the limits of a "
        "band, choose a format that states it, or compute the field with --band full",
        lowest, highest);
}

void print_human(const CheckReport& report, const clsdf::Field& field, bool is_negated, double seconds) {
    print_text("grid      {}\nband      {}\nsign      {}\n", human(field.grid), human(field.band, field.grid.voxel()),
               name_of(field.sign));
    if (is_negated) print_text("values    positive inside in the file, negative inside below\n");
    print_text("looked at {} samples, {} of them within the band's limits, in {:.2f} s\n", report.samples,
               report.band_samples, seconds);
    print_text(
        "error     at most {:.3g} voxels, and {:.3g} ulp (beyond one voxel from the surface); {:.3g} voxels in "
        "the root mean square\n",
        report.max_error_voxels, report.max_error_ulp, report.rms_error_voxels);
    std::string outputs;
    for (const clsdf::OutputInfo& info : extra_outputs())
        if (!field.bytes(info.output).empty())
            outputs += fmt::format(", {} wrong in {}", report.wrong(info.output), info.name);
    print_text("found     {} wrong values, {} wrong signs, {} missed, {} leaked{}\n", report.wrong_values,
               report.wrong_signs, report.missed, report.leaked, outputs);
    for (const CheckReport::Finding& finding : report.findings) {
        const auto& [i, j, k] = finding.sample;
        const clsdf::Vec3 position = field.grid.position(i, j, k);
        const std::string values =
            finding.of_distance ? fmt::format(": {:.9g} instead of {:.9g}", finding.found, finding.expected) : "";
        print_text("  {} at sample ({}, {}, {}), position ({:.9g}, {:.9g}, {:.9g}){}\n", finding.what, i, j, k,
                   position[0], position[1], position[2], values);
    }
    print_text("{}\n", report.passed() ? "passed: the field keeps its contract" : "FAILED");
}

/// What a field is held against: a mesh, which may be the outer surface, or the bodies of a scene where they are.
struct Asked {
    std::vector<clsdf::reference::PlacedBody> bodies;
    bool is_scene = false;
    std::vector<std::string> names;

    CheckReport check(const clsdf::Field& field, const clsdf::reference::CheckOptions& options) const {
        return is_scene ? clsdf::reference::check(bodies, field, options)
                        : clsdf::reference::check(bodies[0].mesh, field, options);
    }
};

/// The same with the outer surface of its mesh, or of the bodies together. Extra outputs tell faces as given.
clsdf::Field make_outer(Asked& asked, const MeshReading& reading, clsdf::Field field, Report& report) {
    if (asked.is_scene)
        asked.bodies = {{outer_of_files(asked.names, reading, {}, {}, {}, report).surface.mesh}};
    else
        asked.bodies[0].mesh = clsdf::outer(asked.bodies[0].mesh, field.sign).mesh;
    asked.is_scene = false;
    for (const clsdf::OutputInfo& info : extra_outputs())
        if (info.output != clsdf::Output::closest && info.output != clsdf::Output::gradient &&
            info.output != clsdf::Output::offset)
            field.resize(info.output, 0);
    return field;
}

// Files do not say which surface was measured.
std::string note_on_the_surface(Asked asked, const MeshReading& reading, const clsdf::Field& field,
                                const clsdf::reference::CheckOptions& options, Report& report) {
    if (!asked.is_scene && describe_topology(asked.bodies[0].mesh).overlapping_parts == 0) return {};
    try {
        const clsdf::Field of_outer = make_outer(asked, reading, field, report);
        if (!asked.check(of_outer, options).passed()) return {};
    } catch (const clsdf::Error&) {
        return {};  // it has no outer surface
    }
    return "the field has the distance to the outer surface: check it with --surface outer";
}

/// Nothing if the mesh and the grid may belong together.
std::string note_on_the_place(const Asked& asked, const clsdf::Grid& grid) {
    clsdf::Box mesh = asked.bodies[0].mesh.box();
    for (const clsdf::reference::PlacedBody& body : asked.bodies)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            mesh.lower[axis] = std::min(mesh.lower[axis], body.mesh.box().lower[axis]);
            mesh.upper[axis] = std::max(mesh.upper[axis], body.mesh.box().upper[axis]);
        }
    const clsdf::Box box = grid.box();
    bool is_apart = false;
    for (std::size_t axis = 0; axis < 3; ++axis)
        is_apart = is_apart || mesh.lower[axis] > box.upper[axis] || mesh.upper[axis] < box.lower[axis];
    constexpr double most = 30;  // of a grid around a part of a mesh, or around much more
    const double ratio = mesh.longest_side() / box.longest_side();
    if (!is_apart && ratio < most && ratio > 1 / most) return {};
    return warning_of_nothing(
        "the field may be of a mesh in another place or unit (--scale, --up, --rotate, "
        "--translate)",
        grid, mesh);
}

/// The mesh of a body where Scene::compute() has it.
clsdf::Mesh placed(clsdf::Mesh mesh, const clsdf::Pose& pose) {
    const auto& [r, t] = pose;
    std::vector<clsdf::Vec3> positions(mesh.vertices().begin(), mesh.vertices().end());
    for (clsdf::Vec3& p : positions) {
        const clsdf::Vec3 x = p;
        for (std::size_t a = 0; a < 3; ++a)
            p[a] = std::fma(r[a][0], x[0], std::fma(r[a][1], x[1], std::fma(r[a][2], x[2], t[a])));
    }
    mesh.set_positions(std::move(positions));
    return mesh;
}

Asked read_bodies(const Options& options, Report& report) {
    Asked asked;
    asked.names = options.meshes();
    asked.is_scene = std::ranges::any_of(asked.names, is_scene_file);
    if (!asked.is_scene) {
        asked.bodies.push_back({read_body(asked.names, options.reading, report)});
        return asked;
    }
    refuse_beside_scene(asked.names, {.floor = options.floor}, {});
    const SceneFile file = read_scene(asked.names.front());
    const SceneMeshes meshes = read_meshes(file, options.reading, report);
    for (std::size_t i = 0; i < file.bodies.size(); ++i) {
        const SceneFile::Body& body = file.bodies[i];
        const clsdf::Mesh& mesh = meshes.meshes[meshes.mesh_of[i]];
        // The mesh as given decides the rule.
        const clsdf::SignRule sign =
            body.of ? asked.bodies[*body.of].sign : resolve_sign_rule(body.sign, describe_topology(mesh)).rule;
        asked.bodies.push_back({placed(mesh, body.pose), sign});
    }
    return asked;
}

ExitStatus run(const Options& options, Report& report) {
    if (options.points.are_given()) {
        std::vector<std::string> files{options.mesh};
        files.insert(files.end(), options.more.begin(), options.more.end());
        return check_points(options.points, files, options.reading, options.positive_inside, options.floor,
                            parse_surface(options.surface), report);
    }
    if (options.more.empty())
        throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                           "FIELD is missing: name the field after the mesh, or give --points and --distances");
    Asked asked = read_bodies(options, report);
    const std::vector<std::string>& meshes = asked.names;
    const bool is_outer = parse_surface(options.surface) == clsdf::Surface::outer;
    clsdf::Field field = clsdf::read_field(options.field());
    if (const std::vector<std::string> missing = clsdf::missing_field_files(options.field()); !missing.empty())
        throw clsdf::Error(
            clsdf::ErrorCode::unreadable_input,
            fmt::format("{}: it names '{}', which cannot be found; copy all files of the field, or compute it again",
                        options.field(), fmt::join(missing, "', '")));
    // Its values are shown as clsdf computes them.
    const bool is_negated = make_negative_inside(field, options.positive_inside, options.field());
    if (options.floor) field.floor = options.floor;
    if (field.sign == clsdf::SignRule::automatic && !asked.is_scene)
        field.sign = resolve_sign_rule(field.sign, describe_topology(asked.bodies[0].mesh)).rule;

    if (is_outer) field = make_outer(asked, options.reading, std::move(field), report);

    clsdf::reference::CheckOptions check_options = options.check;
    if (options.complete) check_options.samples = 0;
    const auto start = std::chrono::steady_clock::now();
    const CheckReport found = asked.check(field, check_options);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;

    std::string note = note_on_signs([&](const clsdf::Field& other) { return asked.check(other, check_options); },
                                     found, field, options.positive_inside);
    if (note.empty() && !found.passed()) note = note_on_the_place(asked, field.grid);
    if (note.empty() && !found.passed() && !is_outer)
        note = note_on_the_surface(asked, options.reading, field, check_options, report);
    if (note.empty() && !found.passed()) note = note_on_the_mesh(meshes, field);
    if (note.empty()) note = note_on_the_band(found, field);
    if (!report.quiet || !found.passed()) print_human(found, field, is_negated, seconds.count());
    if (!note.empty()) print_text("note: {}\n", note);
    report.result = {{"mesh", paths_of(meshes)},     {"field", options.field()},
                     {"grid", describe(field.grid)}, {"band", describe(field.band)},
                     {"sign", name_of(field.sign)},  {"positive_inside", is_negated},
                     {"seed", check_options.seed},   {"tolerance_voxels", check_options.tolerance_voxels},
                     {"seconds", seconds.count()}};
    if (is_outer) report.result["surface"] = options.surface;
    report.result.update(describe_report(found, field.grid));
    if (!note.empty()) report.result["note"] = note;
    return found.passed() ? ExitStatus::done : ExitStatus::check_failed;
}

}  // namespace

Command add_check(Parser& program) {
    const auto options = std::make_shared<Options>();
    Parser parser = program.add_subcommand("check", "Compare a field with the reference, in double precision");
    add_mesh_and_optional_argument(
        parser, options->mesh, "FIELD", options->more,
        "its field, last: .nrrd, .npy, .vti, .vtkhdf, .h5, .vdb, .nvdb or .sdf; none with --points");
    add_floor_option(parser, options->floor);
    add_surface_option(parser, options->surface);
    add_weld_option(parser, options->reading);
    add_skip_option(parser, options->reading);
    parser
        .add("--samples", options->check.samples,
             "samples to check, half of them near the band's limits, edges and vertices")
        .takes_whole_number("N", 1, 1'000'000'000'000'000);
    add_placement_options(parser, options->reading);
    add_field_convention_option(parser, options->positive_inside);
    parser.add("--complete", options->complete, "check every sample").excludes("--samples");
    parser.add("--seed", options->check.seed, "of the random choice of samples")
        .takes_whole_number("N", 0, std::numeric_limits<std::uint64_t>::max());
    parser
        .add("--tolerance-voxels", options->check.tolerance_voxels,
             "an error up to this, or up to 2 ulp, keeps the contract")
        .takes_number_of_0_or_more("X");
    add_options_of_points(parser, options->points);
    parser.set_footer(
        "Prints errors, wrong signs, samples of the band that are missed and samples beyond it that are not filled;\n"
        "the exit status is 1 if there is one.\n"
        "In place of meshes, a file .json has many bodies with poses (docs/scenes.md).\n\n"
        "With --points and --distances it judges what any program found at points, and prints a row of a table.\n\n"
        "Examples:\n"
        "  clsdf check bunny.off bunny.nrrd\n"
        "  clsdf check bunny.off bunny.nrrd --samples 1000000 --seed 7\n"
        "  clsdf check bunny.off bunny.nrrd --complete --json > report.json\n"
        "  clsdf check bunny.off --points particles.npy --distances distances.npy\n"
        "  clsdf check bunny.off --points found.csv --distances found.csv --closest found.csv --tolerance 1e-6");
    return {parser, [options](Report& report) { return run(*options, report); }};
}
