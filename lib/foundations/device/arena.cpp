#include "device/arena.hpp"

#include "core/parallel.hpp"

#include <algorithm>
#include <exception>
#include <utility>

namespace clsdf::device {

std::optional<Arena::Part> Arena::take(std::size_t wanted) {
    const std::scoped_lock lock(mutex_);
    if (block_for(wanted) > 0) return take_in_blocks(wanted);
    const auto best = smallest_fit(large_, wanted);
    if (best == large_.end()) return std::nullopt;
    std::optional<Part> taken(std::move(*best));
    large_.erase(best);
    return taken;
}

std::optional<Arena::Part> Arena::take_in_blocks(std::size_t wanted) {
    const std::size_t bytes = chunk_count(wanted, limits_.alignment) * limits_.alignment;
    for (Block& block : blocks_) {
        const std::optional<std::size_t> offset = block.free.take(bytes);
        if (!offset) continue;
        try {
            const cl_buffer_region region{*offset, wanted};
            Part part{block.buffer.createSubBuffer(CL_MEM_READ_WRITE, CL_BUFFER_CREATE_TYPE_REGION, &region), wanted};
            lent_[part.buffer()] = {block.buffer(), *offset, bytes};
            return part;
        } catch (...) {
            block.free.give_back(*offset, bytes);
            throw;
        }
    }
    return std::nullopt;
}

void Arena::add_block(cl::Buffer buffer, std::size_t bytes) {
    const std::scoped_lock lock(mutex_);
    blocks_.push_back({std::move(buffer), bytes, FreeRanges(bytes)});
}

void Arena::keep(Part part) noexcept {
    try {
        const std::scoped_lock lock(mutex_);
        if (const auto lent = lent_.find(part.buffer()); lent != lent_.end()) {
            const Place place = lent->second;
            lent_.erase(lent);
            part = {};
            give_back(place);
        } else if (part.bytes <= limits_.kept_bytes) {
            large_.push_back(std::move(part));
        }
        keep_within(limits_.kept_bytes);
    } catch (const std::exception&) {
        // No memory to remember it by: a buffer is released, and a part of a block is not lent again.
    }
}

void Arena::give_back(const Place& place) {
    const auto block = std::ranges::find(blocks_, place.block, [](const Block& one) { return one.buffer(); });
    block->free.give_back(place.offset, place.bytes);
}

std::size_t Arena::keep_within(std::size_t most) {
    std::size_t kept = 0, released = 0;
    for (const Part& part : large_) kept += part.bytes;
    for (const Block& block : blocks_)
        if (block.free.are_all_free()) kept += block.bytes;
    const auto release_first = [&](auto& buffers, const auto& condition) {
        std::erase_if(buffers, [&](const auto& buffer) {
            if (kept - released <= most || !condition(buffer)) return false;
            released += buffer.bytes;
            return true;
        });
    };
    release_first(large_, [](const Part&) { return true; });
    release_first(blocks_, [](const Block& block) { return block.free.are_all_free(); });
    return released;
}

std::size_t Arena::release() {
    const std::scoped_lock lock(mutex_);
    return keep_within(0);
}

std::size_t Arena::free_bytes() const {
    const std::scoped_lock lock(mutex_);
    std::size_t bytes = 0;
    for (const Part& part : large_) bytes += part.bytes;
    for (const Block& block : blocks_) bytes += block.free.free_bytes();
    return bytes;
}

}  // namespace clsdf::device
