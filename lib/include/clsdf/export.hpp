#pragma once

/// What a shared library of clsdf shows to other modules; everything else in it is hidden.
///
/// CLSDF_EXPORT marks the interface. In a static library it means nothing: a plug-in that contains one shows no symbol
/// of clsdf, so that two plug-ins with different versions do not meet. CLSDF_VISIBLE marks types that are one type in
/// all modules of a process: exceptions that are caught elsewhere.
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

#include <clsdf/version.hpp>  // which says what compiler is needed
