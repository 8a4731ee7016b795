#pragma once

#include <clsdf/error.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/outputs.hpp>
#include <clsdf/topology.hpp>

#include <CLI/CLI.hpp>

#include <array>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

/// The known word that was probably meant: one that begins with the word, or else the nearest one. Empty if none is
/// near.
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);

/// "; did you mean WORD?", or nothing if there is no word.
std::string did_you_mean(const std::string& word);

// An option's type name, or an argument's name, states its values. Small letters are literal, "x|y|z"; capitals are
// placeholders. Those of file_placeholders are files with the endings that the description names: "the mesh: .off,
// .obj, .stl or .ply". SHAPE is a name of "clsdf shape --list".

inline constexpr std::array file_placeholders{"MESH", "FIELD", "PICTURE", "POINTS", "RESULT", "FILE"};

/// The value must be one of the words, which become the type name. The error for another one names the nearest.
void takes_one_of(CLI::Option* option, const std::vector<std::string>& words);
/// The same for an option that takes several, separated by commas.
void takes_some_of(CLI::Option* option, const std::vector<std::string>& words);

/// Conditions on the text of an option's value. They are checked before the conversion, so that the message quotes the
/// text, and neither "1e3" nor "-1" becomes another number. whole_number() is for transform(): it removes leading
/// zeros, which CLI11 would take for the mark of octal digits.
CLI::Validator whole_number(std::uint64_t least, std::uint64_t most);
CLI::Validator finite_number_of_0_or_more();
/// An empty text would count as an absent option.
CLI::Validator not_empty();
/// Not empty, and not "-": a file's ending chooses its format, and no incomplete file may appear.
CLI::Validator file_name();

/// Throws Error(invalid_argument) if the output is the input under this or another name. `what` is "mesh".
void keep_input(const std::string& input, const std::string& output, const std::string& what);

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
clsdf::Outputs parse_outputs(const std::vector<std::string>& names);
/// Adds --with and --sign.
CLI::Option* add_outputs_option(CLI::App& parser, std::vector<std::string>& names);
CLI::Option* add_sign_option(CLI::App& parser, std::string& rule);
clsdf::SignRule parse_sign(const std::string& rule);

/// "10%", "3v", "0.05" or "full". Throws Error(invalid_argument) that names the option and quotes the text.
clsdf::Length parse_length(const std::string& option, const std::string& text);

/// More than the samples of any grid along an axis.
inline constexpr std::uint64_t most_samples_on_a_side = std::uint64_t{1} << 30;
