#pragma once

namespace clsdf::polyhedra {

/// Starts to bring memory near the processor, where the compiler knows how.
inline void prefetch([[maybe_unused]] const void* memory) {
#ifdef __GNUC__
    __builtin_prefetch(memory);
#endif
}

}  // namespace clsdf::polyhedra
