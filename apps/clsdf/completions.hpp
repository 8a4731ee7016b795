#pragma once

#include "description.hpp"

#include <string>

/// Scripts that complete subcommands, options, words and names of files, for "clsdf", "_clsdf" and "clsdf.fish" in the
/// folders where the shells look for them.
std::string bash_completion(const ProgramDescription& description);
std::string zsh_completion(const ProgramDescription& description);
std::string fish_completion(const ProgramDescription& description);
