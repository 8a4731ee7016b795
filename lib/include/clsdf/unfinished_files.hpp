#pragma once

#include <clsdf/version.hpp>

namespace clsdf {

/// For a program that is about to end in the middle of its work, on Ctrl-C for instance: removes what the files that
/// are being written have under temporary names, in every thread, and lets none of them get its own name any more. A
/// thread that goes on to write waits for ever, so the program must end now. May be called from any thread, but not
/// from a signal handler.
///
/// A process that is killed leaves such files, ".clsdf-PID-N.part" in the folder of the final one. The first file that
/// another process writes in the folder removes those that no process holds locked, if they belong to the same user and
/// the file system is known to belong to one machine (docs/formats.md lists which). Elsewhere, on NFS above all, they
/// stay.
void abandon_unfinished_files() noexcept;

}  // namespace clsdf
