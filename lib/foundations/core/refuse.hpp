#pragma once

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <utility>

namespace clsdf {

/// Throws Error(invalid_argument). The text names the thing, the value and the remedy.
template <typename... Values>
[[noreturn]] void refuse(fmt::format_string<Values...> text, Values&&... values) {
    throw Error(ErrorCode::invalid_argument, fmt::format(text, std::forward<Values>(values)...));
}

/// Throws Error(unsupported).
template <typename... Values>
[[noreturn]] void refuse_unsupported(fmt::format_string<Values...> text, Values&&... values) {
    throw Error(ErrorCode::unsupported, fmt::format(text, std::forward<Values>(values)...));
}

}  // namespace clsdf
