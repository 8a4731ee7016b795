#pragma once

/// OpenCL's C++ binding, as the whole library sees it: clsdf::cl.
///
/// Its functions are inline, so every object file that calls one defines it as a weak symbol, and the linker keeps one
/// definition of each name. A program that compiles the binding without exceptions would share ours, which throw. So
/// the library's copy has a namespace of its own.
#define CL_HPP_ENABLE_EXCEPTIONS
#define CL_HPP_TARGET_OPENCL_VERSION 120
#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#define CL_TARGET_OPENCL_VERSION 120
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#define cl clsdf_cl
#include <CL/opencl.hpp>
#undef cl
#pragma GCC diagnostic pop

namespace clsdf {
namespace cl = ::clsdf_cl;
}
