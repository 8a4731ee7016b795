#pragma once

#include "core/large_memory.hpp"

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

namespace clsdf {

/// An array that owns its values, as a vector does, or borrows them: then their memory must outlive it, and may be
/// read-only. Only an array that owns its values may be written to or resized. A copy of a borrowed array borrows, too.
template <typename T>
class KeptArray {
public:
    using value_type = T;

    KeptArray() = default;
    explicit KeptArray(std::size_t count) : KeptArray(UninitializedVector<T>(count)) {}
    KeptArray(UninitializedVector<T> values)  // NOLINT(google-explicit-constructor): a vector becomes kept
        : own_(std::move(values)) {
        view_own();
    }
    static KeptArray borrowed(std::span<const T> values) {
        KeptArray array;
        array.data_ =
            const_cast<T*>(values.data());  // NOLINT(cppcoreguidelines-pro-type-const-cast): only its owner writes
        array.size_ = values.size();
        return array;
    }

    KeptArray(const KeptArray& other) : own_(other.own_), data_(other.data_), size_(other.size_) {
        if (other.is_own()) view_own();
    }
    KeptArray(KeptArray&& other) noexcept
        : own_(std::move(other.own_)),
          data_(std::exchange(other.data_, nullptr)),
          size_(std::exchange(other.size_, 0)) {}
    KeptArray& operator=(KeptArray other) noexcept {
        own_.swap(other.own_);
        std::swap(data_, other.data_);
        std::swap(size_, other.size_);
        return *this;
    }
    ~KeptArray() = default;

    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    const T* data() const { return data_; }
    const T* begin() const { return data_; }
    const T* end() const { return data_ + size_; }
    const T& operator[](std::size_t i) const { return data_[i]; }
    const T& back() const { return data_[size_ - 1]; }

    T* data() { return data_; }
    T* begin() { return data_; }
    T* end() { return data_ + size_; }
    T& operator[](std::size_t i) { return data_[i]; }
    void resize(std::size_t count) {
        own_.resize(count);
        view_own();
    }

    bool operator==(const KeptArray& other) const { return std::ranges::equal(*this, other); }

    /// Bytes that it owns.
    std::size_t host_bytes() const { return own_.size() * sizeof(T); }

private:
    bool is_own() const { return data_ == own_.data(); }
    void view_own() {
        data_ = own_.data();
        size_ = own_.size();
    }

    UninitializedVector<T> own_;
    T* data_ = nullptr;
    std::size_t size_ = 0;
};

}  // namespace clsdf
