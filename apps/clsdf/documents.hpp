#pragma once

#include "options.hpp"

#include <string>
#include <vector>

/// An option or an argument by its definition, for manual page, completions and tables.
struct OptionDescription {
    std::vector<std::string> names;  ///< "-o", "--output"; empty for an argument
    std::string takes;               ///< "FILE", "x|y|z"; empty for a flag
    std::string text;                ///< one line, without a full stop
    std::string default_text;        ///< empty if there is none
    std::string usage;               ///< in the usage line: "-o FILE", "MESH...", "[MESH...]"; empty for other options
    bool repeats = false;            ///< an argument that may come several times, the last one

    std::vector<std::string> words;    ///< the possible values, if they are known
    bool is_file = false;              ///< otherwise
    std::vector<std::string> endings;  ///< of the file, with the dot; empty if any will do

    bool is_flag() const { return takes.empty(); }
    /// The longest name, or for an argument its type.
    const std::string& name() const { return names.empty() ? takes : names.back(); }
};

struct OptionGroup {
    std::string title;
    std::vector<OptionDescription> options;
};

struct SubcommandDescription {
    std::string name;  ///< "clsdf" for the program itself
    std::string text;
    std::vector<OptionDescription> arguments;
    std::vector<OptionGroup> groups;       ///< of options
    std::vector<std::string> explanation;  ///< paragraphs
    std::vector<std::string> examples;     ///< lines for a shell

    /// The options of all groups.
    std::vector<OptionDescription> options() const;
};

struct ProgramDescription {
    SubcommandDescription program;
    std::vector<SubcommandDescription> subcommands;  ///< those that the help page lists
};

ProgramDescription describe(const Parser& program);

/// A manual page, in the macros of man(7).
struct ManualPage {
    std::string file;  ///< "clsdf-compute.1"
    std::string text;
};

/// One page for the program and one for each subcommand.
std::vector<ManualPage> manual_pages(const ProgramDescription& description);

/// Scripts that complete subcommands, options, words and names of files: the files "clsdf", "_clsdf" and "clsdf.fish"
/// in the shells' folders.
std::string bash_completion(const ProgramDescription& description);
std::string zsh_completion(const ProgramDescription& description);
std::string fish_completion(const ProgramDescription& description);

/// The document with the table of options of each subcommand between "<!-- options of NAME -->" and "<!-- end of
/// options -->", as Markdown. Throws clsdf::Error if a subcommand has no marks, or marks have no subcommand.
std::string with_option_tables(const std::string& document, const ProgramDescription& description);
