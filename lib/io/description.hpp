#pragma once

#include <clsdf/field.hpp>

#include <map>
#include <optional>
#include <string>

namespace clsdf {

/// The properties of a field for which most formats have no fields of their own, as the text of a JSON object. Its
/// members:
///   "origin", "spacing", "size"   of the samples: three numbers along x, y, z; the origin is the first sample
///   "lattice": {"origin", "first"}  if the samples are a part of a lattice, as in Grid
///   "band": {"inside", "outside"}   in the mesh's units; null if infinite
///   "sign", "mesh", "program"
///   "triangle"                      the name of the file beside it, if the output is in one; so for each output
struct Description {
    Field field;                               ///< without its arrays
    std::map<std::string, std::string> files;  ///< by the names of outputs
};

std::string description_text(const FieldDescription& field, const std::map<std::string, std::string>& files = {});

/// The sidecar of an .npy file, "bunny.npy.json". Only origin, spacing and size are needed.
/// Throws Error(unreadable_input), or Error(invalid_argument) if a value makes no sense.
Description read_description(const std::string& path);

/// The text in a file whose header states its grid: the members origin, spacing and size are ignored. `source` names
/// the file and the part of it that holds the text.
Description parse_description(const std::string& source, const std::string& text, const Grid& stated);

/// The rule of that name. Throws Error(invalid_argument) that lists the names.
SignRule sign_rule_of(const std::string& text);

/// The same for a file that states no size; null if the text states none either.
std::optional<Index3> described_size(const std::string& source, const std::string& text);

}  // namespace clsdf
