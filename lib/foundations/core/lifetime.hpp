#pragma once

#include <clsdf/error.hpp>

#include "core/refuse.hpp"

#include <exception>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace clsdf {

/// Moves a value into storage that lives until the process ends: for memory that a device may still use.
template <class Value>
void keep_for_good(Value& value) noexcept {
    static auto* const kept = new std::vector<std::shared_ptr<Value>>;
    static auto* const mutex = new std::mutex;
    try {
        const std::scoped_lock lock(*mutex);
        kept->push_back(std::make_shared<Value>(std::move(value)));
    } catch (const std::exception&) {
        // Out of memory: the value cannot be kept.
    }
}

/// The value behind an object's pointer. The pointer is null after the object was moved from; then this throws
/// Error(invalid_argument). `type`: the object's name.
template <typename Pointer>
auto& held_by(const Pointer& pointer, const char* type) {
    if (!pointer)
        refuse(
            "this {} was moved from and is empty; use the object that it was moved to, or assign a "
            "new one",
            type);
    return *pointer;
}

}  // namespace clsdf
