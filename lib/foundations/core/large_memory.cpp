#include "core/large_memory.hpp"

#include <clsdf/field.hpp>

#include <algorithm>
#include <limits>
#include <memory>
#include <new>
#include <utility>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace clsdf {

namespace {

constexpr std::size_t huge_page = std::size_t{2} << 20;
constexpr std::align_val_t line{64};

}  // namespace

void* allocate_large_memory(std::size_t bytes) {
    const std::size_t whole_pages = (bytes + huge_page - 1) / huge_page * huge_page;
    if (whole_pages < bytes) throw std::bad_alloc();
    void* memory = ::operator new (whole_pages, std::align_val_t{huge_page});
    advise_huge_pages(memory, whole_pages);
    return memory;
}

void advise_huge_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) noexcept {
#ifdef __linux__
    if (std::align(huge_page, huge_page, memory, bytes) == nullptr) return;
    madvise(memory, bytes / huge_page * huge_page, MADV_HUGEPAGE);  // a failure does no harm
#endif
}

void free_large_memory(void* memory) noexcept {
    ::operator delete (memory, std::align_val_t{huge_page});
}

void* allocate_array(std::size_t count, std::size_t element) {
    if (count > std::numeric_limits<std::size_t>::max() / element) throw std::bad_array_new_length();
    const std::size_t bytes = count * element;
    return bytes < large_memory_bytes ? ::operator new(bytes, line) : allocate_large_memory(bytes);
}

void free_array(void* memory, std::size_t count, std::size_t element) noexcept {
    if (count * element < large_memory_bytes)
        ::operator delete(memory, line);
    else
        free_large_memory(memory);
}

template <typename Value>
FieldArray<Value>::FieldArray(std::size_t size) {
    resize(size);
}

template <typename Value>
FieldArray<Value>::FieldArray(std::size_t size, Value value) {
    resize(size, value);
}

template <typename Value>
FieldArray<Value>::FieldArray(std::initializer_list<Value> values) : FieldArray(values.size()) {
    std::copy(values.begin(), values.end(), begin());
}

template <typename Value>
FieldArray<Value>::FieldArray(const FieldArray& other) : FieldArray(other.size_) {
    std::copy(other.begin(), other.end(), begin());
}

template <typename Value>
FieldArray<Value>::FieldArray(FieldArray&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)),
      size_(std::exchange(other.size_, 0)),
      capacity_(std::exchange(other.capacity_, 0)) {}

template <typename Value>
FieldArray<Value>& FieldArray<Value>::operator=(FieldArray other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
    return *this;
}

template <typename Value>
FieldArray<Value>::~FieldArray() {
    clear();
}

template <typename Value>
void FieldArray<Value>::reserve(std::size_t size) {
    if (size <= capacity_) return;
    auto* data = static_cast<Value*>(allocate_array(size, sizeof(Value)));
    std::copy_n(data_, size_, data);
    if (data_ != nullptr) free_array(data_, capacity_, sizeof(Value));
    data_ = data;
    capacity_ = size;
}

template <typename Value>
void FieldArray<Value>::resize(std::size_t size) {
    reserve(size);
    size_ = size;
}

template <typename Value>
void FieldArray<Value>::resize(std::size_t size, Value value) {
    const std::size_t before = size_;
    resize(size);
    if (size > before) std::fill(data_ + before, end(), value);
}

template <typename Value>
void FieldArray<Value>::push_back(Value value) {
    append({&value, 1});
}

template <typename Value>
void FieldArray<Value>::append(std::span<const Value> values) {
    const std::size_t before = size_;
    if (before + values.size() > capacity_) reserve(std::max(before + values.size(), 2 * capacity_));
    resize(before + values.size());
    std::copy(values.begin(), values.end(), data_ + before);
}

template <typename Value>
void FieldArray<Value>::clear() noexcept {
    if (data_ != nullptr) free_array(data_, capacity_, sizeof(Value));
    data_ = nullptr;
    size_ = capacity_ = 0;
}

template <typename Value>
bool FieldArray<Value>::operator==(const FieldArray& other) const {
    return std::equal(begin(), end(), other.begin(), other.end());
}

template class FieldArray<float>;
template class FieldArray<double>;
template class FieldArray<std::uint32_t>;
template class FieldArray<std::uint8_t>;
template class FieldArray<std::byte>;

}  // namespace clsdf
