#include "launch/radix_sort.hpp"

#include "core/parallel.hpp"
#include "device/buffer_pool.hpp"
#include "device/opencl.hpp"
#include "launch/commands.hpp"
#include "launch/prefix_sums.hpp"
#include "launch/programs.hpp"

#include "radix_sort.h"

#include <array>
#include <limits>
#include <utility>

namespace clsdf::engine {

namespace {

std::size_t tiles_of(std::size_t count) {
    if (count >= std::numeric_limits<cl_uint>::max() - CLSDF_RADIX_TILE) throw too_many("keys");
    return chunk_count(count, CLSDF_RADIX_TILE);
}

device::BufferPool::Lease words(device::BufferPool& pool, std::size_t count) {
    return pool.lease(count * sizeof(cl_uint), "keys that are sorted");
}

}  // namespace

SortMemory::SortMemory(device::BufferPool& pool, std::size_t count)
    : counts(words(pool, tiles_of(count) * CLSDF_RADIX_DIGITS)),
      totals(words(pool, CLSDF_RADIX_DIGITS)),
      keys(words(pool, count)),
      order(words(pool, count)) {}

void sort_by_keys(const Launches& launches, const Programs& programs, const SortMemory& memory, const cl::Buffer& keys,
                  std::size_t count, unsigned bits, const cl::Buffer& order) {
    const std::size_t tiles = tiles_of(count), passes = chunk_count(bits, CLSDF_RADIX_BITS);
    const std::size_t group = programs.group_size;
    // Each pass writes to the other buffers, and the last one to `order`.
    std::array<cl::Buffer, 2> keys_of{keys, *memory.keys}, values_of{order, *memory.order};
    if (passes % 2 != 0) std::swap(values_of[0], values_of[1]);
    const cl::Program program = programs.radix_sort;
    const WorkItems of_tiles{tiles * group, group}, of_digits{CLSDF_RADIX_DIGITS * group, group};
    const auto keys_count = static_cast<cl_uint>(count);
    const bool are_summed = programs.body != KernelBody::by_group || tiles > CLSDF_FEW_RADIX_TILES;
    for (std::size_t pass = 0; pass < passes; ++pass) {
        const auto shift = static_cast<cl_uint>(pass * CLSDF_RADIX_BITS);
        const std::size_t from = pass % 2, to = 1 - from;
        launches.launch(program, "radix_count", of_tiles, keys_count, shift, keys_of[from], *memory.counts);
        if (are_summed)
            launches.launch(program, "radix_sums", of_digits, static_cast<cl_uint>(tiles), *memory.counts,
                            *memory.totals);
        launches.launch(program, "radix_place", of_tiles, keys_count, shift, cl_uint{pass == 0},
                        cl_uint{pass + 1 == passes}, cl_uint{are_summed}, *memory.counts, *memory.totals, keys_of[from],
                        values_of[from], keys_of[to], values_of[to]);
    }
}

void sort_by_keys(const DeviceTools& tools, const cl::Buffer& keys, std::size_t count, unsigned bits,
                  const cl::Buffer& order) {
    if (count == 0) return;
    device::guarded([&] {
        sort_by_keys(Launches(tools.queue(), tools.context.kernels()), tools.programs, SortMemory(*tools.pool, count),
                     keys, count, bits, order);
    });
}

}  // namespace clsdf::engine
