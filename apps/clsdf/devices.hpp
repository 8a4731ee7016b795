#pragma once

#include "options.hpp"
#include "report.hpp"

#include <clsdf/clsdf.hpp>

#include <string>
#include <vector>

/// Adds --device, which sets `choice`; `does` describes the device's task: "what computes".
void add_device_option(Parser& parser, std::string& choice, const std::string& does);

/// The device that --device names, else Device::automatic(), with records in the user's folder. Throws
/// Error(no_device), which names the option if it was given.
clsdf::Device open_device(const std::string& choice);
/// The same. Warns once a process if nobody named a device, and the machine has GPUs of which none can be used.
clsdf::Device open_device(const std::string& choice, Report& report);

/// Whether it is a processor of PoCL, which compiles a kernel anew for the size of its first launch's groups, and puts
/// what it has compiled so far into a program's binary.
bool specialises_at_launch(const clsdf::Device& device);

/// The value of CLSDF_DEVICE; empty if it is not set.
std::string device_variable();

/// Compiles and tests the default kernels of the subcommands on each device: those of compute
/// with and without --with, in narrow and wide bands, those of query and those of render. `again`: also kernels that
/// were tested before, and those whose compilation has ended a process. Adds a member "prepared" to the report. The
/// last error of a device is thrown after all devices were tried; earlier errors are warnings.
void prepare(Report& report, const std::vector<clsdf::DeviceInfo>& devices, bool again);

/// The part of it that another process can do meanwhile: the bricks of compute --with, query and render.
void prepare_ahead(Report& report, const clsdf::Device& device);
