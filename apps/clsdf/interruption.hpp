#pragma once

#include <stop_token>
#include <thread>

/// From now on Ctrl-C (SIGINT) and SIGTERM end the process with the exit status of a cancellation.
void end_when_interrupted();

/// While it lives, the first such signal sets the stop token instead, so that what runs can end in order; a second one
/// ends the process.
class Interruption {
public:
    Interruption();
    ~Interruption();
    Interruption(const Interruption&) = delete;
    Interruption& operator=(const Interruption&) = delete;

    std::stop_token token() const { return source_.get_token(); }

private:
    std::stop_source source_;
    int read_end_ = -1;
    int write_end_ = -1;
    std::thread listener_;
};
