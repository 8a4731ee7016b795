#include "disguise/host_memory.hpp"

#include "disguise/disguise.hpp"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <new>

namespace clsdf::test {

namespace {

constexpr std::size_t least_array = std::size_t{1} << 16;

/// Before each block.
struct Head {
    std::size_t bytes;
    std::uint64_t count;  ///< in which it is; 0: in none
    void* memory;         ///< malloc()'s
};

std::atomic<std::uint64_t> latest_count{};
thread_local std::uint64_t own_count = 0;  ///< 0: the thread does not count
// Of the thread that counts.
std::uint64_t bytes_now = 0;
HostMemory found;

bool is_in_count() {
    return own_count != 0 && !disguise::is_in_call();
}

void* allocate(std::size_t bytes, std::size_t alignment) {
    alignment = std::max(alignment, alignof(std::max_align_t));
    const std::size_t all = bytes + sizeof(Head) + alignment;
    void* const memory = all < bytes ? nullptr : std::malloc(all);
    if (memory == nullptr) throw std::bad_alloc();
    const Head head{bytes, is_in_count() ? own_count : 0, memory};
    if (head.count != 0) {
        bytes_now += bytes;
        found.peak_bytes = std::max(found.peak_bytes, bytes_now);
        if (bytes >= least_array) ++found.arrays;
    }
    const auto first = reinterpret_cast<std::uintptr_t>(memory) + sizeof(Head);
    std::byte* const block =
        static_cast<std::byte*>(memory) + sizeof(Head) + (alignment - first % alignment) % alignment;
    std::memcpy(block - sizeof(Head), &head, sizeof head);
    return block;
}

void release(void* block) noexcept {
    if (block == nullptr) return;
    Head head{};
    std::memcpy(&head, static_cast<std::byte*>(block) - sizeof(Head), sizeof head);
    if (is_in_count() && head.count == own_count) bytes_now -= head.bytes;
    std::free(head.memory);
}

}  // namespace

void count_host_memory() {
    own_count = ++latest_count;
    bytes_now = 0;
    found = {};
}

HostMemory end_counting_memory() {
    own_count = 0;
    return found;
}

}  // namespace clsdf::test

// The others of the standard library call these.
void* operator new(std::size_t bytes) {
    return clsdf::test::allocate(bytes, 1);
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
    return clsdf::test::allocate(bytes, static_cast<std::size_t>(alignment));
}
void operator delete(void* block) noexcept {
    clsdf::test::release(block);
}
void operator delete(void* block, std::size_t) noexcept {
    clsdf::test::release(block);
}
void operator delete(void* block, std::align_val_t) noexcept {
    clsdf::test::release(block);
}
void operator delete(void* block, std::size_t, std::align_val_t) noexcept {
    clsdf::test::release(block);
}
