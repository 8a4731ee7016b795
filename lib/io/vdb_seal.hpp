#pragma once

#include "io/raw_values.hpp"

#include <string>

namespace clsdf {

/// A .vdb file has a random UUID and no checksum. clsdf writes a UUID that identifies clsdf and holds a checksum of all
/// other bytes. So the same field has the same bytes, and a damaged file is detected before OpenVDB reads it.

/// Gives a finished file its UUID. Throws std::runtime_error if it cannot be read or written.
void seal_vdb(const std::string& path);

/// Throws Error(unreadable_input) if the file is no .vdb file, or if clsdf wrote it and it is damaged. Returns whether
/// clsdf wrote it.
bool check_vdb_seal(InputFile& file);

}  // namespace clsdf
