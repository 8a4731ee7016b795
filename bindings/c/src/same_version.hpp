#pragma once

#include <clsdf.h>

/// Exported by libclsdf_c with its exact version, for libclsdf_c_io alone: the two share the layout of handles.
extern "C" CLSDF_API void clsdf_c_same_version();
