#include "devices.hpp"

#include <clsdf/tuning.hpp>
#include <clsdf/turn_to_compile.hpp>

#include <nanobind/stl/function.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <climits>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <optional>
#include <string>
#include <tuple>
#include <variant>
#include <vector>

namespace clsdf::python {

namespace {

template <typename Handle>
std::uintptr_t number_of(Handle handle) {
    return std::bit_cast<std::uintptr_t>(handle);
}

// Drivers take time to list and to open: other threads go on.
template <typename Function>
auto without_gil(Function function) {
    check_process();
    const nb::gil_scoped_release no_gil;
    return function();
}

// As clsdf's command does, every device keeps records of passed tests and takes prepared programs from the user's
// folder.
template <typename Function>
PyDevice opened(Function open) {
    return PyDevice(without_gil([&] {
        Device device = open();
        const std::string folder = Device::default_record_folder();
        device.keep_records(folder);
        device.read_programs(folder);
        return device;
    }));
}

/// Once a process: nobody named a device, and the machine has GPUs of which none can be used.
void warn_of_unused_gpus(const Device& device) {
    static std::atomic<bool> is_asked = false;
    if (is_asked.exchange(true)) return;
    std::string text;
    for (const DeviceInfo& info : without_gil([] { return Device::unused_gpus(); }))
        text += (text.empty() ? "" : "; ") + info.name + " is not used (" + info.driver_file + "): " + info.why_not;
    if (text.empty()) return;
    text += "; clsdf computes on \"" + device.name() +
            "\": clsdf.Device.select, device= or CLSDF_DEVICE name a device without this warning";
    if (PyErr_WarnEx(PyExc_RuntimeWarning, text.c_str(), 2) != 0) throw nb::python_error();
}

/// A device that nobody named, unless CLSDF_DEVICE does.
template <typename Function>
PyDevice chosen(Function open) {
    PyDevice device = opened(open);
    const char* const named = std::getenv("CLSDF_DEVICE");
    if (named == nullptr || *named == 0) warn_of_unused_gpus(device.get());
    return device;
}

PyDevice device_of_queue(nb::handle queue) {
    const auto handle = [](nb::handle object) { return nb::cast<std::uintptr_t>(object.attr("int_ptr")); };
    const auto context = std::bit_cast<cl_context>(handle(queue.attr("context")));
    const auto device = std::bit_cast<cl_device_id>(handle(queue.attr("device")));
    const auto own = std::bit_cast<cl_command_queue>(handle(queue));
    return opened([&] { return Device::from_handles(context, device, own); });
}

PyDevice limited(const PyDevice& device, nb::handle compute_units, nb::handle memory) {
    DeviceLimits limits;
    if (!compute_units.is_none()) {
        const std::size_t units = count_of(compute_units, "limited(): compute_units");
        limits.compute_units = static_cast<unsigned>(std::min<std::size_t>(units, UINT_MAX));
    }
    if (!memory.is_none()) limits.memory = count_of(memory, "limited(): memory");
    const Device& whole = device.get();
    return PyDevice(without_gil([&] { return whole.limited(limits); }));
}

void add_infos(nb::module_& module) {
    nb::class_<DeviceInfo>(module, "DeviceInfo", "What an OpenCL device reports; 0 or empty if it does not say.")
        .def_prop_ro(
            "index",
            [](const DeviceInfo& info) {
                return info.index == DeviceInfo::not_listed ? std::optional<std::size_t>() : info.index;
            },
            "Its number in devices(), or None.")
        .def_ro("name", &DeviceInfo::name)
        .def_ro("platform", &DeviceInfo::platform)
        .def_ro("version", &DeviceInfo::version, "Of OpenCL.")
        .def_ro("driver", &DeviceInfo::driver, "The driver's version.")
        .def_prop_ro(
            "kind", [](const DeviceInfo& info) { return std::string(name_of(info.kind)); },
            "'gpu', 'processor', 'accelerator' or 'other'.")
        .def_ro("compute_units", &DeviceInfo::compute_units)
        .def_ro("memory", &DeviceInfo::memory, "Bytes.")
        .def_ro("largest_allocation", &DeviceInfo::largest_allocation, "Bytes.")
        .def_prop_ro(
            "source", [](const DeviceInfo& info) { return std::string(name_of(info.source)); },
            "How it was found: 'registered' with OpenCL's loader, 'bundled' with clsdf, 'unregistered' (a GPU's "
            "driver\n"
            "that the loader does not know), or 'device_file' (a GPU's file in /dev, and no usable device).")
        .def_ro("driver_file", &DeviceInfo::driver_file,
                "The driver's if clsdf opened it; of 'device_file', the file in /dev; else empty.")
        .def_prop_ro("usable", &DeviceInfo::usable)
        .def_ro("why_not", &DeviceInfo::why_not, "Why clsdf cannot use it; empty if it can.")
        .def_ro("only_if_named", &DeviceInfo::only_if_named,
                "Why clsdf takes it only if it is named, though it can be used; else empty.")
        .def("__getstate__",
             [](const DeviceInfo& info) {
                 return std::tuple(info.index, info.name, info.platform, info.version, info.driver,
                                   static_cast<std::int32_t>(info.kind), info.compute_units, info.memory,
                                   info.largest_allocation, static_cast<std::int32_t>(info.source), info.driver_file,
                                   info.why_not, info.only_if_named);
             })
        .def(
            "__setstate__",
            [](DeviceInfo& info,
               const std::tuple<std::size_t, std::string, std::string, std::string, std::string, std::int32_t, unsigned,
                                std::size_t, std::size_t, std::int32_t, std::string, std::string, std::string>& state) {
                DeviceInfo* const made = new (&info) DeviceInfo;
                std::int32_t kind = 0, source = 0;
                std::tie(made->index, made->name, made->platform, made->version, made->driver, kind,
                         made->compute_units, made->memory, made->largest_allocation, source, made->driver_file,
                         made->why_not, made->only_if_named) = state;
                made->kind = static_cast<DeviceKind>(kind);
                made->source = static_cast<DeviceSource>(source);
            })
        .def("__repr__",
             [](const DeviceInfo& info) { return "<clsdf.DeviceInfo " + info.name + ", " + info.platform + ">"; });
}

}  // namespace

void add_devices(nb::module_& module) {
    add_infos(module);
    nb::class_<PyDevice>(module, "Device",
                         "An OpenCL device with a context and a queue. Transforms of one device share its compiled "
                         "programs. Any number\n"
                         "of threads may use it. As clsdf's command does, it keeps records of passed tests and takes "
                         "prepared programs\n"
                         "from ~/.cache/clsdf, or from the folder that CLSDF_CACHE_DIR names; an empty one turns that "
                         "off. Raises\n"
                         "clsdf.Error (no_device, device_failure).")
        .def_static(
            "automatic", [] { return chosen([] { return Device::automatic(); }); },
            "The device that CLSDF_DEVICE names, else the strongest GPU, else the strongest other device. Warns once "
            "a\n"
            "process if the machine has a GPU of NVIDIA or AMD, and no GPU can be used.")
        .def_static(
            "select",
            [](const std::variant<std::string, std::int64_t>& choice) {
                const auto* const index = std::get_if<std::int64_t>(&choice);
                const std::string text = index != nullptr ? std::to_string(*index) : std::get<std::string>(choice);
                return opened([&] { return Device::select(text); });
            },
            nb::arg("choice"), "An index in devices(), or a part of one device's name, in upper or lower case.")
        .def_static(
            "of_rank",
            [](nb::handle rank, nb::handle ranks) {
                return chosen([number = count_of(rank, "of_rank(): rank"),
                               count = count_of(ranks, "of_rank(): ranks")] { return Device::of_rank(number, count); });
            },
            nb::arg("rank"), nb::arg("ranks"), nb::sig("def of_rank(rank: int, ranks: int) -> Device"),
            "The share of a process among those of this machine, 0 <= rank < ranks. GPUs are dealt out in turn; if\n"
            "there is none, or if CLSDF_DEVICE names a device, an equal part of a processor's compute units. Raises\n"
            "clsdf.Error: invalid_argument, or unsupported that names the driver's variable if a processor cannot be\n"
            "divided.")
        .def_static(
            "from_queue", &device_of_queue, nb::arg("queue"), nb::sig("def from_queue(queue: object) -> Device"),
            "The device, context and queue of a pyopencl.CommandQueue. Arrays of that context can be written to.")
        .def("limited", &limited, nb::arg("compute_units") = nb::none(), nb::arg("memory") = nb::none(),
             nb::sig("def limited(self, compute_units: int | None = None, memory: int | None = None) -> Device"),
             "The same device with at most so many compute units (cores of a processor), and so many bytes for the\n"
             "buffers of each transform. None: all. Raises clsdf.Error (unsupported) if it cannot be divided.")
        .def(
            "info",
            [](const PyDevice& device) {
                const Device& own = device.get();
                return without_gil([&] { return own.info(); });
            },
            "What the device reports.")
        .def_prop_ro("name", [](const PyDevice& device) { return device.get().name(); })
        .def_prop_ro("platform", [](const PyDevice& device) { return device.get().platform(); })
        .def_prop_ro(
            "context_int_ptr", [](const PyDevice& device) { return number_of(device.get().context()); },
            "The cl_context, for pyopencl.Context.from_int_ptr().")
        .def_prop_ro(
            "queue_int_ptr", [](const PyDevice& device) { return number_of(device.get().queue()); },
            "The cl_command_queue, for pyopencl.CommandQueue.from_int_ptr().")
        .def(
            "keep_records",
            [](const PyDevice& device, const std::string& folder) { device.get().keep_records(folder); },
            nb::arg("folder"),
            "Keeps records of passed tests there, so that later processes do not test again. An empty text: nowhere.")
        .def(
            "read_programs",
            [](const PyDevice& device, const std::string& folder) { device.get().read_programs(folder); },
            nb::arg("folder"),
            "Takes compiled programs from a folder that `clsdf devices --prepare` wrote. An empty text: from none.")
        .def(
            "release_memory",
            [](const PyDevice& device) { return without_gil([&] { return device.release_memory(); }); },
            "Gives back what the device keeps for later calls (Transform.shared_memory). Returns the bytes.")
        .def(
            "_has_semaphores",
            [](const PyDevice& device) {
                const cuda::SharedDevice shared = device.cuda();
                return without_gil([&] { return shared.has_semaphores(); });
            },
            "For tests: whether the driver shares semaphores with CUDA.")
        .def("__repr__", [](const PyDevice& device) {
            return "<clsdf.Device " + device.get().name() + ", " + device.get().platform() + ">";
        });
    module.def(
        "devices", [] { return without_gil([] { return Device::all(); }); },
        "Every OpenCL device, also those that clsdf cannot use. Raises clsdf.Error (device_failure).");
    module.def(
        "default_record_folder", [] { return Device::default_record_folder(); },
        "The folder of records that Device() keeps: Device::default_record_folder() of C++. Empty if there is none.");
    nb::class_<TurnToCompile>(module, "TurnToCompile", "clsdf::TurnToCompile; ends when the object does.")
        .def(
            "__init__",
            [](TurnToCompile* turn, const std::string& folder, const std::function<bool(double)>& goes_on) {
                without_gil([&] { new (turn) TurnToCompile(folder, goes_on); });
            },
            nb::arg("folder"), nb::arg("goes_on"))
        .def_prop_ro("is_taken", &TurnToCompile::is_taken);
    module.def(
        "_read_environment", [] { tuning::read_environment(); },
        "For tests: this process obeys the variables of clsdf::tuning::read_environment().");
}

}  // namespace clsdf::python
