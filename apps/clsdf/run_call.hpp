#pragma once

#include "report.hpp"

#include <clsdf/calls.hpp>
#include <clsdf/error.hpp>

#include <functional>
#include <stop_token>
#include <string>

/// What a subcommand's calls of the library need while they run.
struct RunningCall {
    /// Shows its progress on the bar, prints warnings in its place, takes the turn to compile, and ends soon after a
    /// stop is requested.
    clsdf::CallOptions call;
    ProgressBar& bar;
    std::stop_token stop;
};

/// The errors of a subcommand's calls.
struct CallErrors {
    /// Returns the error that the user sees; empty: the library's.
    std::function<clsdf::Error(const clsdf::Error&)> explain{};
    /// The message if an array of the subcommand itself does not fit the memory; empty: that of main().
    std::string too_large{};
    std::string cancelled = "cancelled; nothing was written";
    /// The work has written its result when it ends: a signal comes too late then.
    bool work_writes = false;
};

/// Runs the calls of a subcommand, `work`. Ctrl-C requests a stop, and the work ends in order; then this throws
/// Error(cancelled), whatever the work's own error was. Nothing of RunningCall may outlive the work.
void run_call(Report& report, const CallErrors& errors, const std::function<void(const RunningCall&)>& work);

/// Whether the user's folder has no record of a test yet.
bool is_first_use();

/// Of a process that is the first to compile on this machine, or one of several: waits while another one compiles, at
/// most 30 s, and says so on standard error after two. Does nothing later in the process, or if records are there. The
/// turn ends when a running call computes.
void take_turn_to_compile(const Report& report, const std::stop_token& stop = {});

/// "compiling kernels 3 of 11", for a ProgressBar.
std::string text_of(const clsdf::Progress& compiling);
