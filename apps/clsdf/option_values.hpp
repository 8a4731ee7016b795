#pragma once

#include "options.hpp"
#include "report.hpp"

#include "core/real_numbers.hpp"

#include <clsdf/error.hpp>
#include <clsdf/field.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/mesh_files.hpp>
#include <clsdf/outputs.hpp>
#include <clsdf/segments.hpp>
#include <clsdf/topology.hpp>

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Throws Error(invalid_argument) if the output is the input under this or another name. `what` is "mesh".
void keep_input(const std::string& input, const std::string& output, const std::string& what);

/// The same for the files of a mesh.
void keep_mesh(const std::vector<std::string>& files, const std::string& output);

/// Adds the argument MESH: one file, or several of one body.
void add_mesh_argument(Parser& parser, std::vector<std::string>& files);
/// Adds MESH and another argument, the last one of the command line; further files of the mesh may come between them.
/// `more` gets what follows MESH.
void add_mesh_and_argument(Parser& parser, std::string& mesh, const std::string& name, std::vector<std::string>& more,
                           const std::string& text);
/// The same, and the other argument may be left out: then `more` has further files of the mesh, or nothing.
void add_mesh_and_optional_argument(Parser& parser, std::string& mesh, const std::string& name,
                                    std::vector<std::string>& more, const std::string& text);
/// The files of the mesh among these two.
std::vector<std::string> mesh_files(const std::string& mesh, const std::vector<std::string>& more);

/// Whether a name ends like that of a file of many bodies: .json.
bool is_scene_file(const std::string& file);

/// How the files of a mesh are read: its unit, axes and place, bad facets, vertices that are joined, groups.
struct MeshReading {
    double scale = 1;
    std::string up = "z";
    std::string rotate;
    std::string translate;
    bool skip_bad_facets = false;
    std::string weld;
    std::string group_by;

    /// Whether something is not as usual.
    bool is_told() const {
        return scale != 1 || up != "z" || !rotate.empty() || !translate.empty() || skip_bad_facets || !weld.empty() ||
               !group_by.empty();
    }
};
/// Adds --scale, --up, --rotate and --translate.
void add_placement_options(Parser& parser, MeshReading& reading);
void add_skip_option(Parser& parser, MeshReading& reading);
void add_group_option(Parser& parser, MeshReading& reading);

/// Adds --hits, where segments and rays meet the surface: "walls" or "faces".
void add_hits_option(Parser& parser, std::string& hits);
clsdf::Hits parse_hits(const std::string& hits);

/// "a.stl + b.stl", with or without folders.
std::string paths_of(const std::vector<std::string>& files);
std::string names_of(const std::vector<std::string>& files);

/// If the message begins with the subject, returns the error with the file's name before the message, and with
/// unreadable_input in place of invalid_argument. Otherwise returns it unchanged. The library names a point by its
/// number, and a field by "field: ".
clsdf::Error with_file(const clsdf::Error& error, std::string_view subject, const std::string& file);

/// The value whose name_of() is the text. The words that the option takes are their names.
template <class Value>
Value value_named(const std::string& text, std::initializer_list<Value> values) {
    for (const Value value : values)
        if (text == name_of(value)) return value;
    throw clsdf::Error(clsdf::ErrorCode::invalid_argument, "'" + text + "' is not among the option's words");
}

/// "1,2,3" -> three numbers; nothing for any other text.
template <class Number>
std::optional<std::vector<Number>> parse_list(const std::string& text) {
    std::vector<Number> numbers;
    const char* position = text.data();
    const char* const end = text.data() + text.size();
    while (true) {
        Number number{};
        const auto [stop, error] = clsdf::read_number(position, end, number);
        if (error != std::errc()) return std::nullopt;
        numbers.push_back(number);
        if (stop == end) return numbers;
        if (*stop != ',') return std::nullopt;
        position = stop + 1;
    }
}

/// Throws Error(invalid_argument) that names the option and what it expects.
template <class Number>
std::array<Number, 3> parse_triple(const std::string& option, const std::string& text, const std::string& expected,
                                   bool one_for_all) {
    const auto numbers = parse_list<Number>(text);
    if (numbers && numbers->size() == 3) return {(*numbers)[0], (*numbers)[1], (*numbers)[2]};
    if (numbers && numbers->size() == 1 && one_for_all) return {(*numbers)[0], (*numbers)[0], (*numbers)[0]};
    throw clsdf::Error(clsdf::ErrorCode::invalid_argument,
                       fmt::format("{}: expected {}, not '{}'", option, expected, text));
}

/// A number of bytes: "512M", "2GB", "1.5G", "2GiB"; K and KB, M, G and T are powers of 1000, KiB and so on of 1024.
/// Throws Error(invalid_argument) that names the option.
std::size_t parse_bytes(const std::string& option, const std::string& text);

/// The mesh of all files, with its vertices joined. Warnings say what was skipped or changed. Throws
/// Error(invalid_argument) that names the option.
clsdf::Mesh read_body(const std::vector<std::string>& files, const MeshReading& reading,
                      const std::function<void(const std::string& message)>& warn);
inline clsdf::Mesh read_body(const std::vector<std::string>& files, const MeshReading& reading, Report& report) {
    return read_body(files, reading, [&](const std::string& message) { report.warn(message); });
}

/// The outputs of --with. Groups follow from the triangle.
clsdf::OutputSet parse_outputs(const std::vector<std::string>& names);
/// Whether --with asks for groups. Throws Error(invalid_argument) if it does and the mesh has none.
bool wants_groups(const std::vector<std::string>& names, const clsdf::Mesh& mesh);
inline constexpr const char* group_word = "group";
/// All outputs but the distance.
std::span<const clsdf::OutputInfo> extra_outputs();
/// Adds --with and --sign.
void add_outputs_option(Parser& parser, std::vector<std::string>& names);
/// The same with the word "group".
void add_outputs_and_groups_option(Parser& parser, std::vector<std::string>& names);
/// --with of segments and rays, whose only word is "group".
void add_wall_groups_option(Parser& parser, std::vector<std::string>& names);
/// The sign rule by its name, the floor of the rule `below`, and the surface by its name.
struct SignChoice {
    std::string rule = "auto";
    std::optional<double> floor{};
    std::string surface = "given";
};
void add_sign_options(Parser& parser, SignChoice& choice);
/// Adds --sign with the rules that an outer surface can have.
void add_sign_option_of_outer(Parser& parser, SignChoice& choice);
/// Adds --surface.
void add_surface_option(Parser& parser, std::string& surface);
/// Throws Error(invalid_argument) if the rule in use is `none`: `what` needs a sign ("--hits walls"). It names the
/// mesh, --sign and options that help, of which `instead` ("choose --hits faces") may be empty.
void require_sign(clsdf::SignRule in_use, const clsdf::Topology& topology, const std::vector<std::string>& files,
                  const SignChoice& choice, const std::string& what, const std::string& instead);
void add_floor_option(Parser& parser, std::optional<double>& floor);
void add_positive_inside_option(Parser& parser, bool& positive_inside);
/// Adds --positive-inside for a field that is read.
void add_field_convention_option(Parser& parser, bool& positive_inside);
/// Negates the field if it is positive inside, as its file or the option says, and returns whether. Throws
/// Error(invalid_argument) if the option is given for a field without a sign.
bool make_negative_inside(clsdf::Field& field, bool positive_inside, const std::string& path);
clsdf::SignRule parse_sign(const SignChoice& choice);
clsdf::Surface parse_surface(const std::string& surface);
/// All of the choice.
clsdf::TransformOptions transform_options_of(const SignChoice& choice);

void add_weld_option(Parser& parser, MeshReading& reading);

/// More than the samples of any grid along an axis.
inline constexpr std::uint64_t most_samples_on_a_side = std::uint64_t{1} << 30;
