#pragma once

#include "report.hpp"

#include <clsdf/clsdf.hpp>

#include <string>
#include <vector>

/// "compiling kernels 3 of 11", for a ProgressBar.
std::string text_of(const clsdf::Compilation& compilation);

/// Compiles and tests the default kernels of the subcommands on each device: those of compute, with and without --json
/// (which counts) and --with triangle, in narrow and wide bands, and those of render. `again`: also kernels that were
/// tested before, and those whose compilation has ended a process. Adds a member "prepared" to the report. The last
/// error of a device is thrown after all devices were tried; earlier errors are warnings.
void prepare(Report& report, const std::vector<clsdf::DeviceInfo>& devices, bool again);
