#include "core/large_memory.hpp"

#include <cstdlib>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace clsdf {

void* allocate_large_memory(std::size_t bytes) {
    constexpr std::size_t huge_page = std::size_t{2} << 20;
    const std::size_t whole_pages = (bytes + huge_page - 1) / huge_page * huge_page;
    void* memory = whole_pages < bytes ? nullptr : std::aligned_alloc(huge_page, whole_pages);
    if (memory == nullptr) throw std::bad_alloc();
#ifdef __linux__
    madvise(memory, whole_pages, MADV_HUGEPAGE);  // an advice: nothing is lost where it is not taken
#endif
    return memory;
}

void free_large_memory(void* memory) noexcept {
    std::free(memory);
}

}  // namespace clsdf
