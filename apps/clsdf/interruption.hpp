#pragma once

#include <stop_token>

/// From now on Ctrl-C (SIGINT) and SIGTERM end the process, whatever it does, with the message and the exit status of a
/// cancellation, and leave no half file; `json`: also with the error as JSON on standard output.
void end_when_interrupted(bool json);

/// What was asked for has been written: the message of a later cancellation says so.
void output_is_written();

/// Such signals are ignored: all is done but the end itself.
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
