#pragma once

#include <clsdf/field.hpp>

#include <map>
#include <optional>
#include <string>

namespace clsdf {

/// What most formats have no words for, as the text of a JSON object. Its members:
///   "origin", "spacing", "size"   of the samples: three numbers along x, y, z; the origin is the first sample
///   "lattice": {"origin", "first"}  where the samples are a part of a grid, as of Grid
///   "band": {"inside", "outside"}   in the mesh's units; null where infinite
///   "sign", "mesh", "program"
///   "triangle"                      the name of the file beside it, where the output is in one; so for each output
struct Description {
    Field field;                               ///< without its arrays
    std::map<std::string, std::string> files;  ///< by the names of outputs
};

std::string description_text(const FieldDescription& field, const std::map<std::string, std::string>& files = {});

/// The sidecar of an .npy file, "bunny.npy.json". Only origin, spacing and size are needed.
/// Throws Error(unreadable_input), or Error(invalid_argument) where a value makes no sense.
Description read_description(const std::string& path);

/// The text in a file that says by itself where its samples lie: of the members above, origin, spacing and size are not
/// looked at. `source` names the file, and what of it the text is.
Description parse_description(const std::string& source, const std::string& text, const Grid& stated);

/// The rule of that name. Throws Error(invalid_argument) that lists the names.
SignRule sign_rule_of(const std::string& text);

/// The same for a file that states no size; null where the text does not either.
std::optional<Index3> described_size(const std::string& source, const std::string& text);

}  // namespace clsdf
