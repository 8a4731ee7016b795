#pragma once

namespace clsdf::polyhedra {

/// Prefetches memory, if the compiler has a built-in for it.
inline void prefetch([[maybe_unused]] const void* memory) {
#ifdef __GNUC__
    __builtin_prefetch(memory);
#endif
}

}  // namespace clsdf::polyhedra
