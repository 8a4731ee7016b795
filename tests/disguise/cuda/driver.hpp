#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

/// A stand-in for CUDA's driver, libcuda.so.1: the part of it that clsdf uses, by cuda.h of CUDA 12.9. Memory of the
/// device is not accessible to the host: its addresses are reserved, and only these functions reach the bytes. Streams
/// are threads, which run what is enqueued later than the calls return. A function that needs a context refuses a
/// thread that has none. Two devices: the second one has the UUID of the disguised GPU.
///
///   CLSDF_CUDA_DEVICES=0           no device; 1: only the first, which has another UUID
///   CLSDF_CUDA_FAULT=CALL:NUMBER   that call fails with CUDA_ERROR_UNKNOWN, counted from 1
/// Each call reads these variables. cuda_stand_in_delay() lets a call begin a second later: a variable that is set
/// while streams read the environment would be a race.
namespace clsdf::cuda_stand_in {

using Result = int;
constexpr Result success = 0, invalid_value = 1, out_of_memory = 2, not_initialized = 3, no_device = 100,
                 invalid_device = 101, invalid_context = 201, invalid_handle = 400, not_ready = 600,
                 not_permitted = 800, not_supported = 801, unknown = 999;

constexpr std::size_t granularity = 2 << 20;

/// The code with which a call must fail: on purpose, or before cuInit().
Result begin(const char* call);
/// The same of a call that needs a current context.
Result begin_in_context(const char* call);

/// The bytes of the host that stand for device memory; they live as long as this.
struct Memory;
struct Bytes {
    std::byte* address = nullptr;  ///< null: not mapped, or not accessible
    std::shared_ptr<Memory> memory;
};
Bytes bytes_at(std::uint64_t address, std::size_t size);

/// Waits until all streams have done what was enqueued before.
void finish_all();

}  // namespace clsdf::cuda_stand_in
