#include "report.hpp"

#include "output.hpp"

using clsdf::ErrorCode;

void Report::warn(const std::string& warning) {
    warnings_.push_back(warning);
    print_text("warning: {}\n", warning);
}

ExitStatus Report::fail(ErrorCode code, const std::string& message) {
    const ExitStatus status = status_of(code);
    print_text("clsdf: {}\n", message);
    result["error"] = {{"code", name_of(code)}, {"message", message}, {"exit_status", static_cast<int>(status)}};
    try {
        finish();
    } catch (const clsdf::Error&) {
        // If standard output failed, standard error has the message.
    }
    return status;
}

void Report::finish() const {
    if (!json) return;
    nlohmann::ordered_json object = result;
    object["warnings"] = warnings_;
    print_result(object);
}

const char* name_of(ErrorCode code) {
    switch (code) {
        case ErrorCode::invalid_mesh:
            return "invalid_mesh";
        case ErrorCode::unreadable_input:
            return "unreadable_input";
        case ErrorCode::invalid_argument:
            return "invalid_argument";
        case ErrorCode::no_device:
            return "no_device";
        case ErrorCode::device_failure:
            return "device_failure";
        case ErrorCode::out_of_memory:
            return "out_of_memory";
        case ErrorCode::unsupported:
            return "unsupported";
        case ErrorCode::cancelled:
            return "cancelled";
        case ErrorCode::output_failure:
            return "output_failure";
    }
    return "internal";
}
