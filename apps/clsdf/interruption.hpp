#pragma once

#include <stop_token>
#include <string>

/// From now on Ctrl-C (SIGINT), SIGTERM and SIGHUP end the process at any time with the message and the exit status of
/// a cancellation, and leave no incomplete file. `json`: also prints the error as JSON on standard output. A SIGHUP
/// that is ignored already (nohup) stays ignored.
void end_when_interrupted(bool json);

/// A library may call exit() during the work, as LLVM does if it cannot write a file. Then the process ends with the
/// message and the status of a failing device, and without an incomplete file.
void end_when_left_by_a_library(bool json);

/// The output has been written: the message of a later cancellation says so.
void output_is_written();

/// Ignores these signals and exit() calls from now on, because only the end of the process is left.
void ignore_interruptions();

/// Whether such a signal has arrived. A system call that was waiting may fail for that reason only.
bool interrupted();

/// While it lives, the first such signal sets the stop token instead, so that the computation can end in order. One
/// object at a time.
class Interruption {
public:
    Interruption();
    ~Interruption();
    Interruption(const Interruption&) = delete;
    Interruption& operator=(const Interruption&) = delete;

    std::stop_token token() const { return source_.get_token(); }

    /// Call it after a computation, failed or not: a signal may have arrived after the last look at the token, or have
    /// made a compiler fail. Throws Error(cancelled) with the message if there was one. A later one ends the process.
    void finish(const std::string& message) const;

private:
    std::stop_source source_;
};
