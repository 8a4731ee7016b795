#pragma once

#include "report.hpp"

#include <clsdf/clsdf.hpp>

#include <string>
#include <vector>

/// "compiling kernels 3 of 11", for a ProgressBar.
std::string text_of(const clsdf::Compilation& compilation);

/// Compiles and tests on each of the devices what the subcommands run there by default: the kernels of compute, also
/// with
/// --json, which counts, and with --with triangle, in narrow and wide bands, and those of render. `again`: also those
/// that were tested before, and those whose compilation has ended a process. Adds a member "prepared" to the report.
/// An error of one device is a warning if another one fails after it; the last one is thrown when all were tried.
void prepare(Report& report, const std::vector<clsdf::DeviceInfo>& devices, bool again);
