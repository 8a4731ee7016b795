#include "homes/device_set_up.hpp"

namespace clsdf::engine {

SetUpWays::SetUpWays(const DeviceTools& tools, std::size_t vertices, std::size_t faces) {
    constexpr std::size_t fewest = 1024;                // of fewer faces the host makes the topology sooner
    constexpr std::size_t most = std::size_t{1} << 28;  // kernels number words by 32 bits
    const device::Context::Capabilities& device = tools.context.capabilities();
    const bool are_few_enough = faces > 0 && faces <= most;
    arrays_are_shared = device.is_processor;
    topology_by_kernels = device.has_own_memory && !device.is_processor &&
                          tools.programs.body == KernelBody::by_group && are_few_enough && faces >= fewest &&
                          vertices > 0 && vertices <= most;
    frusta_by_kernels = are_few_enough;
    selections_by_kernels = tools.programs.body == KernelBody::by_vector;
    item_faces = tools.programs.mesh_lanes() == 1 ? 1 : 256;
}

}  // namespace clsdf::engine
