#include "transform/blocks.hpp"

#include "core/outputs.hpp"
#include "transform/requests.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

namespace clsdf::transform {

namespace {

/// Bytes from a block's first value to that of the next block.
std::ptrdiff_t block_stride(const OutputInfo& info, const OutputArray& array, std::size_t samples, std::size_t blocks) {
    const bool is_packed = array.strides == ArrayLayout().strides && array.component_stride == 0;
    if (array.block_stride == 0 && !is_packed && blocks > 1)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("the array of the output {} has strides and no block stride; set it, too", info.name));
    const std::size_t element = array.type == ElementType::automatic ? bytes_of(info.type) : bytes_of(array.type);
    const std::size_t packed = samples * info.components * element;
    if (array.block_stride == 0 && is_packed && array.host != nullptr && array.bytes != ArrayLayout::unknown_size &&
        array.bytes != array.offset + blocks * packed)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("{} blocks of {} samples take {} bytes of the output {}, and its array holds {}",
                                blocks, samples, blocks * packed, info.name, array.bytes - array.offset));
    return array.block_stride != 0 ? array.block_stride : static_cast<std::ptrdiff_t>(packed);
}

}  // namespace

std::vector<Request> requests_of(const BlockSet& blocks, std::size_t begin, std::size_t end) {
    Grid block = blocks.lattice;
    block.first = {};
    block.size = blocks.size;
    block.validate();
    const std::size_t samples = block.sample_count(), count = blocks.first.size();
    std::vector<std::ptrdiff_t> strides;
    for (const OutputTarget& target : blocks.targets.all()) {
        const OutputInfo& info = info_of(target.output);
        strides.push_back(block_stride(info, target.array, samples, count));
        if (count > 0 && strides.back() < 0 &&
            static_cast<double>(target.array.offset) <
                -static_cast<double>(strides.back()) * static_cast<double>(count - 1))
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("the block stride of the output {} is {}, which leads before its memory; let the "
                                    "offset name the first block",
                                    info.name, strides.back()));
    }
    std::vector<Request> requests;
    requests.reserve(end - begin);
    for (std::size_t n = begin; n < end; ++n) {
        Request& request = requests.emplace_back(Request{block, blocks.band, {}});
        request.grid.first = blocks.first[n];
        std::size_t number = 0;
        for (const OutputTarget& target : blocks.targets.all()) {
            OutputArray& array = request.targets[target.output];
            array = target.array;
            array.block_stride = 0;
            array.offset += static_cast<std::size_t>(strides[number++] * static_cast<std::ptrdiff_t>(n));
            // An array with an offset may be larger than what is written to it.
            if (array.offset == 0 && array.strides == ArrayLayout().strides && array.component_stride == 0 &&
                array.bytes != ArrayLayout::unknown_size)
                array.component_stride = static_cast<std::ptrdiff_t>(
                    bytes_of(array.type == ElementType::automatic ? info_of(target.output).type : array.type));
        }
    }
    return requests;
}

}  // namespace clsdf::transform
