#include "device/host_filling.hpp"

#include "core/large_memory.hpp"

namespace clsdf::device {

namespace {

void CL_CALLBACK release_array(cl_event, cl_int, void* array) {
    delete[] static_cast<std::byte*>(array);
}

/// Keeps an array until the command that reads it has ended.
void keep_until(const cl::Event& copied, std::unique_ptr<std::byte[]> array) {
    std::byte* const kept = array.release();
    if (clSetEventCallback(copied(), CL_COMPLETE, release_array, kept) == CL_SUCCESS) return;
    copied.wait();  // the array is never released if the driver cannot tell
    delete[] kept;
}

}  // namespace

HostFilling::HostFilling(const Context& context, std::shared_ptr<BufferPool> pool, std::size_t bytes,
                         const char* purpose, bool in_place)
    : context_(context), pool_(std::move(pool)), bytes_(bytes), purpose_(purpose) {
    if (bytes_ > 0 && in_place) {
        buffer_ = pool_->lease(bytes_, purpose_);
        memory_ = guarded([&] {
            return context_.queue().enqueueMapBuffer(*buffer_, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, bytes_);
        });
        is_mapped_ = true;
    } else {
        pool_->check_size(bytes_, purpose_);
        array_ = std::make_unique_for_overwrite<std::byte[]>(bytes_);
        memory_ = array_.get();
    }
    if (bytes_ >= large_memory_bytes) advise_huge_pages(memory_, bytes_);
}

HostFilling::~HostFilling() {
    try {
        if (is_mapped_) unmap();
    } catch (const std::exception&) {
        // On the way out after another error.
    }
}

BufferPool::Lease HostFilling::finish() {
    if (is_mapped_) {
        guarded([&] { unmap(); });
        return std::move(buffer_);
    }
    BufferPool::Lease buffer = pool_->lease(bytes_, purpose_);
    if (bytes_ == 0) return buffer;
    guarded([&] {
        cl::Event copied;
        context_.queue().enqueueWriteBuffer(*buffer, CL_FALSE, 0, bytes_, memory_, nullptr, &copied);
        keep_until(copied, std::move(array_));
        context_.queue().flush();
    });
    return buffer;
}

void HostFilling::unmap() {
    is_mapped_ = false;
    context_.queue().enqueueUnmapMemObject(*buffer_, memory_);
}

}  // namespace clsdf::device
