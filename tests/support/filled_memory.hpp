#pragma once

#include <malloc.h>

/// What memory holds before anything is written to it.
namespace clsdf::test {

/// While it lives, memory that malloc() and operator new hand out has this byte everywhere, not 0xFF, as buffers of
/// PoCL have it, too; a small block that was in use before has the inverse of the byte with which it was given back.
/// With other allocators, as those of sanitizers, it changes nothing.
class FilledMemory {
public:
    explicit FilledMemory(unsigned char byte) {
#ifdef M_PERTURB
        mallopt(M_PERTURB, byte ^ 0xFF);
#endif
    }
    FilledMemory(const FilledMemory&) = delete;
    FilledMemory& operator=(const FilledMemory&) = delete;
    ~FilledMemory() {
#ifdef M_PERTURB
        mallopt(M_PERTURB, 0);
#endif
    }
};

}  // namespace clsdf::test
