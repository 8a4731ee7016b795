#include "cuda/lanes.hpp"

#include <clsdf/error.hpp>

#include <algorithm>
#include <functional>
#include <memory>
#include <ranges>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace clsdf::cuda {

namespace {

// Plans write to packed arrays that begin at such a multiple without a copy.
constexpr std::size_t alignment = 4096;
constexpr SemaphoreParameters parameters{};

[[noreturn]] void refuse(const std::string& message) {
    throw Error(ErrorCode::invalid_argument, message);
}

void check_device(const Link& link, const Array& array) {
    constexpr int device_ordinal = 9;  // CU_POINTER_ATTRIBUTE_DEVICE_ORDINAL
    int ordinal = -1;
    const Current current(link.context());
    if (driver().pointer_attribute(&ordinal, device_ordinal, array.address) != 0)
        refuse(array.name + " names an address that CUDA's driver does not know; its memory may have been freed");
    if (ordinal == link.ordinal()) return;
    refuse(array.name + " lies on device " + std::to_string(ordinal) + " of CUDA, and clsdf computes on device " +
           std::to_string(link.ordinal()) + ", \"" + link.device().name() +
           "\"; move it there, or choose the other device for clsdf");
}

struct Entry {
    Array array;
    std::shared_ptr<Block> block{};  ///< in which it is used; null: it is copied
    std::size_t offset = 0;          ///< in its buffer
};

/// Bytes that are copied together.
struct Span {
    Pointer begin, end;
    bool is_read, is_written;
    std::size_t offset;  ///< in the staging memory
};

template <typename Value>
const Value* data_or_null(std::span<const Value> list) {
    return list.empty() ? nullptr : list.data();
}

cl_uint count_of(std::span<const cl_event> list) {
    return static_cast<cl_uint>(list.size());
}

}  // namespace

struct ArraysState {
    enum class Phase { idle, in_call, in_run };

    ArraysState(std::shared_ptr<Link> link_in, std::span<const Array> arrays);

    void find_places();
    void add_stream(Stream stream);
    cl_command_queue own_queue() const { return link->device().queue(); }

    void expect(Phase wanted, const char* call) const;
    void lock(Phase next);
    void unlock() noexcept;
    void join_streams();
    void copy_in() const;
    void copy_out();
    std::vector<cl_mem> buffers() const;
    cl::Event reach_opencl(std::span<const cl_event> waits);
    cl::Event hand_over(Extensions::HandOver call, const char* name, std::span<const cl_mem> memory,
                        std::span<const cl_event> waits) const;
    void leave_opencl(const cl::Event& released);

    std::shared_ptr<Link> link;
    std::vector<Entry> entries{};
    std::vector<Span> spans{};
    std::unique_ptr<Lane> lane{};
    std::vector<Stream> streams{};                 ///< the first one copies and waits; each once
    std::vector<std::shared_ptr<Block>> blocks{};  ///< each once, in the order in which they are locked
    std::vector<cl_mem> taken{};                   ///< acquired, to be released
    cl_command_queue queue = nullptr;              ///< on which
    cl::Event acquired{};                          ///< of the latest run
    cl_event acquired_handle = nullptr;            ///< the same, for spans
    Phase phase = Phase::idle;                     ///< other than idle: the blocks are locked
};

ArraysState::ArraysState(std::shared_ptr<Link> link_in, std::span<const Array> arrays) : link(std::move(link_in)) {
    if (arrays.empty()) refuse("no array in memory of CUDA is given; give one or more");
    for (const Array& array : arrays) {
        if (array.bytes == 0) refuse(array.name + " has 0 bytes; leave it out, or give the bytes of all its items");
        std::shared_ptr<Block> block = block_at(array.address);
        if (block != nullptr &&
            array.bytes > block->allocation().address() + block->allocation().bytes() - array.address)
            refuse(array.name + " has " + std::to_string(array.bytes) +
                   " bytes, and reaches beyond the shared memory in which it begins");
        // A buffer belongs to one context; that of another is copied.
        if (block != nullptr && block->link().device().context() != link->device().context()) block = nullptr;
        if (block == nullptr) check_device(*link, array);
        entries.push_back({array, std::move(block)});
        add_stream(array.stream);
    }
    find_places();
}

void ArraysState::add_stream(Stream stream) {
    if (std::ranges::find(streams, named(stream)) == streams.end()) streams.push_back(named(stream));
}

void ArraysState::find_places() {
    std::vector<Entry*> copied;
    for (Entry& entry : entries) {
        if (entry.block == nullptr) {
            copied.push_back(&entry);
            continue;
        }
        entry.offset = entry.array.address - entry.block->allocation().address();
        if (std::ranges::find(blocks, entry.block) == blocks.end()) blocks.push_back(entry.block);
    }
    std::ranges::sort(blocks);
    std::ranges::sort(copied, std::less<>(), [](const Entry* entry) { return entry->array.address; });
    std::size_t bytes = 0;
    for (Entry* const entry : copied) {
        const Array& array = entry->array;
        const Pointer end = array.address + array.bytes;
        const bool is_written = array.access != Access::read;
        if (spans.empty() || array.address >= spans.back().end) {
            if (!spans.empty()) bytes += spans.back().end - spans.back().begin;
            bytes = (bytes + alignment - 1) / alignment * alignment;
            spans.push_back({array.address, end, array.access != Access::write, is_written, bytes});
        } else {
            Span& span = spans.back();
            span.end = std::max(span.end, end);
            span.is_read = true;  // bytes of one may lie between those of the other
            span.is_written |= is_written;
        }
        entry->offset = spans.back().offset + (array.address - spans.back().begin);
    }
    if (!spans.empty()) bytes += spans.back().end - spans.back().begin;
    lane = link->take_lane(bytes);
}

void ArraysState::expect(Phase wanted, const char* call) const {
    if (phase == wanted) return;
    if (wanted == Phase::idle)
        refuse(std::string(call) +
               " of arrays of CUDA comes before the end() of the call before; call end(), or "
               "abandon() after an error");
    refuse(std::string(call) +
           " of arrays of CUDA without its begin(): begin() belongs to end(), and begin(queue) to "
           "end(done)");
}

void ArraysState::lock(Phase next) {
    for (const std::shared_ptr<Block>& block : blocks) block->mutex.lock();
    phase = next;
    for (const std::shared_ptr<Block>& block : blocks) ++block->depth;
}

void ArraysState::unlock() noexcept {
    for (const std::shared_ptr<Block>& block : blocks) {
        --block->depth;
        block->mutex.unlock();
    }
    phase = Phase::idle;
}

// The first stream waits for the others, and for the latest user of the lane.
void ArraysState::join_streams() {
    const Driver& cuda = driver();
    for (const Stream other : streams | std::views::drop(1)) {
        check(cuda.record_event(lane->crossing, other), "cuEventRecord");
        check(cuda.wait_event(streams.front(), lane->crossing, 0), "cuStreamWaitEvent");
    }
    if (lane->is_recorded) check(cuda.wait_event(streams.front(), lane->latest, 0), "cuStreamWaitEvent");
}

void ArraysState::copy_in() const {
    for (const Span& span : spans)
        if (span.is_read)
            check(driver().copy(lane->staging->address() + span.offset, span.begin, span.end - span.begin,
                                streams.front()),
                  "cuMemcpyDtoDAsync");
}

// The other streams wait for the copies.
void ArraysState::copy_out() {
    const Driver& cuda = driver();
    for (const Span& span : spans)
        if (span.is_written)
            check(cuda.copy(span.begin, lane->staging->address() + span.offset, span.end - span.begin, streams.front()),
                  "cuMemcpyDtoDAsync");
    check(cuda.record_event(lane->latest, streams.front()), "cuEventRecord");
    lane->is_recorded = true;
    for (const Stream other : streams | std::views::drop(1))
        check(cuda.wait_event(other, lane->latest, 0), "cuStreamWaitEvent");
}

/// Those that no call around this one has acquired.
std::vector<cl_mem> ArraysState::buffers() const {
    std::vector<cl_mem> all;
    for (const std::shared_ptr<Block>& block : blocks)
        if (block->depth == 1) all.push_back(block->allocation().buffer());
    if (!spans.empty()) all.push_back(lane->staging->buffer());
    return all;
}

cl::Event ArraysState::hand_over(Extensions::HandOver call, const char* name, std::span<const cl_mem> memory,
                                 std::span<const cl_event> waits) const {
    cl::Event done;
    check_cl(call(queue, static_cast<cl_uint>(memory.size()), data_or_null(memory), count_of(waits),
                  data_or_null(waits), &done()),
             name);
    return done;
}

/// The arrays' bytes are there for OpenCL after the event, or, if it is null, now. Without semaphores this waits.
cl::Event ArraysState::reach_opencl(std::span<const cl_event> waits) {
    const Current current(link->context());
    const bool has_semaphores = link->has_semaphores();
    if (has_semaphores && lane->semaphores == nullptr) lane->semaphores = std::make_unique<Semaphores>(*link);
    join_streams();
    copy_in();
    cl::Event reached;
    if (has_semaphores) {
        const SharedSemaphore& semaphore = lane->semaphores->to_opencl;
        check(driver().signal(&semaphore.of_cuda, &parameters, 1, streams.front()), "cuSignalExternalSemaphoresAsync");
        check_cl(link->extensions().wait(queue, 1, &semaphore.of_opencl, nullptr, count_of(waits), data_or_null(waits),
                                         &reached()),
                 "clEnqueueWaitSemaphoresKHR");
    } else {
        check(driver().finish_stream(streams.front()), "cuStreamSynchronize");
    }
    return reached;
}

/// The streams go on after the event, with the results. Without semaphores this waits.
void ArraysState::leave_opencl(const cl::Event& released) {
    const Current current(link->context());
    if (lane->semaphores != nullptr) {
        const SharedSemaphore& semaphore = lane->semaphores->to_cuda;
        check_cl(link->extensions().signal(queue, 1, &semaphore.of_opencl, nullptr, 1, &released(), nullptr),
                 "clEnqueueSignalSemaphoresKHR");
        check_cl(clFlush(queue), "clFlush");
        check(driver().wait(&semaphore.of_cuda, &parameters, 1, streams.front()), "cuWaitExternalSemaphoresAsync");
    } else {
        check_cl(clFlush(queue), "clFlush");
        check_cl(clWaitForEvents(1, &released()), "clWaitForEvents");
    }
    copy_out();
}

Arrays::Arrays(const SharedDevice& device, std::span<const Array> arrays)
    : state_(std::make_unique<ArraysState>(device.link_, arrays)) {}

Arrays::~Arrays() {
    abandon();
    state_->link->give_back(std::move(state_->lane));
}

DeviceRange Arrays::operator[](std::size_t number) const {
    if (number >= state_->entries.size())
        refuse("there is no array " + std::to_string(number) + "; there are " + std::to_string(state_->entries.size()));
    const Entry& entry = state_->entries[number];
    const Allocation& memory = entry.block != nullptr ? entry.block->allocation() : *state_->lane->staging;
    return {memory.buffer(), entry.offset};
}

InputArray Arrays::input(std::size_t number, ElementType type, std::size_t count) const {
    const DeviceRange place = (*this)[number];
    InputArray array(place.memory, type, count);
    array.offset = place.offset;
    return array;
}

OutputArray Arrays::output(std::size_t number, ElementType type) const {
    const DeviceRange place = (*this)[number];
    OutputArray array(place.memory, type);
    array.offset = place.offset;
    return array;
}

void Arrays::begin() {
    ArraysState& self = *state_;
    self.expect(ArraysState::Phase::idle, "begin()");
    self.queue = self.own_queue();
    self.lock(ArraysState::Phase::in_call);
    {
        const Current current(self.link->context());
        self.join_streams();
        self.copy_in();
        check(driver().finish_stream(self.streams.front()), "cuStreamSynchronize");
    }
    const std::vector<cl_mem> all = self.buffers();
    if (all.empty()) return;
    const cl::Event acquired =
        self.hand_over(self.link->extensions().acquire, "clEnqueueAcquireExternalMemObjectsKHR", all, {});
    self.taken = all;
    check_cl(clWaitForEvents(1, &acquired()), "clWaitForEvents");
}

void Arrays::end() {
    ArraysState& self = *state_;
    self.expect(ArraysState::Phase::in_call, "end()");
    if (!self.taken.empty()) {
        const cl::Event released =
            self.hand_over(self.link->extensions().release, "clEnqueueReleaseExternalMemObjectsKHR", self.taken, {});
        self.taken.clear();
        check_cl(clWaitForEvents(1, &released()), "clWaitForEvents");
    }
    const Current current(self.link->context());
    self.copy_out();
    self.unlock();
}

std::span<const cl_event> Arrays::begin(cl_command_queue queue, std::span<const cl_event> wait_list) {
    ArraysState& self = *state_;
    self.expect(ArraysState::Phase::idle, "begin(queue)");
    self.queue = queue != nullptr ? queue : self.own_queue();
    cl_context context = nullptr;
    check_cl(clGetCommandQueueInfo(self.queue, CL_QUEUE_CONTEXT, sizeof(cl_context), &context, nullptr),
             "clGetCommandQueueInfo");
    if (context != self.link->device().context())
        refuse("the queue belongs to another context of OpenCL than the plan's device; give a queue of that");
    self.lock(ArraysState::Phase::in_run);
    const cl::Event reached = self.reach_opencl(wait_list);
    const cl_event reached_handle = reached();
    const std::span<const cl_event> before =
        reached_handle == nullptr ? wait_list : std::span<const cl_event>(&reached_handle, 1);
    const std::vector<cl_mem> all = self.buffers();
    self.acquired =
        self.hand_over(self.link->extensions().acquire, "clEnqueueAcquireExternalMemObjectsKHR", all, before);
    self.taken = all;
    self.acquired_handle = self.acquired();
    return {&self.acquired_handle, 1};
}

void Arrays::end(cl_event done) {
    ArraysState& self = *state_;
    self.expect(ArraysState::Phase::in_run, "end(done)");
    if (done == nullptr) refuse("end(done) of arrays of CUDA has no event; give that of the run's end");
    const cl::Event released = self.hand_over(self.link->extensions().release, "clEnqueueReleaseExternalMemObjectsKHR",
                                              self.taken, {&done, 1});
    self.taken.clear();
    self.leave_opencl(released);
    self.unlock();
}

void Arrays::abandon() noexcept {
    ArraysState& self = *state_;
    if (self.phase == ArraysState::Phase::idle) return;
    if (!self.taken.empty())
        self.link->extensions().release(self.queue, static_cast<cl_uint>(self.taken.size()), self.taken.data(), 0,
                                        nullptr, nullptr);
    self.taken.clear();
    clFinish(self.queue);
    try {
        const Current current(self.link->context());
        driver().finish_stream(self.streams.front());
        // One may be signalled without a wait: it cannot be used again.
        self.lane->semaphores.reset();
    } catch (const Error&) {  // the context has ended
    }
    self.unlock();
}

void Arrays::follow(std::span<void* const> streams) {
    ArraysState& self = *state_;
    self.expect(ArraysState::Phase::idle, "follow()");
    if (streams.empty()) refuse("follow() of arrays of CUDA has no stream; give one or more");
    self.streams.clear();
    for (void* const stream : streams) self.add_stream(stream);
}

}  // namespace clsdf::cuda
