#pragma once

#include <clsdf/error.hpp>

#include <fmt/format.h>

namespace clsdf {

/// The value behind an object's pointer. The pointer is null after the object was moved from; then this throws
/// Error(invalid_argument). `type`: the object's name.
template <typename Pointer>
auto& held_by(const Pointer& pointer, const char* type) {
    if (!pointer)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("this {} was moved from and is empty; use the object that it was moved to, or assign a "
                                "new one",
                                type));
    return *pointer;
}

}  // namespace clsdf
