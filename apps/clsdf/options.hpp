#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

/// These words are files with the endings that the description names: "the mesh: .off, .obj, .stl or .ply". The name of
/// a file must not be empty, nor "-": its ending chooses its format, and no incomplete file may appear.
inline constexpr std::array file_placeholders{"MESH", "FIELD", "PICTURE", "POINTS", "RESULT", "FILE"};

/// An option or an argument of a Parser.
///
/// `placeholder` states the option's values on the help page. Small letters are literal, "x|y|z"; capitals are
/// placeholders. SHAPE is a name of "clsdf shape --list".
///
/// Values are checked as text before they are converted, so that a message quotes the text, and neither "1e3" nor "-1"
/// becomes another number.
class Option {
public:
    explicit Option(CLI::Option* option) : option_(option) {}

    Option& takes(const std::string& placeholder);
    /// The same, and the text must not be empty, which would count as an absent option.
    Option& takes_text(const std::string& placeholder);
    Option& takes_whole_number(const std::string& placeholder, std::uint64_t least, std::uint64_t most);
    /// A finite number.
    Option& takes_number(const std::string& placeholder);
    Option& takes_number_of_0_or_more(const std::string& placeholder);
    Option& takes_number_of_0_to_infinity(const std::string& placeholder);
    Option& takes_number_above_0(const std::string& placeholder);
    /// The value must be one of the words, which become the placeholder. The error for another one names the nearest.
    Option& takes_one_of(const std::vector<std::string>& words);
    /// The same for several words, separated by commas.
    Option& takes_some_of(const std::vector<std::string>& words);
    Option& separated_by_commas();

    Option& required();
    /// The usage line has it as if it was required. text: instead of the name of an argument, "MESH..."
    Option& in_usage(const std::string& text = {});
    /// The other option, "--all", is added before this one.
    Option& needs(const std::string& other);
    Option& excludes(const std::string& other);

    std::vector<std::string> names() const;  ///< "-o", "--output"; empty for an argument
    std::string placeholder() const;  ///< empty for a flag; an argument has one beside its name if it takes words
    std::string takes() const;        ///< the placeholder, or the name of an argument
    std::string text() const;
    std::string default_text() const;  ///< empty if there is none
    std::string group() const;
    bool is_required() const;
    /// What the usage line has: "-o FILE", "MESH...", "[SUBCOMMAND]"; empty for other options.
    std::string usage() const;
    bool repeats() const;  ///< an argument that may come several times

private:
    CLI::Option* option_;
};

/// The options and arguments of the program or of a subcommand. Copies are the same parser.
class Parser {
public:
    /// The program's parser. Every parser has --help.
    Parser(const std::string& name, const std::string& text);

    /// Adds a subcommand, one of which the program then requires.
    Parser add_subcommand(const std::string& name, const std::string& text);
    void add_version(const std::string& version, const std::string& text);

    /// Adds an option, "-o,--output"; an argument, "MESH"; or, if the value is a bool, a flag. Parsing sets the value.
    /// Its value until then is the default on the help page, if it is a number or text that is not empty. An option of
    /// several values is repeated, or takes them separated by commas. The types of values are listed in options.cpp.
    template <class Value>
    Option add(const std::string& names, Value& value, const std::string& text);
    /// The title on the help page of the options that are added from now on; "Options" at first.
    void begin_group(const std::string& title);
    /// The footer of the help page. Up to a line "Examples:" it is an explanation, the lines after it are examples.
    void set_footer(const std::string& footer);
    /// No page lists this subcommand.
    void hide();

    /// Returns the page or the version that the command line asks for, if it does. Throws
    /// clsdf::Error(invalid_argument) that names the nearest known word if one is unknown.
    std::optional<std::string> parse(int argument_count, const char* const* arguments);
    /// Whether the command line has this subcommand, or this option.
    bool is_chosen() const;
    bool has(const std::string& option) const;

    std::string help() const;
    std::string name() const;
    std::string text() const;
    std::string footer() const;
    std::vector<Option> options() const;  ///< with the arguments
    /// Those that pages list.
    std::vector<Parser> subcommands() const;

private:
    explicit Parser(std::shared_ptr<CLI::App> parser) : parser_(std::move(parser)) {}

    std::string full_name() const;  ///< "clsdf compute"

    std::shared_ptr<CLI::App> parser_;
};
