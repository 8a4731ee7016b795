#include "core/large_memory.hpp"

#include <clsdf/field_array.hpp>

#include <memory>
#include <new>

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

void* detail::allocate_field_memory(std::size_t bytes) {
    return bytes < large_memory_bytes ? ::operator new(bytes, line) : allocate_large_memory(bytes);
}

void detail::free_field_memory(void* memory, std::size_t bytes) noexcept {
    if (bytes < large_memory_bytes)
        ::operator delete(memory, line);
    else
        free_large_memory(memory);
}

}  // namespace clsdf

template class std::vector<float, clsdf::FieldAllocator<float>>;
template class std::vector<double, clsdf::FieldAllocator<double>>;
template class std::vector<std::uint32_t, clsdf::FieldAllocator<std::uint32_t>>;
template class std::vector<std::uint8_t, clsdf::FieldAllocator<std::uint8_t>>;
