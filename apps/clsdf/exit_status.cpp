#include "exit_status.hpp"

ExitStatus status_of(clsdf::ErrorCode code) {
    using clsdf::ErrorCode;
    switch (code) {
        case ErrorCode::invalid_argument:
        case ErrorCode::unsupported:
            return ExitStatus::usage;
        case ErrorCode::invalid_mesh:
        case ErrorCode::unreadable_input:
            return ExitStatus::invalid_input;
        case ErrorCode::no_device:
        case ErrorCode::device_failure:
        case ErrorCode::out_of_memory:
            return ExitStatus::device;
        case ErrorCode::output_failure:
            return ExitStatus::output;
        case ErrorCode::cancelled:
            return ExitStatus::cancelled;
    }
    return ExitStatus::device;
}

const char* exit_status_help() {
    return "Exit status: 0 done, 1 a check failed, 2 usage or unsupported, 3 unreadable or invalid input,\n"
           "4 device or memory, 5 output, 6 cancelled.";
}
