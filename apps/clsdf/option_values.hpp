#pragma once

#include "options.hpp"
#include "report.hpp"

#include <clsdf/error.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/outputs.hpp>
#include <clsdf/topology.hpp>

#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// The known word that was probably meant: one that begins with the word, or else the nearest one. Empty if none is
/// near.
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);

/// "; did you mean WORD?", or nothing if there is no word.
std::string did_you_mean(const std::string& word);

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
/// The files of the mesh among these two.
std::vector<std::string> mesh_files(const std::string& mesh, const std::vector<std::string>& more);

/// The mesh of all files. Warnings say what was skipped or changed.
clsdf::Mesh read_body(const std::vector<std::string>& files, Report& report);
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

/// The outputs of --with.
clsdf::OutputSet parse_outputs(const std::vector<std::string>& names);
/// All outputs but the distance.
std::span<const clsdf::OutputInfo> extra_outputs();
/// Adds --with and --sign.
void add_outputs_option(Parser& parser, std::vector<std::string>& names);
void add_sign_option(Parser& parser, std::string& rule);
clsdf::SignRule parse_sign(const std::string& rule);

/// More than the samples of any grid along an axis.
inline constexpr std::uint64_t most_samples_on_a_side = std::uint64_t{1} << 30;
