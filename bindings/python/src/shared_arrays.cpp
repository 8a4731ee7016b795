#include "arrays.hpp"
#include "devices.hpp"

#include <bit>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace clsdf::python {

namespace {

/// The memory of a SharedArray, for Python.
class PySharedMemory {
public:
    PySharedMemory(PyDevice device, std::size_t bytes)
        : device_(std::move(device)), memory_(opened(device_.cuda(), bytes)) {}
    PySharedMemory(const PySharedMemory&) = delete;
    PySharedMemory& operator=(const PySharedMemory&) = delete;
    PySharedMemory(PySharedMemory&&) = delete;
    PySharedMemory& operator=(PySharedMemory&&) = delete;
    ~PySharedMemory() {
        const nb::gil_scoped_release no_gil;  // it waits for the device
        memory_.reset();
    }

    const PyDevice& device() const { return device_; }
    const cuda::SharedMemory& memory() const { return *memory_; }

private:
    static std::shared_ptr<cuda::SharedMemory> opened(std::shared_ptr<cuda::Link> link, std::size_t bytes) {
        const nb::gil_scoped_release no_gil;
        return cuda::new_shared_memory(std::move(link), bytes);
    }

    PyDevice device_;
    std::shared_ptr<cuda::SharedMemory> memory_;
};

nb::dlpack::dtype dtype_of(const std::string& kind, std::size_t bytes) {
    using nb::dlpack::dtype_code;
    const dtype_code code = kind == "f" ? dtype_code::Float : kind == "i" ? dtype_code::Int : dtype_code::UInt;
    return {static_cast<std::uint8_t>(code), static_cast<std::uint8_t>(8 * bytes), 1};
}

// The work that the default stream has now is done before what `stream` does next.
void follow_default_stream(const cuda::Link& link, cuda::Stream stream) {
    const nb::gil_scoped_release no_gil;
    const cuda::Current current(link.context());
    const cuda::Driver& driver = cuda::driver();
    constexpr unsigned without_timing = 2;  // CU_EVENT_DISABLE_TIMING
    cuda::Event event = nullptr;
    cuda::check(driver.create_event(&event, without_timing), "cuEventCreate");
    int code = driver.record_event(event, cuda::default_stream());
    if (code == 0) code = driver.wait_event(stream, event, 0);
    driver.destroy_event(event);
    cuda::check(code, "cuStreamWaitEvent");
}

nb::object dlpack(nb::handle self, const std::vector<std::size_t>& shape, const std::string& kind, std::size_t bytes,
                  std::optional<std::int64_t> stream, nb::handle max_version) {
    const auto& own = nb::cast<const PySharedMemory&>(self);
    const cuda::SharedMemory& memory = own.memory();
    constexpr std::int64_t legacy = 1, unordered = -1;
    if (stream.has_value() && *stream != legacy && *stream != unordered)
        follow_default_stream(memory.link(), std::bit_cast<cuda::Stream>(*stream));
    const nb::ndarray<nb::array_api> array(std::bit_cast<void*>(memory.allocation().address()), shape.size(),
                                           shape.data(), self, nullptr, dtype_of(kind, bytes), nb::device::cuda::value,
                                           memory.link().ordinal());
    const nb::object exported = nb::cast(array, nb::rv_policy::reference);
    return exported.attr("__dlpack__")(nb::arg("max_version") = max_version);
}

// The bytes from the lowest to the highest of an array in memory of CUDA, and where its first element lies in them.
std::tuple<nb::object, std::size_t, std::vector<std::int64_t>, std::vector<std::int64_t>, std::string> copied_to_host(
    const PyDevice& device, nb::handle array, const std::string& what) {
    Arrays arrays(&device);
    const ArrayView view = arrays.view(array, what, false);
    const cuda::View& there = view.in_cuda;
    const std::size_t bytes = there.end - there.begin;
    auto memory = std::make_unique<std::vector<std::byte>>(bytes);
    if (bytes > 0) {
        const std::shared_ptr<cuda::Link> link = device.cuda();
        const nb::gil_scoped_release no_gil;
        cuda::copy_to_host(*link, there, memory->data());
    }
    void* const data = memory->data();
    const nb::capsule owner(memory.release(),
                            [](void* own) noexcept { delete static_cast<std::vector<std::byte>*>(own); });
    std::string type = name_of(view.type);
    if (view.type == ElementType::float32) type = "float32";
    if (view.type == ElementType::float64) type = "float64";
    const nb::ndarray<nb::numpy, std::uint8_t, nb::ndim<1>> content(data, {bytes}, owner);
    return {nb::cast(content), there.address - there.begin, view.shape, view.strides, type};
}

void copy_from_host(const PyDevice& device, nb::handle array,
                    const nb::ndarray<const std::uint8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>& content) {
    Arrays arrays(&device);
    const ArrayView view = arrays.view(array, "the array", true);
    const cuda::View& there = view.in_cuda;
    if (there.end - there.begin != content.shape(0) || !view.is_packed())
        refuse("the array and its new content have different sizes");
    if (content.shape(0) == 0) return;
    const std::shared_ptr<cuda::Link> link = device.cuda();
    const nb::gil_scoped_release no_gil;
    cuda::copy_from_host(*link, there, content.data());
}

}  // namespace

void add_shared_arrays(nb::module_& module) {
    nb::class_<PySharedMemory>(module, "SharedMemory", "The memory of a clsdf.SharedArray.")
        .def(nb::init<PyDevice, std::size_t>(), nb::arg("device"), nb::arg("bytes"))
        .def_prop_ro("address", [](const PySharedMemory& own) { return own.memory().allocation().address(); })
        .def_prop_ro("ordinal", [](const PySharedMemory& own) { return own.memory().link().ordinal(); })
        .def_prop_ro("device", [](const PySharedMemory& own) { return own.device(); })
        .def_prop_ro(
            "buffer_int_ptr",
            [](const PySharedMemory& own) { return std::bit_cast<std::uintptr_t>(own.memory().allocation().buffer()); },
            "The cl_mem.")
        .def("dlpack", &dlpack, nb::arg("shape"), nb::arg("kind"), nb::arg("bytes"), nb::arg("stream").none(),
             nb::arg("max_version").none());
    module.def("copied_to_host", &copied_to_host, nb::arg("device"), nb::arg("array"), nb::arg("what"));
    module.def("copy_from_host", &copy_from_host, nb::arg("device"), nb::arg("array"), nb::arg("content"));
}

}  // namespace clsdf::python
