#pragma once

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <cstddef>
#include <optional>
#include <string>

namespace clsdf::disguise {

/// The simulated GPU's CL_DEVICE_UUID_KHR (16 bytes), which the second device of the stand-in for CUDA's driver has,
/// too.
constexpr char uuid[] = "clsdf-disguise-1";
static_assert(sizeof uuid == 17);

/// The answer about memory and semaphores of CUDA; nothing if the driver is to answer.
std::optional<cl_int> external_answer(cl_device_info question, std::size_t size, void* value, std::size_t* needed);
/// Names to add to CL_DEVICE_EXTENSIONS, each after a blank.
std::string external_extensions();
bool is_external(cl_mem buffer);
/// False for imported memory that the program has not acquired.
bool is_usable(cl_mem buffer);

}  // namespace clsdf::disguise
