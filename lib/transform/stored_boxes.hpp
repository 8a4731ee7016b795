#pragma once

#include <clsdf/device.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/outputs.hpp>

#include "scan/commands.hpp"
#include "scan/programs.hpp"
#include "stored_box.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace clsdf::transform {

using namespace scan;

/// Builds the program that stores boxes and, the first time on this device and driver version, tests it. Returns
/// whether it was tested here. Throws Error(device_failure).
bool ensure_store_tested(const Device& device, const Programs& programs, const device::BuildWatch& watch);

/// The samples that a block and a request have in common; nothing if there are none. `target`: with its strides set.
std::optional<StoredBox> stored_box(const Grid& block, const Grid& request, const OutputTarget& target);

/// The elements of a block's samples.
struct StoredElements {
    std::size_t components = 1;
    std::size_t bytes = 4;     ///< of an element
    bool are_widened = false;  ///< they are floats, and the target's are doubles of the same values
};

/// The launch that stores boxes of a block's packed samples in one of the caller's buffers.
class BoxStore {
public:
    /// Without memory it must be moved before it is enqueued. Throws cl::Error.
    BoxStore(const device::Context& context, const cl::Program& program, const Grid& block,
             const StoredElements& elements, const cl::Buffer& samples, cl_mem memory,
             const std::vector<StoredBox>& boxes);

    /// Other memory, and another place of the only box, from the next launch on.
    void move(cl_mem memory, const StoredBox& box);

    /// Allocates no device memory. Throws cl::Error.
    void enqueue(CommandChain& chain);

    std::size_t bytes() const { return box_count_ * sizeof(StoredBox); }

private:
    cl::Kernel kernel_;
    cl::Buffer boxes_;
    std::size_t box_count_;
    std::size_t pieces_ = 1, rows_ = 0;  ///< of the launch: pieces of a row, rows of the largest box
    std::size_t group_rows_ = 1;         ///< rows of a work-group
    std::optional<StoredBox> moved_;
};

}  // namespace clsdf::transform
