#include "handles.hpp"
#include "structs.hpp"
#include "values.hpp"

#include <clsdf/cuda.hpp>

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

using namespace clsdf;
using c::given;
using c::guarded;
using c::made;
using c::of;

struct clsdf_cuda_device : clsdf::c::Counted<clsdf_cuda_device> {
    static constexpr clsdf::c::Kind own_kind = clsdf::c::Kind::cuda_device;
    cuda::SharedDevice device;

    explicit clsdf_cuda_device(const Device& device_in) : device(device_in) {}
};

struct clsdf_cuda_memory : clsdf::c::Counted<clsdf_cuda_memory> {
    static constexpr clsdf::c::Kind own_kind = clsdf::c::Kind::cuda_memory;
    cuda::SharedMemory memory;

    clsdf_cuda_memory(const cuda::SharedDevice& device, std::size_t bytes) : memory(device, bytes) {}
};

struct clsdf_cuda_arrays : clsdf::c::Counted<clsdf_cuda_arrays> {
    static constexpr clsdf::c::Kind own_kind = clsdf::c::Kind::cuda_arrays;
    cuda::Arrays arrays;

    clsdf_cuda_arrays(const cuda::SharedDevice& device, std::span<const cuda::Array> used) : arrays(device, used) {}
};

namespace {

cuda::Array array_of(const clsdf_cuda_array& from) {
    c::check_reserved(from.reserved, "clsdf_cuda_array");
    cuda::Array array{from.address, c::count_of(from.bytes, "clsdf_cuda_array.bytes"),
                      c::enumerator(from.access, cuda::Access::update, "clsdf_cuda_array.access"), from.stream};
    array.name = c::text_or(from.name, array.name.c_str());
    return array;
}

}  // namespace

void clsdf_cuda_device_retain(clsdf_cuda_device* device) {
    c::retain(device);
}

void clsdf_cuda_device_release(clsdf_cuda_device* device) {
    c::release(device);
}

void clsdf_cuda_memory_retain(clsdf_cuda_memory* memory) {
    c::retain(memory);
}

void clsdf_cuda_memory_release(clsdf_cuda_memory* memory) {
    c::release(memory);
}

void clsdf_cuda_arrays_retain(clsdf_cuda_arrays* arrays) {
    c::retain(arrays);
}

void clsdf_cuda_arrays_release(clsdf_cuda_arrays* arrays) {
    c::release(arrays);
}

clsdf_status clsdf_cuda_device_create(const clsdf_device* device, clsdf_cuda_device** cuda_device) {
    return made(cuda_device, "cuda_device", [&] { return new clsdf_cuda_device(of(device).device); });
}

clsdf_status clsdf_cuda_device_ordinal(const clsdf_cuda_device* device, std::int32_t* ordinal) {
    return guarded([&] { given(ordinal, "ordinal") = of(device).device.ordinal(); });
}

clsdf_status clsdf_cuda_device_has_semaphores(const clsdf_cuda_device* device, std::int32_t* has_semaphores) {
    return guarded([&] { given(has_semaphores, "has_semaphores") = of(device).device.has_semaphores() ? 1 : 0; });
}

clsdf_status clsdf_cuda_device_release_memory(const clsdf_cuda_device* device, std::int64_t* bytes) {
    return guarded([&] {
        const std::size_t released = of(device).device.release_memory();
        if (bytes != nullptr) *bytes = static_cast<std::int64_t>(released);
    });
}

clsdf_status clsdf_cuda_memory_create(const clsdf_cuda_device* device, std::int64_t bytes, clsdf_cuda_memory** memory) {
    return made(memory, "memory",
                [&] { return new clsdf_cuda_memory(of(device).device, c::count_of(bytes, "bytes")); });
}

clsdf_status clsdf_cuda_memory_place(const clsdf_cuda_memory* memory, std::uint64_t* address, std::int64_t* bytes,
                                     void** buffer) {
    return guarded([&] {
        const cuda::SharedMemory& self = of(memory).memory;
        if (address != nullptr) *address = self.address();
        if (bytes != nullptr) *bytes = static_cast<std::int64_t>(self.bytes());
        if (buffer != nullptr) *buffer = self.buffer();
    });
}

clsdf_status clsdf_cuda_arrays_create(const clsdf_cuda_device* device, const clsdf_cuda_array* used, std::int64_t count,
                                      clsdf_cuda_arrays** arrays) {
    return made(arrays, "arrays", [&] {
        const cuda::SharedDevice& self = of(device).device;
        c::elements(used, count, "used");
        std::vector<cuda::Array> all;
        for (std::int64_t index = 0; index < count; ++index) all.push_back(array_of(used[index]));
        return new clsdf_cuda_arrays(self, all);
    });
}

clsdf_status clsdf_cuda_arrays_get(const clsdf_cuda_arrays* arrays, std::int64_t index, std::int32_t type,
                                   std::int64_t count, clsdf_array* array) {
    return guarded([&] {
        const DeviceRange range = of(arrays).arrays[c::count_of(index, "index")];
        c::enumerator(type, ElementType::uint8, "type");
        c::count_of(count, "count");
        clsdf_array& result = given(array, "array");
        result = clsdf_buffer_array(type, range.memory, count);
        result.offset = static_cast<std::int64_t>(range.offset);
    });
}

clsdf_status clsdf_cuda_arrays_begin(clsdf_cuda_arrays* arrays) {
    return guarded([&] { of(arrays).arrays.begin(); });
}

clsdf_status clsdf_cuda_arrays_end(clsdf_cuda_arrays* arrays) {
    return guarded([&] { of(arrays).arrays.end(); });
}

clsdf_status clsdf_cuda_arrays_begin_run(clsdf_cuda_arrays* arrays, void* queue, void* const* wait_list,
                                         std::int64_t wait_count, void** event) {
    return made(event, "event", [&]() -> void* {
        cuda::Arrays& self = of(arrays).arrays;
        const std::vector<cl_event> events = c::events_of(wait_list, wait_count);
        return self.begin(static_cast<cl_command_queue>(queue), events).front();
    });
}

clsdf_status clsdf_cuda_arrays_end_run(clsdf_cuda_arrays* arrays, void* done) {
    return guarded([&] { of(arrays).arrays.end(static_cast<cl_event>(done)); });
}

clsdf_status clsdf_cuda_arrays_abandon(clsdf_cuda_arrays* arrays) {
    return guarded([&] { of(arrays).arrays.abandon(); });
}

clsdf_status clsdf_cuda_arrays_follow(clsdf_cuda_arrays* arrays, void* const* streams, std::int64_t count) {
    return guarded([&] {
        cuda::Arrays& self = of(arrays).arrays;
        c::elements(streams, count, "streams");
        self.follow(std::span(streams, static_cast<std::size_t>(count)));
    });
}
