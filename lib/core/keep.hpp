#pragma once

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

}  // namespace clsdf
