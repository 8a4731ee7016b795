#include <clsdf/error.hpp>

namespace clsdf {

const char* name_of(ErrorCode code) noexcept {
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
        case ErrorCode::wrong_results:
            return "wrong_results";
    }
    return "unknown";
}

}  // namespace clsdf
