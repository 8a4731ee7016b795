#pragma once

#include "options.hpp"
#include "report.hpp"

#include <clsdf/clsdf.hpp>

#include <stop_token>
#include <string>
#include <vector>

/// Adds --device, which sets `choice`; `does` describes the device's task: "what computes".
void add_device_option(Parser& parser, std::string& choice, const std::string& does);

/// The device that --device names, else Device::automatic(), with records in the user's folder. Throws
/// Error(no_device), which names the option if it was given.
clsdf::Device open_device(const std::string& choice);
/// The same. Warns once a process if nobody named a device, and the machine has GPUs of which none can be used.
clsdf::Device open_device(const std::string& choice, Report& report);

/// Whether the user's folder has no record of a test yet.
bool is_first_use();

/// Of a process that is the first to compile on this machine, or one of several: waits while another one compiles, at
/// most 30 s, and says so on standard error after two. Does nothing later in the process, or if records are there.
void take_turn_to_compile(const Report& report, const std::stop_token& stop = {});
/// Lets the next process begin.
void end_turn_to_compile();

/// Whether it is a processor of PoCL, which compiles a kernel anew for the size of its first launch's groups, and puts
/// what it has compiled so far into a program's binary.
bool specialises_at_launch(const clsdf::Device& device);

/// The value of CLSDF_DEVICE; empty if it is not set.
std::string device_variable();

/// "compiling kernels 3 of 11", for a ProgressBar.
std::string text_of(const clsdf::Progress& compiling);

class ProgressBar;
/// The bar of a call that computes, or the text of one that compiles.
void show(ProgressBar& bar, const clsdf::Progress& progress);
/// Options of a call that shows its progress on the bar, prints warnings in its place, takes the turn to compile, and
/// ends soon after a stop is requested. Bar and report must outlive them.
clsdf::CallOptions watched_call(ProgressBar& bar, Report& report, std::stop_token stop);

/// Compiles and tests the default kernels of the subcommands on each device: those of compute
/// with and without --with, in narrow and wide bands, those of query and those of render. `again`: also kernels that
/// were tested before, and those whose compilation has ended a process. Adds a member "prepared" to the report. The
/// last error of a device is thrown after all devices were tried; earlier errors are warnings.
void prepare(Report& report, const std::vector<clsdf::DeviceInfo>& devices, bool again);

/// The part of it that another process can do meanwhile: the bricks of compute --with, query and render.
void prepare_ahead(Report& report, const clsdf::Device& device);
