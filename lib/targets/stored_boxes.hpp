#pragma once

#include <clsdf/grid.hpp>
#include <clsdf/outputs.hpp>

#include "box_store.h"
#include "launch/commands.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace clsdf::targets {

/// The samples that a block and a request have in common; nothing if there are none. `target`: with its strides set.
std::optional<StoredBox> stored_box(const Grid& block, const Grid& request, const OutputArray& target);

/// The elements of a block's samples.
struct StoredElements {
    std::size_t components = 1;
    std::size_t bytes = 4;  ///< of an element
};

/// A box of a block's samples in one of the caller's buffers. Without memory there is none yet.
struct TargetBox {
    cl_mem memory = nullptr;
    StoredBox box{};
};

/// The launches that store boxes of a block's packed samples in the caller's buffers.
class BoxStore {
public:
    /// There must be one box at least; boxes of one buffer should follow one another. Throws cl::Error.
    BoxStore(const device::Context& context, const cl::Program& program, const Grid& block,
             const StoredElements& elements, const cl::Buffer& samples, std::vector<TargetBox> places);

    /// places: of this run alone, as many and as large as those before; empty: those it was made with. Allocates no
    /// device memory. Throws cl::Error.
    void enqueue(engine::CommandChain& chain, std::span<const TargetBox> places = {});

    std::size_t bytes() const { return written_.size() * sizeof(StoredBox); }

private:
    /// Writes to the device what differs from there.
    void write(engine::CommandChain& chain, std::span<const TargetBox> places);

    device::LentKernel kernel_;
    cl_uint to_ = 0;  ///< the number of its argument for the target
    cl::Buffer boxes_;
    std::vector<TargetBox> planned_;
    std::vector<StoredBox> written_;     ///< the device's boxes, if all writes succeed
    cl::Event last_write_;               ///< null before the first
    std::size_t pieces_ = 1, rows_ = 0;  ///< of the launch: pieces of a row, rows of the largest box
    std::size_t group_rows_ = 1;         ///< rows of a work-group
};

}  // namespace clsdf::targets
