// Streams, events and external semaphores of the stand-in for CUDA's driver.
#include "disguise/cuda/driver.hpp"

#include <unistd.h>
#include <array>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <functional>
#include <map>
#include <mutex>
#include <queue>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace clsdf::cuda_stand_in {

namespace {

/// A thread that runs commands in their order.
class Stream {
public:
    Stream() {
        std::thread([this] { run(); }).detach();
    }

    void add(std::function<void()> command) {
        const std::scoped_lock lock(mutex_);
        commands_.push(std::move(command));
        ++added_;
        changed_.notify_all();
    }

    void finish() {
        std::unique_lock lock(mutex_);
        const std::uint64_t last = added_;
        changed_.wait(lock, [&] { return done_ >= last; });
    }

private:
    [[noreturn]] void run() {
        for (;;) {
            std::function<void()> command;
            {
                std::unique_lock lock(mutex_);
                changed_.wait(lock, [&] { return !commands_.empty(); });
                command = std::move(commands_.front());
                commands_.pop();
            }
            command();
            command = nullptr;
            const std::scoped_lock lock(mutex_);
            ++done_;
            changed_.notify_all();
        }
    }

    std::mutex mutex_;
    std::condition_variable changed_;
    std::queue<std::function<void()>> commands_;
    std::uint64_t added_ = 0, done_ = 0;
};

struct Streams {
    std::mutex mutex;
    std::vector<Stream*> all;  ///< never destroyed: their threads wait for commands
};
Streams& streams() {
    static auto* const only = new Streams;
    return *only;
}

Stream* new_stream() {
    auto* const stream = new Stream;
    const std::scoped_lock lock(streams().mutex);
    streams().all.push_back(stream);
    return stream;
}

/// 0, CU_STREAM_LEGACY and CU_STREAM_PER_THREAD are one stream here. Null for a handle that is none.
Stream* stream_of(void* handle) {
    static Stream* const legacy = new_stream();
    if (reinterpret_cast<std::uintptr_t>(handle) <= 2) return legacy;
    const std::scoped_lock lock(streams().mutex);
    for (Stream* const stream : streams().all)
        if (stream == handle) return stream;
    return nullptr;
}

/// Numbers of the last record and of the last one that its stream has reached.
struct Event {
    std::mutex mutex;
    std::condition_variable changed;
    std::uint64_t recorded = 0, reached = 0;

    void wait_for(std::uint64_t number) {
        std::unique_lock lock(mutex);
        changed.wait(lock, [&] { return reached >= number; });
    }
};
using OwnedEvent = std::shared_ptr<Event>;
using OwnedSemaphore = std::shared_ptr<int>;  // an eventfd

struct SemaphoreDescription {
    int type;
    union {
        int descriptor;
        struct {
            void* handle;
            const void* name;
        } win32;
    } handle;
    unsigned flags;
    unsigned reserved[16];
};
static_assert(sizeof(SemaphoreDescription) == 96);

Result copy(std::uint64_t to, std::uint64_t from, std::size_t size, void* handle) {
    Stream* const stream = stream_of(handle);
    if (stream == nullptr) return invalid_handle;
    const Bytes target = bytes_at(to, size), source = bytes_at(from, size);
    if (target.address == nullptr || source.address == nullptr) return invalid_value;
    stream->add([=] { std::memmove(target.address, source.address, size); });
    return success;
}

}  // namespace

void finish_all() {
    std::vector<Stream*> all;
    {
        const std::scoped_lock lock(streams().mutex);
        all = streams().all;
    }
    for (Stream* const stream : all) stream->finish();
}

}  // namespace clsdf::cuda_stand_in

using namespace clsdf::cuda_stand_in;

extern "C" {

Result cuStreamCreate(void** stream, unsigned flags) {
    if (const Result code = begin_in_context("cuStreamCreate")) return code;
    constexpr unsigned non_blocking = 1;
    if (flags != non_blocking) return not_supported;
    *stream = new_stream();
    return success;
}

Result cuStreamDestroy_v2(void* stream) {
    if (const Result code = begin_in_context("cuStreamDestroy_v2")) return code;
    return stream_of(stream) == nullptr ? invalid_handle : success;
}

Result cuStreamSynchronize(void* handle) {
    if (const Result code = begin_in_context("cuStreamSynchronize")) return code;
    Stream* const stream = stream_of(handle);
    if (stream == nullptr) return invalid_handle;
    stream->finish();
    return success;
}

Result cuLaunchHostFunc(void* handle, void (*function)(void*), void* user) {
    if (const Result code = begin_in_context("cuLaunchHostFunc")) return code;
    Stream* const stream = stream_of(handle);
    if (stream == nullptr) return invalid_handle;
    stream->add([=] { function(user); });
    return success;
}

Result cuMemcpyDtoDAsync_v2(std::uint64_t to, std::uint64_t from, std::size_t size, void* stream) {
    if (const Result code = begin_in_context("cuMemcpyDtoDAsync_v2")) return code;
    return copy(to, from, size, stream);
}

Result cuMemcpyHtoDAsync_v2(std::uint64_t to, const void* from, std::size_t size, void* handle) {
    if (const Result code = begin_in_context("cuMemcpyHtoDAsync_v2")) return code;
    Stream* const stream = stream_of(handle);
    if (stream == nullptr) return invalid_handle;
    const Bytes target = bytes_at(to, size);
    if (target.address == nullptr) return invalid_value;
    // Pageable memory: it may change when the call returns.
    std::vector<char> content(static_cast<const char*>(from), static_cast<const char*>(from) + size);
    stream->add(
        [target, content = std::move(content)] { std::memcpy(target.address, content.data(), content.size()); });
    return success;
}

Result cuMemcpyDtoHAsync_v2(void* to, std::uint64_t from, std::size_t size, void* handle) {
    if (const Result code = begin_in_context("cuMemcpyDtoHAsync_v2")) return code;
    Stream* const stream = stream_of(handle);
    if (stream == nullptr) return invalid_handle;
    const Bytes source = bytes_at(from, size);
    if (source.address == nullptr) return invalid_value;
    stream->add([=] { std::memcpy(to, source.address, size); });
    stream->finish();  // pageable memory
    return success;
}

Result cuEventCreate(void** event, unsigned) {
    if (const Result code = begin_in_context("cuEventCreate")) return code;
    *event = new OwnedEvent(std::make_shared<Event>());
    return success;
}

Result cuEventDestroy_v2(void* event) {
    if (const Result code = begin("cuEventDestroy_v2")) return code;
    delete static_cast<OwnedEvent*>(event);
    return success;
}

Result cuEventRecord(void* event, void* handle) {
    if (const Result code = begin_in_context("cuEventRecord")) return code;
    Stream* const stream = stream_of(handle);
    if (stream == nullptr) return invalid_handle;
    const OwnedEvent own = *static_cast<OwnedEvent*>(event);
    std::uint64_t number = 0;
    {
        const std::scoped_lock lock(own->mutex);
        number = ++own->recorded;
    }
    stream->add([own, number] {
        const std::scoped_lock lock(own->mutex);
        own->reached = std::max(own->reached, number);
        own->changed.notify_all();
    });
    return success;
}

Result cuStreamWaitEvent(void* handle, void* event, unsigned flags) {
    if (const Result code = begin_in_context("cuStreamWaitEvent")) return code;
    Stream* const stream = stream_of(handle);
    if (stream == nullptr) return invalid_handle;
    if (flags != 0) return invalid_value;
    const OwnedEvent own = *static_cast<OwnedEvent*>(event);
    std::uint64_t number = 0;
    {
        const std::scoped_lock lock(own->mutex);
        number = own->recorded;
    }
    stream->add([own, number] { own->wait_for(number); });
    return success;
}

Result cuEventQuery(void* event) {
    if (const Result code = begin_in_context("cuEventQuery")) return code;
    const OwnedEvent own = *static_cast<OwnedEvent*>(event);
    const std::scoped_lock lock(own->mutex);
    return own->reached >= own->recorded ? success : not_ready;
}

Result cuEventSynchronize(void* event) {
    if (const Result code = begin_in_context("cuEventSynchronize")) return code;
    const OwnedEvent own = *static_cast<OwnedEvent*>(event);
    std::uint64_t number = 0;
    {
        const std::scoped_lock lock(own->mutex);
        number = own->recorded;
    }
    own->wait_for(number);
    return success;
}

Result cuImportExternalSemaphore(void** semaphore, const SemaphoreDescription* description) {
    if (const Result code = begin_in_context("cuImportExternalSemaphore")) return code;
    constexpr int opaque_descriptor = 1;
    if (description->type != opaque_descriptor || description->flags != 0) return not_supported;
    std::array<char, 64> name{};
    const std::string link = "/proc/self/fd/" + std::to_string(description->handle.descriptor);
    if (::readlink(link.c_str(), name.data(), name.size() - 1) < 0 || std::strstr(name.data(), "[eventfd]") == nullptr)
        return invalid_handle;
    *semaphore = new OwnedSemaphore(new int(description->handle.descriptor), [](const int* own) {
        ::close(*own);
        delete own;
    });
    return success;
}

Result cuDestroyExternalSemaphore(void* semaphore) {
    if (const Result code = begin("cuDestroyExternalSemaphore")) return code;
    delete static_cast<OwnedSemaphore*>(semaphore);
    return success;
}

Result cuSignalExternalSemaphoresAsync(void* const* semaphores, const void* parameters, unsigned count, void* handle) {
    if (const Result code = begin_in_context("cuSignalExternalSemaphoresAsync")) return code;
    Stream* const stream = stream_of(handle);
    if (stream == nullptr) return invalid_handle;
    if (parameters == nullptr) return invalid_value;
    for (unsigned n = 0; n < count; ++n)
        stream->add([own = *static_cast<OwnedSemaphore*>(semaphores[n])] {
            const std::uint64_t one = 1;
            if (::write(*own, &one, sizeof one) < 0) errno = 0;
        });
    return success;
}

Result cuWaitExternalSemaphoresAsync(void* const* semaphores, const void* parameters, unsigned count, void* handle) {
    if (const Result code = begin_in_context("cuWaitExternalSemaphoresAsync")) return code;
    Stream* const stream = stream_of(handle);
    if (stream == nullptr) return invalid_handle;
    if (parameters == nullptr) return invalid_value;
    for (unsigned n = 0; n < count; ++n)
        stream->add([own = *static_cast<OwnedSemaphore*>(semaphores[n])] {
            std::uint64_t value = 0;
            if (::read(*own, &value, sizeof value) < 0) errno = 0;
        });
    return success;
}
}
