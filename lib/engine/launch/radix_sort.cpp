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

void sort_by_keys(const DeviceTools& tools, const cl::Buffer& keys, std::size_t count, unsigned bits,
                  const cl::Buffer& order) {
    if (count >= std::numeric_limits<cl_uint>::max() - CLSDF_RADIX_TILE) throw too_many("keys");
    if (count == 0) return;
    const std::size_t tiles = chunk_count(count, CLSDF_RADIX_TILE), passes = chunk_count(bits, CLSDF_RADIX_BITS);
    const std::size_t group = tools.programs.group_size;
    device::guarded([&] {
        const auto lease = [&](std::size_t words) {
            return tools.pool->lease(words * sizeof(cl_uint), "keys that are sorted");
        };
        const device::BufferPool::Lease counts = lease(tiles * CLSDF_RADIX_DIGITS), totals = lease(CLSDF_RADIX_DIGITS);
        const device::BufferPool::Lease other_keys = lease(count), other_order = lease(count);
        // Each pass writes to the other buffers, and the last one to `order`.
        std::array<cl::Buffer, 2> keys_of{keys, *other_keys}, values_of{order, *other_order};
        if (passes % 2 != 0) std::swap(values_of[0], values_of[1]);
        const cl::Program program = tools.programs.radix_sort;
        cl::Kernel count_digits(program, "radix_count"), sum(program, "radix_sums"), place(program, "radix_place");
        const WorkItems of_tiles{tiles * group, group}, of_digits{CLSDF_RADIX_DIGITS * group, group};
        const auto keys_count = static_cast<cl_uint>(count);
        for (std::size_t pass = 0; pass < passes; ++pass) {
            const auto shift = static_cast<cl_uint>(pass * CLSDF_RADIX_BITS);
            const std::size_t from = pass % 2, to = 1 - from;
            launch(tools.queue(), count_digits, of_tiles, keys_count, shift, keys_of[from], *counts);
            launch(tools.queue(), sum, of_digits, static_cast<cl_uint>(tiles), *counts, *totals);
            launch(tools.queue(), place, of_tiles, keys_count, shift, cl_uint{pass == 0}, cl_uint{pass + 1 == passes},
                   *counts, *totals, keys_of[from], values_of[from], keys_of[to], values_of[to]);
        }
    });
}

}  // namespace clsdf::engine
