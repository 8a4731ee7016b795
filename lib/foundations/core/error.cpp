#include <clsdf/error.hpp>

#include <array>

namespace clsdf {

const char* name_of(ErrorCode code) noexcept {
    constexpr std::array names{"unknown",   "invalid_mesh",   "unreadable_input", "invalid_argument",
                               "no_device", "device_failure", "out_of_memory",    "unsupported",
                               "cancelled", "output_failure", "wrong_results"};
    static_assert(names.size() == static_cast<std::size_t>(ErrorCode::wrong_results) + 1);
    const auto number = static_cast<std::size_t>(code);
    return number < names.size() ? names[number] : names.front();
}

}  // namespace clsdf
