#include "arrays.hpp"
#include "devices.hpp"

#include <clsdf/cuda.hpp>

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
        : device_(std::move(device)), shared_device_(device_.cuda()), memory_(opened(shared_device_, bytes)) {}

    const PyDevice& device() const { return device_; }
    const cuda::SharedDevice& shared_device() const { return shared_device_; }
    const cuda::SharedMemory& memory() const { return *memory_; }

private:
    static cuda::SharedMemory* opened(const cuda::SharedDevice& device, std::size_t bytes) {
        const nb::gil_scoped_release no_gil;
        return new cuda::SharedMemory(device, bytes);
    }

    PyDevice device_;
    cuda::SharedDevice shared_device_;
    Owner<cuda::SharedMemory> memory_;  // its end waits for the device
};

nb::dlpack::dtype dtype_of(const std::string& kind, std::size_t bytes) {
    using nb::dlpack::dtype_code;
    const dtype_code code = kind == "f" ? dtype_code::Float : kind == "i" ? dtype_code::Int : dtype_code::UInt;
    return {static_cast<std::uint8_t>(code), static_cast<std::uint8_t>(8 * bytes), 1};
}

nb::object dlpack(nb::handle self, const std::vector<std::size_t>& shape, const std::string& kind, std::size_t bytes,
                  std::optional<std::int64_t> stream, nb::handle max_version) {
    const auto& own = nb::cast<const PySharedMemory&>(self);
    constexpr std::int64_t unordered = -1;
    if (stream.has_value() && *stream != unordered) {
        const nb::gil_scoped_release no_gil;
        own.shared_device().order(nullptr, std::bit_cast<void*>(*stream));  // the memory belongs to the default stream
    }
    const nb::ndarray<nb::array_api> array(std::bit_cast<void*>(own.memory().address()), shape.size(), shape.data(),
                                           self, nullptr, dtype_of(kind, bytes), nb::device::cuda::value,
                                           own.shared_device().ordinal());
    const nb::object exported = nb::cast(array, nb::rv_policy::reference);
    return exported.attr("__dlpack__")(nb::arg("max_version") = max_version);
}

// The bytes from the lowest to the highest of an array in memory of CUDA, and where its first element lies in them.
std::tuple<nb::object, std::size_t, std::vector<std::int64_t>, std::vector<std::int64_t>, std::string> copied_to_host(
    const PyDevice& device, nb::handle array, const std::string& what) {
    Arrays arrays(&device);
    const ArrayView view = arrays.view(array, what, false);
    const std::size_t bytes = view.in_cuda.has_value() ? view.in_cuda->bytes : 0;
    auto memory = std::make_unique<std::vector<std::byte>>(bytes);
    if (bytes > 0) {
        const cuda::SharedDevice shared = device.cuda();
        const nb::gil_scoped_release no_gil;
        shared.copy_to_host(*view.in_cuda, memory->data());
    }
    void* const data = memory->data();
    const nb::capsule owner(memory.release(),
                            [](void* own) noexcept { delete static_cast<std::vector<std::byte>*>(own); });
    std::string type = name_of(view.type);
    if (view.type == ElementType::float32) type = "float32";
    if (view.type == ElementType::float64) type = "float64";
    const nb::ndarray<nb::numpy, std::uint8_t, nb::ndim<1>> content(data, {bytes}, owner);
    return {nb::cast(content), view.offset, view.shape, view.strides, type};
}

void copy_from_host(const PyDevice& device, nb::handle array,
                    const nb::ndarray<const std::uint8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>& content) {
    Arrays arrays(&device);
    const ArrayView view = arrays.view(array, "the array", true);
    const std::size_t bytes = view.in_cuda.has_value() ? view.in_cuda->bytes : 0;
    if (bytes != content.shape(0) || !view.is_packed()) refuse("the array and its new content have different sizes");
    if (bytes == 0) return;
    const cuda::SharedDevice shared = device.cuda();
    const nb::gil_scoped_release no_gil;
    shared.copy_from_host(content.data(), *view.in_cuda);
}

}  // namespace

void add_shared_arrays(nb::module_& module) {
    nb::class_<PySharedMemory>(module, "SharedMemory", "The memory of a clsdf.SharedArray.")
        .def(nb::init<PyDevice, std::size_t>(), nb::arg("device"), nb::arg("bytes"))
        .def_prop_ro("address", [](const PySharedMemory& own) { return own.memory().address(); })
        .def_prop_ro("ordinal", [](const PySharedMemory& own) { return own.shared_device().ordinal(); })
        .def_prop_ro("device", [](const PySharedMemory& own) { return own.device(); })
        .def_prop_ro(
            "buffer_int_ptr",
            [](const PySharedMemory& own) { return std::bit_cast<std::uintptr_t>(own.memory().buffer()); },
            "The cl_mem.")
        .def("dlpack", &dlpack, nb::arg("shape"), nb::arg("kind"), nb::arg("bytes"), nb::arg("stream").none(),
             nb::arg("max_version").none());
    module.def("copied_to_host", &copied_to_host, nb::arg("device"), nb::arg("array"), nb::arg("what"));
    module.def("copy_from_host", &copy_from_host, nb::arg("device"), nb::arg("array"), nb::arg("content"));
}

}  // namespace clsdf::python
