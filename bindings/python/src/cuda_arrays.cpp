#include "cuda_arrays.hpp"

#include <clsdf/error.hpp>

#include <algorithm>
#include <array>
#include <functional>
#include <ranges>

namespace clsdf::python::cuda {

namespace {

// Plans write to packed arrays that begin at such a multiple without a copy.
constexpr std::size_t alignment = 4096;
constexpr SemaphoreParameters parameters{};

void check_device(const Link& link, const View& view) {
    constexpr int device_ordinal = 9;  // CU_POINTER_ATTRIBUTE_DEVICE_ORDINAL
    int ordinal = -1;
    const Current current(link.context());
    if (driver().pointer_attribute(&ordinal, device_ordinal, view.address) != 0)
        throw Error(ErrorCode::invalid_argument,
                    view.what + " names an address that CUDA's driver does not know; its memory may have been freed");
    if (ordinal == link.ordinal()) return;
    throw Error(ErrorCode::invalid_argument, view.what + " lies on device " + std::to_string(ordinal) +
                                                 " of CUDA, and clsdf computes on device " +
                                                 std::to_string(link.ordinal()) + ", \"" + link.device().name() +
                                                 "\"; move it there, or choose the other device with device=");
}

}  // namespace

Arrays::~Arrays() {
    abandon();
    if (lane_ != nullptr) link_->give_back(std::move(lane_));
}

void Arrays::abandon() noexcept {
    if (!is_locked_) return;
    if (!taken_.empty())
        link_->extensions().release(queue_, static_cast<cl_uint>(taken_.size()), taken_.data(), 0, nullptr, nullptr);
    taken_.clear();
    clFinish(queue_);
    try {
        const Current current(link_->context());
        driver().finish_stream(streams_.front());
        // One may be signalled without a wait: it cannot be used again.
        lane_->semaphores.reset();
    } catch (const Error&) {  // the context has ended
    }
    unlock();
}

cl_mem Arrays::add(const View& view, bool is_written) {
    std::shared_ptr<SharedMemory> shared = shared_memory_at(view.begin);
    // A buffer belongs to one context; that of another is copied.
    if (shared != nullptr && shared->link().device().context() != link_->device().context()) shared = nullptr;
    if (shared == nullptr) check_device(*link_, view);
    entries_.push_back({view, is_written, std::move(shared)});
    add_stream(view.stream);
    return reinterpret_cast<cl_mem>(&entries_.back());
}

void Arrays::add_stream(Stream stream) {
    if (std::ranges::find(streams_, stream) == streams_.end()) streams_.push_back(stream);
}

void Arrays::follow(const std::vector<Stream>& streams) {
    streams_.clear();
    for (const Stream stream : streams) add_stream(stream);
}

void Arrays::place() {
    std::vector<Entry*> copied;
    for (Entry& entry : entries_) {
        if (entry.shared == nullptr) {
            copied.push_back(&entry);
            continue;
        }
        entry.offset = entry.view.address - entry.shared->allocation().address();
        if (std::ranges::find(shared_, entry.shared) == shared_.end()) shared_.push_back(entry.shared);
    }
    std::ranges::sort(shared_);
    std::ranges::sort(copied, std::less<>(), [](const Entry* entry) { return entry->view.begin; });
    std::size_t bytes = 0;
    for (Entry* const entry : copied) {
        const View& view = entry->view;
        if (spans_.empty() || view.begin >= spans_.back().end) {
            if (!spans_.empty()) bytes += spans_.back().end - spans_.back().begin;
            bytes = (bytes + alignment - 1) / alignment * alignment;
            spans_.push_back({view.begin, view.end, !entry->is_written || !view.is_packed, entry->is_written, bytes});
        } else {
            Span& span = spans_.back();
            span.end = std::max(span.end, view.end);
            span.is_read = true;  // bytes of one may lie between those of the other
            span.is_written |= entry->is_written;
        }
        entry->offset = spans_.back().offset + (view.address - spans_.back().begin);
    }
    if (!spans_.empty()) bytes += spans_.back().end - spans_.back().begin;
    lane_ = link_->take_lane(bytes);
}

void Arrays::replace(cl_mem& buffer, std::size_t& offset) const {
    for (const Entry& entry : entries_)
        if (buffer == reinterpret_cast<const _cl_mem*>(&entry)) {
            buffer = entry.shared != nullptr ? entry.shared->allocation().buffer() : lane_->staging->buffer();
            offset = entry.offset;
            return;
        }
}

void Arrays::lock() {
    for (const std::shared_ptr<SharedMemory>& one : shared_) one->mutex.lock();
    is_locked_ = true;
    for (const std::shared_ptr<SharedMemory>& one : shared_) ++one->depth;
}

void Arrays::unlock() noexcept {
    for (const std::shared_ptr<SharedMemory>& one : shared_) {
        --one->depth;
        one->mutex.unlock();
    }
    is_locked_ = false;
}

// The first stream waits for the others, and for the latest user of the lane.
void Arrays::join_streams() {
    const Driver& cuda = driver();
    for (const Stream other : streams_ | std::views::drop(1)) {
        check(cuda.record_event(lane_->crossing, other), "cuEventRecord");
        check(cuda.wait_event(streams_.front(), lane_->crossing, 0), "cuStreamWaitEvent");
    }
    if (lane_->is_recorded) check(cuda.wait_event(streams_.front(), lane_->latest, 0), "cuStreamWaitEvent");
}

void Arrays::copy_in() const {
    for (const Span& span : spans_)
        if (span.is_read)
            check(driver().copy(lane_->staging->address() + span.offset, span.begin, span.end - span.begin,
                                streams_.front()),
                  "cuMemcpyDtoDAsync");
}

// The other streams wait for the copies.
void Arrays::copy_out() {
    const Driver& cuda = driver();
    for (const Span& span : spans_)
        if (span.is_written)
            check(
                cuda.copy(span.begin, lane_->staging->address() + span.offset, span.end - span.begin, streams_.front()),
                "cuMemcpyDtoDAsync");
    check(cuda.record_event(lane_->latest, streams_.front()), "cuEventRecord");
    lane_->is_recorded = true;
    for (const Stream other : streams_ | std::views::drop(1))
        check(cuda.wait_event(other, lane_->latest, 0), "cuStreamWaitEvent");
}

/// Those that no call around this one has acquired.
std::vector<cl_mem> Arrays::buffers() const {
    std::vector<cl_mem> all;
    for (const std::shared_ptr<SharedMemory>& one : shared_)
        if (one->depth == 1) all.push_back(one->allocation().buffer());
    if (!spans_.empty()) all.push_back(lane_->staging->buffer());
    return all;
}

void Arrays::acquire() {
    if (entries_.empty()) return;
    queue_ = own_queue();
    lock();
    {
        const Current current(link_->context());
        join_streams();
        copy_in();
        check(driver().finish_stream(streams_.front()), "cuStreamSynchronize");
    }
    const std::vector<cl_mem> all = buffers();
    if (all.empty()) return;
    ClEvent acquired;
    check_cl(
        link_->extensions().acquire(queue_, static_cast<cl_uint>(all.size()), all.data(), 0, nullptr, acquired.put()),
        "clEnqueueAcquireExternalMemObjectsKHR");
    taken_ = all;
    acquired.wait();
}

void Arrays::release() {
    if (entries_.empty()) return;
    if (!taken_.empty()) {
        ClEvent released;
        check_cl(link_->extensions().release(queue_, static_cast<cl_uint>(taken_.size()), taken_.data(), 0, nullptr,
                                             released.put()),
                 "clEnqueueReleaseExternalMemObjectsKHR");
        taken_.clear();
        released.wait();
    }
    const Current current(link_->context());
    copy_out();
    unlock();
}

ClEvent Arrays::acquire(cl_command_queue queue, std::span<const cl_event> waits) {
    queue_ = queue != nullptr ? queue : own_queue();
    cl_context context = nullptr;
    check_cl(clGetCommandQueueInfo(queue_, CL_QUEUE_CONTEXT, sizeof(cl_context), &context, nullptr),
             "clGetCommandQueueInfo");
    if (context != link_->device().context())
        throw Error(ErrorCode::invalid_argument,
                    "the queue belongs to another context of OpenCL than the plan's device; give a queue of that");
    lock();
    ClEvent reached;
    {
        const Current current(link_->context());
        const bool has_semaphores = link_->has_semaphores();
        if (has_semaphores && lane_->semaphores == nullptr) lane_->semaphores = std::make_unique<Semaphores>(*link_);
        join_streams();
        copy_in();
        if (has_semaphores) {
            const SharedSemaphore& semaphore = lane_->semaphores->to_opencl;
            check(driver().signal(&semaphore.of_cuda, &parameters, 1, streams_.front()),
                  "cuSignalExternalSemaphoresAsync");
            check_cl(
                link_->extensions().wait(queue_, 1, &semaphore.of_opencl, nullptr, static_cast<cl_uint>(waits.size()),
                                         waits.empty() ? nullptr : waits.data(), reached.put()),
                "clEnqueueWaitSemaphoresKHR");
        } else {
            check(driver().finish_stream(streams_.front()), "cuStreamSynchronize");
        }
    }
    const std::vector<cl_mem> all = buffers();
    const std::span<const cl_event> before = reached.list().empty() ? waits : reached.list();
    ClEvent acquired;
    check_cl(link_->extensions().acquire(queue_, static_cast<cl_uint>(all.size()), all.empty() ? nullptr : all.data(),
                                         static_cast<cl_uint>(before.size()), before.empty() ? nullptr : before.data(),
                                         acquired.put()),
             "clEnqueueAcquireExternalMemObjectsKHR");
    taken_ = all;
    return acquired;
}

void Arrays::release(std::span<const cl_event> done) {
    ClEvent released;
    check_cl(link_->extensions().release(queue_, static_cast<cl_uint>(taken_.size()),
                                         taken_.empty() ? nullptr : taken_.data(), static_cast<cl_uint>(done.size()),
                                         done.data(), released.put()),
             "clEnqueueReleaseExternalMemObjectsKHR");
    taken_.clear();
    const Current current(link_->context());
    if (lane_->semaphores != nullptr) {
        const SharedSemaphore& semaphore = lane_->semaphores->to_cuda;
        check_cl(
            link_->extensions().signal(queue_, 1, &semaphore.of_opencl, nullptr, 1, released.list().data(), nullptr),
            "clEnqueueSignalSemaphoresKHR");
        check_cl(clFlush(queue_), "clFlush");
        check(driver().wait(&semaphore.of_cuda, &parameters, 1, streams_.front()), "cuWaitExternalSemaphoresAsync");
    } else {
        check_cl(clFlush(queue_), "clFlush");
        released.wait();
    }
    copy_out();
    unlock();
}

void copy_to_host(const Link& link, const View& view, void* to) {
    const Current current(link.context());
    check(driver().copy_down(to, view.begin, view.end - view.begin, view.stream), "cuMemcpyDtoHAsync");
    check(driver().finish_stream(view.stream), "cuStreamSynchronize");
}

void copy_from_host(const Link& link, const View& view, const void* from) {
    const Current current(link.context());
    check(driver().copy_up(view.begin, from, view.end - view.begin, view.stream), "cuMemcpyHtoDAsync");
    check(driver().finish_stream(view.stream), "cuStreamSynchronize");
}

}  // namespace clsdf::python::cuda
