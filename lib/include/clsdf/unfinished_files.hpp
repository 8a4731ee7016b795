#pragma once

#include <clsdf/version.hpp>

namespace clsdf {

/// For a program that is about to end in the middle of its work, on Ctrl-C for instance: removes what the files that
/// are being written have under temporary names, in every thread, and lets none of them get its own name any more. A
/// thread that goes on to write waits for ever, so the program must end now. May be called from any thread, but not
/// from a signal handler.
void abandon_unfinished_files() noexcept;

}  // namespace clsdf
