#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <vector>

namespace clsdf {

/// Values and lists as bytes, one after the other, without types: a function that takes either archive writes and reads
/// the same members. Values are copied with their padding: use none that has some.
class WritingArchive {
public:
    template <typename Value>
    requires std::is_trivially_copyable_v<Value>
    void operator()(Value& value) { add(std::as_bytes(std::span(&value, 1))); }
    template <typename Value, typename Allocator>
    requires std::is_trivially_copyable_v<Value>
    void operator()(std::vector<Value, Allocator>& values) {
        std::uint64_t count = values.size();
        (*this)(count);
        add(std::as_bytes(std::span(values)));
    }

    std::vector<std::byte> take() { return std::move(bytes_); }

private:
    void add(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }

    std::vector<std::byte> bytes_;
};

class ReadingArchive {
public:
    /// The bytes end before what is read from them, or have a value that cannot be one.
    struct Ended : std::runtime_error {
        Ended() : std::runtime_error("the bytes end too early") {}
    };

    explicit ReadingArchive(std::span<const std::byte> bytes) : rest_(bytes) {}

    template <typename Value>
    requires std::is_trivially_copyable_v<Value>
    void operator()(Value& value) {
        const std::span<const std::byte> bytes = take(sizeof(Value));
        std::memcpy(static_cast<void*>(&value), bytes.data(), bytes.size());
    }
    template <typename Value, typename Allocator>
    requires std::is_trivially_copyable_v<Value>
    void operator()(std::vector<Value, Allocator>& values) {
        std::uint64_t count = 0;
        (*this)(count);
        if (count > rest_.size() / sizeof(Value)) throw Ended();
        const std::span<const std::byte> bytes = take(static_cast<std::size_t>(count) * sizeof(Value));
        values.resize(static_cast<std::size_t>(count));
        if (count > 0) std::memcpy(static_cast<void*>(values.data()), bytes.data(), bytes.size());
    }

    bool is_at_end() const { return rest_.empty(); }

private:
    std::span<const std::byte> take(std::size_t count) {
        if (count > rest_.size()) throw Ended();
        const std::span<const std::byte> bytes = rest_.first(count);
        rest_ = rest_.subspan(count);
        return bytes;
    }

    std::span<const std::byte> rest_;
};

}  // namespace clsdf
