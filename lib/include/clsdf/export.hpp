#pragma once

/// Marks the symbols that a shared library of clsdf exports; all other symbols are hidden.
///
/// CLSDF_EXPORT marks the interface. It has no effect in a static library: a plug-in that contains one exports none of
/// its functions, so two plug-ins with different versions do not clash. CLSDF_VISIBLE marks types that must be the same
/// type in all modules of a process: exceptions that another module catches.
#if defined(__GNUC__)
#define CLSDF_VISIBLE __attribute__((visibility("default")))
#else
#define CLSDF_VISIBLE
#endif

#ifdef CLSDF_STATIC_BUILD
#define CLSDF_EXPORT
#else
#define CLSDF_EXPORT CLSDF_VISIBLE
#endif

#include <clsdf/version.hpp>  // stops old compilers with one message
