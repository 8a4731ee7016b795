#pragma once

#include "core/kept_array.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <vector>

namespace clsdf {

/// The first multiple of a cache line (64 bytes) that is not below a place.
inline constexpr std::size_t line_bytes = 64;
constexpr std::size_t at_line(std::size_t place) {
    return (place + line_bytes - 1) / line_bytes * line_bytes;
}

/// Values and lists as bytes, one after the other, without types: a function that takes either archive writes and reads
/// the same members. Values are copied with their padding: use none that has some. KeptArrays lie at multiples of a
/// cache line, so that a reader may borrow them.
class WritingArchive {
public:
    /// Only counts.
    WritingArchive() = default;
    explicit WritingArchive(std::span<std::byte> memory) : memory_(memory) {}

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
    template <typename Value>
    requires std::is_trivially_copyable_v<Value>
    void operator()(KeptArray<Value>& values) {
        std::uint64_t count = values.size();
        (*this)(count);
        skip_to_line();
        add(std::as_bytes(std::span<const Value>(values)));
    }

    std::size_t size() const { return size_; }

private:
    void add(std::span<const std::byte> bytes) {
        if (!memory_.empty() && !bytes.empty())
            std::memcpy(memory_.subspan(size_, bytes.size()).data(), bytes.data(), bytes.size());
        size_ += bytes.size();
    }
    void skip_to_line() {
        const std::size_t begin = at_line(size_);
        if (!memory_.empty()) std::memset(memory_.subspan(size_, begin - size_).data(), 0, begin - size_);
        size_ = begin;
    }

    std::span<std::byte> memory_;
    std::size_t size_ = 0;
};

/// How many bytes a WritingArchive writes of the value.
template <typename Visited>
std::size_t archived_size(Visited& value) {
    WritingArchive counting;
    value.visit(counting);
    return counting.size();
}

/// Reads what WritingArchive wrote. KeptArrays borrow their values; the rest is copied.
class ReadingArchive {
public:
    /// The bytes end before what is read from them, or have a value that cannot be one.
    struct Ended : std::runtime_error {
        Ended() : std::runtime_error("the bytes end too early") {}
    };

    explicit ReadingArchive(std::span<const std::byte> bytes) : bytes_(bytes) {}

    template <typename Value>
    requires std::is_trivially_copyable_v<Value>
    void operator()(Value& value) { std::memcpy(static_cast<void*>(&value), take(1, sizeof(Value)), sizeof(Value)); }
    template <typename Value, typename Allocator>
    requires std::is_trivially_copyable_v<Value>
    void operator()(std::vector<Value, Allocator>& values) {
        std::uint64_t count = 0;
        (*this)(count);
        const std::byte* const from = take(count, sizeof(Value));
        values.resize(static_cast<std::size_t>(count));
        if (count > 0) std::memcpy(static_cast<void*>(values.data()), from, values.size() * sizeof(Value));
    }
    template <typename Value>
    requires std::is_trivially_copyable_v<Value>
    void operator()(KeptArray<Value>& values) {
        std::uint64_t count = 0;
        (*this)(count);
        take(at_line(place_) - place_, 1);
        const auto* const from = reinterpret_cast<const Value*>(take(count, sizeof(Value)));
        values = KeptArray<Value>::borrowed({from, static_cast<std::size_t>(count)});
    }

    bool is_at_end() const { return place_ == bytes_.size(); }

private:
    /// The place of the next `count` elements of so many bytes.
    const std::byte* take(std::uint64_t count, std::size_t element) {
        if (count > (bytes_.size() - place_) / element) throw Ended();
        const std::byte* const from = bytes_.data() + place_;
        place_ += static_cast<std::size_t>(count) * element;
        return from;
    }

    std::span<const std::byte> bytes_;
    std::size_t place_ = 0;
};

}  // namespace clsdf
