#pragma once

#include "io/raw_values.hpp"

#include <string>

namespace clsdf {

/// A .vdb file has no checksums, and a random UUID. Ours have both in one: a UUID that says so and holds a checksum of
/// all other bytes. The same field has the same bytes, and a damaged one is found out before OpenVDB trusts it.

/// Gives a finished file its UUID. Throws std::runtime_error where it cannot be read or written.
void seal_vdb(const std::string& path);

/// Throws Error(unreadable_input) where the file is none, or one of ours and damaged. Returns whether it is ours.
bool check_vdb_seal(InputFile& file);

}  // namespace clsdf
