#pragma once

#include <stop_token>

/// From now on Ctrl-C (SIGINT), SIGTERM and SIGHUP end the process, whatever it does, with the message and the exit
/// status of a cancellation, and leave no half file; `json`: also with the error as JSON on standard output. A SIGHUP
/// that is ignored already (nohup) stays ignored.
void end_when_interrupted(bool json);

/// A library that calls exit() in the middle of the work, as LLVM does if a file cannot be written, ends the process
/// like a device that fails: with a message and the status of that, and without a half file.
void end_when_left_by_a_library(bool json);

/// What was asked for has been written: the message of a later cancellation says so.
void output_is_written();

/// Ignores these signals and exit() calls from now on, when only the process's end is left.
void ignore_interruptions();

/// Whether such a signal has arrived. A system call that was waiting may fail for that reason only.
bool interrupted();

/// While it lives, the first such signal sets the stop token instead, so that what runs can end in order. One at a
/// time.
class Interruption {
public:
    Interruption();
    ~Interruption();
    Interruption(const Interruption&) = delete;
    Interruption& operator=(const Interruption&) = delete;

    std::stop_token token() const { return source_.get_token(); }

private:
    std::stop_source source_;
};
