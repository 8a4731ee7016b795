#include "exit_status.hpp"

#include <fmt/format.h>

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

std::span<const ExitStatusMeaning> exit_status_meanings() {
    static constexpr ExitStatusMeaning meanings[] = {{ExitStatus::done, "done"},
                                                     {ExitStatus::check_failed, "a check failed"},
                                                     {ExitStatus::usage, "usage or unsupported"},
                                                     {ExitStatus::invalid_input, "unreadable or invalid input"},
                                                     {ExitStatus::device, "device or memory"},
                                                     {ExitStatus::output, "output"},
                                                     {ExitStatus::cancelled, "cancelled"}};
    return meanings;
}

std::string exit_status_help() {
    std::string text = "Exit status:";
    for (const auto& [status, meaning] : exit_status_meanings())
        text += fmt::format("{} {} {}", status == ExitStatus::done ? "" : ",", static_cast<int>(status), meaning);
    text[text.rfind(", ", 100) + 1] = '\n';
    return text + '.';
}
