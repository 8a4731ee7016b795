#include "option_values.hpp"

#include "core/files.hpp"

#include <clsdf/mesh_files.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

void keep_input(const std::string& input, const std::string& output, const std::string& what) {
    std::error_code ignored;
    if (std::filesystem::equivalent(input, output, ignored))
        throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                           fmt::format("-o '{}' is the {} that is read; name another file", output, what));
}

void keep_mesh(const std::vector<std::string>& files, const std::string& output) {
    for (const std::string& file : files) keep_input(file, output, "mesh");
}

namespace {

constexpr const char* mesh_text = "the mesh: .off, .obj, .stl or .ply; several files are one body";

std::string joined(const std::vector<std::string>& files, bool with_folders) {
    std::string text;
    for (const std::string& file : files)
        text += (text.empty() ? "" : " + ") + (with_folders ? file : std::filesystem::path(file).filename().string());
    return text;
}

}  // namespace

void add_mesh_argument(Parser& parser, std::vector<std::string>& files) {
    parser.add("MESH", files, mesh_text).required();
}

void add_mesh_and_argument(Parser& parser, std::string& mesh, const std::string& name, std::vector<std::string>& more,
                           const std::string& text) {
    parser.add("MESH", mesh, mesh_text).required().in_usage("MESH...");
    parser.add(name, more, text).required().in_usage(name);
}

void add_mesh_and_optional_argument(Parser& parser, std::string& mesh, const std::string& name,
                                    std::vector<std::string>& more, const std::string& text) {
    parser.add("MESH", mesh, mesh_text).required().in_usage("MESH...");
    parser.add(name, more, text).in_usage(name);
}

std::vector<std::string> mesh_files(const std::string& mesh, const std::vector<std::string>& more) {
    std::vector<std::string> files{mesh};
    files.insert(files.end(), more.begin(), more.end() - 1);
    return files;
}

bool is_scene_file(const std::string& file) {
    return clsdf::ending_of(file) == ".json";
}

std::string paths_of(const std::vector<std::string>& files) {
    return joined(files, true);
}

std::string names_of(const std::vector<std::string>& files) {
    return joined(files, false);
}

clsdf::Error with_file(const clsdf::Error& error, std::string_view subject, const std::string& file) {
    if (!std::string_view(error.what()).starts_with(subject)) return error;
    const bool is_refused = error.code() == clsdf::ErrorCode::invalid_argument;
    return {is_refused ? clsdf::ErrorCode::unreadable_input : error.code(), fmt::format("{}: {}", file, error.what())};
}

void add_placement_options(Parser& parser, MeshReading& reading) {
    parser.add("--scale", reading.scale, "factor of the mesh's coordinates, such as 0.001 from millimetres to metres")
        .takes_number_above_0("FACTOR");
    parser.add("--up", reading.up, "the axis of the file that points up; the mesh gets z up")
        .takes_one_of({"x", "y", "z", "-x", "-y", "-z"});
    parser.add("--rotate", reading.rotate, "degrees about x, then y, then z, after --scale and --up")
        .takes_text("X,Y,Z");
    parser.add("--translate", reading.translate, "added to the coordinates after that").takes_text("X,Y,Z");
}

void add_group_option(Parser& parser, MeshReading& reading) {
    parser.add("--group-by", reading.group_by, "the property of a .ply file's faces that is the name of their group")
        .takes_text("NAME");
}

void add_hits_option(Parser& parser, std::string& hits) {
    parser
        .add("--hits", hits,
             "walls, where inside and outside meet, or all faces as given, also of a mesh without a sign")
        .takes_one_of({"walls", "faces"});
}

clsdf::Hits parse_hits(const std::string& hits) {
    return hits == "faces" ? clsdf::Hits::faces : clsdf::Hits::walls;
}

void add_skip_option(Parser& parser, MeshReading& reading) {
    parser.add("--skip-bad-facets", reading.skip_bad_facets,
               "leave out faces of a vertex that is not finite or does not exist");
}

void add_weld_option(Parser& parser, MeshReading& reading) {
    parser
        .add("--weld", reading.weld, "join vertices that are so near to each other, in the mesh's units or in percent")
        .takes_text("LENGTH");
}

namespace {

clsdf::ReadOptions read_options(const MeshReading& reading) {
    clsdf::ReadOptions options;
    options.scale = reading.scale;
    options.skip_bad_facets = reading.skip_bad_facets;
    options.up = reading.up;
    options.group_by = reading.group_by;
    if (!reading.rotate.empty())
        options.rotate = parse_triple<double>("--rotate", reading.rotate, "three angles, as 90,0,0", false);
    if (!reading.translate.empty())
        options.translate = parse_triple<double>("--translate", reading.translate, "three numbers, as -1,-1,0", false);
    return options;
}

clsdf::Mesh welded(clsdf::Mesh mesh, const std::string& length,
                   const std::function<void(const std::string& message)>& warn) {
    if (length.empty()) return mesh;
    const clsdf::Length within = clsdf::Length::parse(length, "--weld");
    if (within.unit == clsdf::Length::Unit::voxels || within.is_infinite())
        throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                           "--weld: '" + length +
                               "' is no length of the mesh; give one in its units, as 1e-6, or in percent of its "
                               "longest side, as 0.0001%");
    try {
        clsdf::Mesh joined = weld(mesh, within.resolve(0, mesh.box().longest_side()));
        const std::string warning = describe_weld(mesh, joined).warning;
        if (!warning.empty()) warn(fmt::format("--weld {}: {}", length, warning));
        return joined;
    } catch (const clsdf::Error& error) {
        throw clsdf::Error(error.code(), fmt::format("--weld: '{}': {}", length, error.what()));
    }
}

}  // namespace

std::size_t parse_bytes(const std::string& option, const std::string& text) {
    double number = 0;
    const auto [stop, error] = clsdf::read_number(text.data(), text.data() + text.size(), number);
    const std::string_view unit(stop, static_cast<std::size_t>(text.data() + text.size() - stop));
    constexpr std::string_view letters = "KMGT";
    const std::size_t power = unit.empty() ? 0 : letters.find(unit.front()) + 1;
    const bool is_binary = unit.size() == 3 && unit.ends_with("iB");
    const bool is_decimal = unit.size() == 1 || (unit.size() == 2 && unit.ends_with("B"));
    const bool is_unit = unit.empty() || (power > 0 && (is_decimal || is_binary));
    const double bytes = number * std::pow(is_binary ? 1024.0 : 1000.0, static_cast<double>(power));
    if (error != std::errc() || !is_unit || !(bytes >= 1 && bytes < 1e18))
        throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                           fmt::format("{}: expected a number of bytes, as 512M, 2GB or 2GiB, not '{}'", option, text));
    return static_cast<std::size_t>(bytes);
}

clsdf::Mesh read_body(const std::vector<std::string>& files, const MeshReading& reading,
                      const std::function<void(const std::string& message)>& warn) {
    for (const std::string& file : files)
        if (is_scene_file(file))
            throw clsdf::Error(
                clsdf::ErrorCode::unsupported,
                fmt::format("'{}' is a scene of many bodies, which \"clsdf query\", \"compute\", \"check\", \"outer\" "
                            "and \"fractions\" take, in place of all meshes; elsewhere give one mesh",
                            file));
    clsdf::ReadOptions options = read_options(reading);
    options.log = warn;
    return welded(clsdf::read_meshes(files, options), reading.weld, warn);
}

clsdf::OutputSet parse_outputs(const std::vector<std::string>& names) {
    clsdf::OutputSet outputs;
    for (const clsdf::OutputInfo& info : extra_outputs())
        if (std::find(names.begin(), names.end(), info.name) != names.end()) outputs.insert(info.output);
    if (std::find(names.begin(), names.end(), group_word) != names.end()) outputs.insert(clsdf::Output::triangle);
    return outputs;
}

bool wants_groups(const std::vector<std::string>& names, const clsdf::Mesh& mesh) {
    if (std::find(names.begin(), names.end(), group_word) == names.end()) return false;
    if (mesh.groups().empty())
        throw clsdf::Error(
            clsdf::ErrorCode::invalid_argument,
            fmt::format("--with group: {} has no groups; name them in the file (\"solid NAME\" of a .stl "
                        "in ASCII, \"g\" or \"o\" of an .obj), state the property of a .ply with "
                        "--group-by, or give a file for each",
                        mesh.name()));
    return true;
}

std::span<const clsdf::OutputInfo> extra_outputs() {
    return clsdf::output_table().subspan(1);
}

namespace {

std::vector<std::string> output_words() {
    std::vector<std::string> words;
    for (const clsdf::OutputInfo& info : extra_outputs()) words.emplace_back(info.name);
    return words;
}

}  // namespace

void add_outputs_option(Parser& parser, std::vector<std::string>& names) {
    parser.add("--with", names, "further outputs beside the distance").takes_some_of(output_words());
}

void add_outputs_and_groups_option(Parser& parser, std::vector<std::string>& names) {
    std::vector<std::string> words = output_words();
    words.emplace_back(group_word);
    parser.add("--with", names, "further outputs beside the distance; group: that of the triangle")
        .takes_some_of(words);
}

void add_wall_groups_option(Parser& parser, std::vector<std::string>& names) {
    parser.add("--with", names, "group: that of the triangle, too").takes_one_of({group_word});
}

void add_sign_options(Parser& parser, SignChoice& choice) {
    parser.add("--sign", choice.rule, "the rule that decides what is inside; below: of a terrain; none: no sign")
        .takes_one_of({"auto", "nonzero", "parity", "solid-angle", "below", "none"});
    add_floor_option(parser, choice.floor);
}

void add_sign_option_of_outer(Parser& parser, SignChoice& choice) {
    parser.add("--sign", choice.rule, "the rule that decides what is inside")
        .takes_one_of({"auto", "nonzero", "parity"});
}

void add_surface_option(Parser& parser, std::string& surface) {
    parser.add("--surface", surface, "outer: without faces within other parts, as clsdf outer writes it")
        .takes_one_of({"given", "outer"});
}

void require_sign(clsdf::SignRule in_use, const clsdf::Topology& topology, const std::vector<std::string>& files,
                  const SignChoice& choice, const std::string& what, const std::string& instead) {
    if (in_use != clsdf::SignRule::none) return;
    std::vector<std::string> remedies;
    if (!instead.empty()) remedies.push_back(instead);
    if (choice.rule == name_of(clsdf::SignRule::none)) {
        remedies.emplace_back("choose another --sign");
    } else {
        if (topology.rim_loops > 0 && topology.overlapping_rim_edges == 0)
            remedies.emplace_back("close the terrain by --sign below --floor Z");
        else if (topology.inside_points > 0 && 3 * topology.doubtful_points <= topology.tested_points)
            remedies.emplace_back("choose --sign solid-angle");
        else
            remedies.emplace_back("close its surface");
    }
    throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                       fmt::format("{}: the mesh has no sign with --sign {}, and {} one: {}", paths_of(files),
                                   choice.rule, what, fmt::join(remedies, ", or ")));
}

void add_floor_option(Parser& parser, std::optional<double>& floor) {
    parser.add("--floor", floor, "z of the floor of --sign below, to which walls go down from the terrain's rim")
        .takes_number("Z");
}

void add_positive_inside_option(Parser& parser, bool& positive_inside) {
    parser.add("--positive-inside", positive_inside,
               "distances and gradients are negated when they are written, also zeros and limits");
}

void add_field_convention_option(Parser& parser, bool& positive_inside) {
    parser.add("--positive-inside", positive_inside,
               "the field's distances are positive inside, if the file does not say so");
}

bool make_negative_inside(clsdf::Field& field, bool positive_inside, const std::string& path) {
    if (positive_inside && field.sign == clsdf::SignRule::none)
        throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                           fmt::format("--positive-inside: {} has no sign; leave the option out", path));
    const bool is_negated = field.positive_inside || positive_inside;
    if (is_negated) field.negate();
    field.positive_inside = false;
    return is_negated;
}

clsdf::Surface parse_surface(const std::string& surface) {
    return value_named(surface, {clsdf::Surface::given, clsdf::Surface::outer});
}

clsdf::TransformOptions transform_options_of(const SignChoice& choice) {
    clsdf::TransformOptions options;
    options.sign = parse_sign(choice);
    options.floor = choice.floor;
    options.surface = parse_surface(choice.surface);
    return options;
}

clsdf::SignRule parse_sign(const SignChoice& choice) {
    using clsdf::SignRule;
    const SignRule rule = value_named(choice.rule, {SignRule::automatic, SignRule::nonzero, SignRule::parity,
                                                    SignRule::solid_angle, SignRule::below, SignRule::none});
    if (rule == SignRule::below && !choice.floor)
        throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                           "--sign below needs --floor Z, below the terrain: walls go down to it from the rim");
    if (rule != SignRule::below && choice.floor)
        throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                           fmt::format("--floor {} is for --sign below, and this is --sign {}; leave it out, or choose "
                                       "--sign below",
                                       *choice.floor, choice.rule));
    return rule;
}
