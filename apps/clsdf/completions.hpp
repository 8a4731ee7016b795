#pragma once

#include "description.hpp"

#include <string>

/// Scripts that complete subcommands, options, words and names of files: the files "clsdf", "_clsdf" and "clsdf.fish"
/// in the shells' folders.
std::string bash_completion(const ProgramDescription& description);
std::string zsh_completion(const ProgramDescription& description);
std::string fish_completion(const ProgramDescription& description);
