#include "handles.hpp"
#include "values.hpp"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

struct clsdf_thread_limit : clsdf::c::Counted<clsdf_thread_limit> {
    static constexpr clsdf::c::Kind own_kind = clsdf::c::Kind::thread_limit;
    tbb::global_control control;

    explicit clsdf_thread_limit(std::size_t threads) : control(tbb::global_control::max_allowed_parallelism, threads) {}
};

using namespace clsdf;
using c::guarded;
using c::made;
using c::of;

namespace {

clsdf_device_info as_c(const DeviceInfo& info) {
    clsdf_device_info result = CLSDF_DEVICE_INFO_INIT;
    result.index = info.index == DeviceInfo::not_listed ? -1 : static_cast<std::int64_t>(info.index);
    result.id = info.id;
    result.name = info.name.c_str();
    result.platform = info.platform.c_str();
    result.version = info.version.c_str();
    result.driver = info.driver.c_str();
    result.why_not = info.why_not.c_str();
    result.compute_units = info.compute_units;
    result.clock_megahertz = info.clock_megahertz;
    result.memory = static_cast<std::int64_t>(info.memory);
    result.largest_allocation = static_cast<std::int64_t>(info.largest_allocation);
    result.float_width = info.float_width;
    result.kind = static_cast<std::int32_t>(info.kind);
    result.fp64 = info.fp64 ? 1 : 0;
    result.atomics64 = info.atomics64 ? 1 : 0;
    result.source = static_cast<std::int32_t>(info.source);
    result.driver_file = info.driver_file.c_str();
    result.only_if_named = info.only_if_named.c_str();
    return result;
}

}  // namespace

clsdf_status clsdf_devices_list(clsdf_devices** devices) {
    return made(devices, "devices", [] {
        auto list = std::make_unique<clsdf_devices>();
        list->infos = Device::all();
        return list.release();
    });
}

std::int64_t clsdf_devices_count(const clsdf_devices* devices) {
    return devices == nullptr || devices->kind != clsdf_devices::own_kind
               ? 0
               : static_cast<std::int64_t>(devices->infos.size());
}

clsdf_status clsdf_devices_describe(const clsdf_devices* devices, std::int64_t index, clsdf_device_info* info) {
    return guarded([&] {
        const std::vector<DeviceInfo>& infos = of(devices).infos;
        if (c::count_of(index, "index") >= infos.size())
            throw c::misuse("there is no device " + std::to_string(index) + "; the list has " +
                            std::to_string(infos.size()));
        c::write_given(as_c(infos[static_cast<std::size_t>(index)]), info, "clsdf_device_info");
    });
}

clsdf_status clsdf_device_strongest(clsdf_device** device) {
    return made(device, "device", [] { return new clsdf_device(Device::strongest()); });
}

clsdf_status clsdf_device_select(const char* index_or_part, clsdf_device** device) {
    return made(device, "device",
                [&] { return new clsdf_device(Device::select(c::text_of(index_or_part, "index_or_part"))); });
}

clsdf_status clsdf_device_automatic(clsdf_device** device) {
    return made(device, "device", [] { return new clsdf_device(Device::automatic()); });
}

clsdf_status clsdf_device_of_rank(std::int64_t rank, std::int64_t ranks, clsdf_device** device) {
    return made(device, "device", [&] {
        return new clsdf_device(Device::of_rank(c::count_of(rank, "rank"), c::count_of(ranks, "ranks")));
    });
}

clsdf_status clsdf_device_from_handles(void* context, void* id, void* queue, clsdf_device** device) {
    return made(device, "device", [&] {
        return new clsdf_device(Device::from_handles(static_cast<cl_context>(context), static_cast<cl_device_id>(id),
                                                     static_cast<cl_command_queue>(queue)));
    });
}

clsdf_status clsdf_device_limited(const clsdf_device* device, const clsdf_device_limits* limits,
                                  clsdf_device** limited) {
    return made(limited, "limited", [&] {
        const clsdf_device_limits from = c::read_struct(limits, CLSDF_DEVICE_LIMITS_INIT, "clsdf_device_limits");
        DeviceLimits to;
        const std::size_t units = c::count_of(from.compute_units, "clsdf_device_limits.compute_units");
        const std::size_t memory = c::count_of(from.memory, "clsdf_device_limits.memory");
        if (units > 0) to.compute_units = static_cast<unsigned>(std::min<std::size_t>(units, 0xFFFFFFFFU));
        if (memory > 0) to.memory = memory;
        return new clsdf_device(of(device).device.limited(to));
    });
}

clsdf_status clsdf_device_describe(const clsdf_device* device, clsdf_device_info* info) {
    return guarded([&] {
        const clsdf_device& self = of(device);
        std::call_once(self.is_described, [&] { self.info = self.device.info(); });
        c::write_given(as_c(self.info), info, "clsdf_device_info");
    });
}

clsdf_status clsdf_device_handles(const clsdf_device* device, void** context, void** id, void** queue) {
    return guarded([&] {
        const Device& self = of(device).device;
        if (context != nullptr) *context = self.context();
        if (id != nullptr) *id = self.id();
        if (queue != nullptr) *queue = self.queue();
    });
}

clsdf_status clsdf_device_import_memory(const clsdf_device* device, std::int32_t descriptor, std::int64_t bytes,
                                        void** memory) {
    return made(memory, "memory",
                [&]() -> void* { return of(device).device.import_memory(descriptor, c::count_of(bytes, "bytes")); });
}

clsdf_status clsdf_device_keep_records(const clsdf_device* device, const char* folder) {
    return guarded([&] { of(device).device.keep_records(c::text_or(folder, "")); });
}

clsdf_status clsdf_device_read_programs(const clsdf_device* device, const char* folder) {
    return guarded([&] { of(device).device.read_programs(c::text_or(folder, "")); });
}

clsdf_status clsdf_device_write_programs(const clsdf_device* device, const char* folder) {
    return guarded([&] { of(device).device.write_programs(c::text_or(folder, "")); });
}

clsdf_status clsdf_device_release_memory(const clsdf_device* device, std::int64_t* bytes) {
    return guarded([&] {
        const std::size_t released = of(device).device.release_memory();
        if (bytes != nullptr) *bytes = static_cast<std::int64_t>(released);
    });
}

clsdf_status clsdf_device_forget_records(const clsdf_device* device) {
    return guarded([&] { of(device).device.forget_records(); });
}

clsdf_status clsdf_device_record_folder(const clsdf_device* device, char* text, std::int64_t size,
                                        std::int64_t* length) {
    return guarded([&] { c::write_text(of(device).device.record_folder(), text, size, length); });
}

clsdf_status clsdf_default_record_folder(char* text, std::int64_t size, std::int64_t* length) {
    return guarded([&] { c::write_text(Device::default_record_folder(), text, size, length); });
}

clsdf_status clsdf_limit_threads(std::int64_t count, clsdf_thread_limit** limit) {
    return made(limit, "limit", [&] {
        if (count < 1) throw c::misuse("the number of threads is " + std::to_string(count) + "; it must be at least 1");
        return new clsdf_thread_limit(static_cast<std::size_t>(count));
    });
}

std::int64_t clsdf_thread_count() {
    return static_cast<std::int64_t>(
        std::min(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism),
                 static_cast<std::size_t>(tbb::info::default_concurrency())));
}

void clsdf_thread_limit_retain(clsdf_thread_limit* limit) {
    c::retain(limit);
}

void clsdf_thread_limit_release(clsdf_thread_limit* limit) {
    c::release(limit);
}
