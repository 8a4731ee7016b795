#pragma once

#include <clsdf/version.hpp>

#include <string>

namespace clsdf {

struct Topology;

/// How inside is told from outside; negative is inside.
enum class SignRule {
    automatic,  ///< balanced: nonzero; closed: parity; else unsigned (with a warning for the last two)
    nonzero,    ///< inside where the winding number is not zero; needs a balanced mesh
    parity,     ///< inside where a ray crosses the surface an odd number of times; needs a closed mesh
    none,       ///< no sign: the distance alone
};

/// "auto", "nonzero", "parity", "none".
const char* name_of(SignRule rule);
/// Throws Error(invalid_argument) that lists the names.
SignRule parse_sign_rule(const std::string& text);

/// The rule that will be used, and what the user should be told about it (empty where nothing).
struct ResolvedSignRule {
    SignRule rule = SignRule::none;  ///< never `automatic`
    std::string warning;
};

/// Throws Error(invalid_mesh) with the number of offending edges and the first of them where the mesh cannot honour the
/// rule.
ResolvedSignRule resolve_sign_rule(SignRule asked, const Topology& topology);

}  // namespace clsdf
