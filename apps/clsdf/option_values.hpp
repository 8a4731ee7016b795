#pragma once

#include <CLI/CLI.hpp>

#include <cstdint>

/// What the text of an option's value must be. Held against the text before it is converted, so that the message names
/// what was typed, and neither "1e3" nor "-1" becomes another number.
CLI::Validator whole_number(std::uint64_t least, std::uint64_t most);
CLI::Validator finite_number_of_0_or_more();
/// An empty text would pass for an option that is not there.
CLI::Validator not_empty();

/// Beyond what any grid has along an axis.
inline constexpr std::uint64_t most_samples_on_a_side = std::uint64_t{1} << 30;
