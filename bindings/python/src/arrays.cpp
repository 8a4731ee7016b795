#include "arrays.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <memory>
#include <new>
#include <optional>
#include <utility>

namespace clsdf::python {

namespace {

std::string text_of(const std::vector<std::int64_t>& shape) {
    std::string text = "(";
    for (const std::int64_t side : shape) text += std::to_string(side) + ", ";
    if (shape.size() > 1) text.erase(text.size() - 2);
    if (shape.size() == 1) text.pop_back();
    return text + ")";
}

ElementType type_of(nb::dlpack::dtype type) {
    using nb::dlpack::dtype_code;
    constexpr std::pair<nb::dlpack::dtype, ElementType> types[] = {
        {nb::dtype<float>(), ElementType::float32},        {nb::dtype<double>(), ElementType::float64},
        {nb::dtype<std::int32_t>(), ElementType::int32},   {nb::dtype<std::int64_t>(), ElementType::int64},
        {nb::dtype<std::uint32_t>(), ElementType::uint32}, {nb::dtype<std::uint64_t>(), ElementType::uint64},
        {nb::dtype<std::uint8_t>(), ElementType::uint8},
    };
    for (const auto& [dtype, element] : types)
        if (type == dtype) return element;
    return ElementType::automatic;
}

ElementType type_named(const std::string& dtype) {
    constexpr std::pair<const char*, ElementType> types[] = {
        {"float32", ElementType::float32}, {"float64", ElementType::float64}, {"int32", ElementType::int32},
        {"int64", ElementType::int64},     {"uint32", ElementType::uint32},   {"uint64", ElementType::uint64},
        {"uint8", ElementType::uint8},
    };
    for (const auto& [name, element] : types)
        if (dtype == name) return element;
    return ElementType::automatic;
}

std::string type_text(nb::handle array) {
    const nb::object dtype = nb::getattr(array, "dtype", nb::none());
    return nb::cast<std::string>(nb::str(dtype.is_none() ? array.type() : nb::handle(dtype)));
}

[[noreturn]] void refuse_type(nb::handle array, const std::string& what, bool is_output) {
    refuse(what + " has elements of type " + type_text(array) + "; use " +
           (is_output ? "float32 or float64, for triangle uint32 or int32, for site uint8"
                      : "float32 or float64 for numbers, int32, int64, uint32 or uint64 for indices"));
}

// pyopencl.array.Array: its memory is a buffer and an offset into it.
ArrayView view_on_device(nb::handle array, const std::string& what, bool is_output) {
    ArrayView view;
    view.device = std::bit_cast<cl_mem>(nb::cast<std::uintptr_t>(array.attr("base_data").attr("int_ptr")));
    view.offset = nb::cast<std::size_t>(array.attr("offset"));
    view.type = type_named(nb::cast<std::string>(nb::str(array.attr("dtype").attr("name"))));
    view.shape = nb::cast<std::vector<std::int64_t>>(array.attr("shape"));
    view.strides = nb::cast<std::vector<std::int64_t>>(array.attr("strides"));
    if (view.type == ElementType::automatic) refuse_type(array, what, is_output);
    return view;
}

// The package of the array's class, if its arrays never change: they may share memory, and DLPack has no flag for that.
std::string package_of_constants(nb::handle array) {
    const std::string module = nb::cast<std::string>(nb::str(nb::getattr(array.type(), "__module__", nb::str(""))));
    const std::string package = module.substr(0, module.find('.'));
    if (package == "jaxlib") return "jax";
    return package == "jax" || package == "tensorflow" ? package : "";
}

/// An array in memory of CUDA, as its package describes it.
struct CudaArray {
    bool is_read_only = false;
    std::uint64_t address = 0;
    ElementType type = ElementType::automatic;
    std::vector<std::int64_t> shape, strides;  // of bytes
    void* stream = nullptr;
    std::optional<nb::ndarray<nb::ro>> held{};  // of DLPack: keeps the memory
};

ElementType type_of_interface(const std::string& type) {
    constexpr std::pair<const char*, ElementType> types[] = {
        {"<f4", ElementType::float32}, {"<f8", ElementType::float64}, {"<i4", ElementType::int32},
        {"<i8", ElementType::int64},   {"<u4", ElementType::uint32},  {"<u8", ElementType::uint64},
        {"|u1", ElementType::uint8},
    };
    for (const auto& [name, element] : types)
        if (type == name) return element;
    return ElementType::automatic;
}

std::vector<std::int64_t> packed_strides(const std::vector<std::int64_t>& shape, ElementType type) {
    std::vector<std::int64_t> strides(shape.size());
    auto step = static_cast<std::int64_t>(bytes_of(type));
    for (std::size_t axis = shape.size(); axis-- > 0;) {
        strides[axis] = step;
        step *= shape[axis];
    }
    return strides;
}

// clsdf/_cuda.py asks the array's package: for its __cuda_array_interface__, or for DLPack, and for its stream.
CudaArray cuda_array_of(nb::handle array) {
    const auto parts = nb::cast<nb::tuple>(nb::module_::import_("clsdf._cuda").attr("described")(array));
    CudaArray found;
    found.stream = std::bit_cast<void*>(nb::cast<std::uintptr_t>(parts[2]));
    if (parts[0].is_none()) {
        const auto& tensor = found.held.emplace(nb::cast<nb::ndarray<nb::ro>>(parts[1]));
        found.address = std::bit_cast<std::uintptr_t>(tensor.data());
        found.type = type_of(tensor.dtype());
        for (std::size_t axis = 0; axis < tensor.ndim(); ++axis) {
            found.shape.push_back(static_cast<std::int64_t>(tensor.shape(axis)));
            found.strides.push_back(tensor.stride(axis) * static_cast<std::int64_t>(tensor.itemsize()));
        }
        return found;
    }
    const auto interface = nb::cast<nb::dict>(parts[0]);
    const auto data = nb::cast<std::pair<std::uint64_t, bool>>(interface["data"]);
    found.address = data.first;
    found.is_read_only = data.second;
    found.type = type_of_interface(nb::cast<std::string>(interface["typestr"]));
    found.shape = nb::cast<std::vector<std::int64_t>>(interface["shape"]);
    const nb::object strides = interface.contains("strides") ? nb::object(interface["strides"]) : nb::none();
    found.strides =
        strides.is_none() ? packed_strides(found.shape, found.type) : nb::cast<std::vector<std::int64_t>>(strides);
    return found;
}

// Why an array could not be taken.
[[noreturn]] void refuse_array(nb::handle array, const std::string& what, bool is_output) {
    if (!nb::ndarray_check(array))
        refuse(what + " is a " + nb::cast<std::string>(nb::str(array.type().attr("__name__"))) +
               ", which is no array; use a NumPy array or any other with the buffer protocol or DLPack");
    const nb::object dtype = nb::getattr(array, "dtype", nb::none());
    if (const nb::object kind = nb::getattr(dtype, "kind", nb::none());
        !kind.is_none() && (std::string("fiub").find(nb::cast<std::string>(kind)) == std::string::npos ||
                            nb::cast<int>(dtype.attr("itemsize")) > 8))
        refuse_type(array, what, is_output);
    refuse(
        what + " (" + type_text(array) +
        ") cannot be read: it has swapped bytes, strides that are no multiple of its elements, or memory that is not "
        "the host's; np.ascontiguousarray(a, a.dtype.newbyteorder('=')) makes a copy that can");
}

// The stride of an axis as the library takes it. An axis of one item has none, so any number is right.
std::ptrdiff_t stride_of(const ArrayView& view, std::size_t axis, const std::string& what) {
    const std::int64_t stride = view.strides[axis];
    if (view.shape[axis] <= 1) return static_cast<std::ptrdiff_t>(bytes_of(view.type));
    if (stride == 0)
        refuse(what + " has the stride 0 along axis " + std::to_string(axis) +
               ": its items lie on the same bytes, as after np.broadcast_to; pass a copy");
    return static_cast<std::ptrdiff_t>(stride);
}

std::size_t count(const std::vector<std::int64_t>& shape) {
    std::size_t items = 1;
    for (const std::int64_t side : shape) items *= static_cast<std::size_t>(side);
    return items;
}

}  // namespace

bool is_in_cuda(nb::handle array) {
    static const nb::handle usual = nb::object(nb::module_::import_("numpy").attr("ndarray")).release();
    if (array.type().is(usual)) return false;
    if (nb::hasattr(array, "__dlpack_device__")) {
        constexpr int cuda = 2, cuda_managed = 13;  // kDLCUDA, kDLCUDAManaged
        try {
            const auto device = nb::cast<nb::tuple>(array.attr("__dlpack_device__")());
            const int kind = nb::cast<int>(nb::int_(device[0]));
            return kind == cuda || kind == cuda_managed;
        } catch (const nb::python_error&) {  // as of an array that lies on several devices
            return false;
        }
    }
    return nb::hasattr(array, "__cuda_array_interface__");
}

bool ArrayView::is_packed() const {
    if (std::ranges::find(shape, 0) != shape.end()) return true;
    auto packed = static_cast<std::int64_t>(bytes_of(type));
    for (std::size_t axis = shape.size(); axis-- > 0;) {
        if (shape[axis] > 1 && strides[axis] != packed) return false;
        packed *= shape[axis];
    }
    return true;
}

ArrayView Arrays::view(nb::handle array, const std::string& what, bool writable) {
    if (const std::string package = writable ? package_of_constants(array) : ""; !package.empty())
        refuse(what + " is an array of " + package + ", and these never change; pass a NumPy array, and make one of " +
               package + " from it");
    if (is_in_cuda(array)) return view_in_cuda(array, what, writable);
    nb::ndarray<nb::ro> readable;
    if (!nb::try_cast(array, readable, false)) {
        if (nb::hasattr(array, "base_data")) return view_on_device(array, what, writable);
        refuse_array(array, what, writable);
    }
    ArrayView view;
    if (writable) {
        nb::ndarray<> own;
        if (!nb::try_cast(array, own, false)) refuse(what + " is read-only; pass an array that can be written");
        view.writable = own.data();
    }
    view.type = type_of(readable.dtype());
    if (view.type == ElementType::automatic) refuse_type(array, what, writable);
    if (readable.device_type() != nb::device::cpu::value)
        refuse(what + " is in memory of a device that is not CUDA's; copy it to the host, or pass a pyopencl array");
    view.host = readable.data();
    const auto width = static_cast<std::int64_t>(bytes_of(view.type));
    if (std::bit_cast<std::uintptr_t>(view.host) % static_cast<std::uintptr_t>(width) != 0)
        refuse(what + " begins at an address that is no multiple of its elements' " + std::to_string(width) +
               " bytes; pass a copy");
    for (std::size_t axis = 0; axis < readable.ndim(); ++axis) {
        view.shape.push_back(static_cast<std::int64_t>(readable.shape(axis)));
        view.strides.push_back(readable.stride(axis) * width);
    }
    held_.push_back(std::move(readable));
    return view;
}

Arrays::~Arrays() {
    if (cuda_ == nullptr) return;
    const nb::gil_scoped_release no_gil;
    cuda_.reset();
}

ArrayView Arrays::view_in_cuda(nb::handle array, const std::string& what, bool writable) {
    if (device_ == nullptr)
        refuse(what + " lies in memory of CUDA, and this function reads the host's; pass a copy, as tensor.cpu()");
    if (writable && nb::cast<bool>(nb::bool_(nb::getattr(array, "requires_grad", nb::bool_(false)))))
        refuse(what + " requires a gradient, and clsdf's writing has none; pass tensor.detach()");
    const auto [is_read_only, address, type, shape, strides, stream, held] = cuda_array_of(array);
    if (held.has_value()) held_.push_back(*held);
    if (writable && is_read_only) refuse(what + " is read-only; pass an array that can be written");
    ArrayView view;
    view.type = type;
    view.shape = shape;
    view.strides = strides;
    if (type == ElementType::automatic) refuse_type(array, what, writable);
    if (std::ranges::find(shape, 0) != shape.end()) {
        static double nothing = 0;  // no call reads or writes it
        view.host = view.writable = &nothing;
        return view;
    }
    const auto width = static_cast<std::int64_t>(bytes_of(type));
    std::uint64_t begin = address, end = address;
    bool is_aligned = address % static_cast<std::uint64_t>(width) == 0;
    for (std::size_t axis = 0; axis < shape.size(); ++axis) {
        const std::int64_t reach = (shape[axis] - 1) * strides[axis];
        (reach < 0 ? begin : end) += static_cast<std::uint64_t>(reach);
        is_aligned &= shape[axis] <= 1 || strides[axis] % width == 0;
    }
    end += static_cast<std::uint64_t>(width);
    if (!is_aligned)
        refuse(what + " has an address or strides that are no multiples of its elements' " + std::to_string(width) +
               " bytes; pass a copy");
    using cuda::Access;
    const Access access = !writable ? Access::read : view.is_packed() ? Access::write : Access::update;
    view.in_cuda = cuda::Array{begin, end - begin, access, stream, what};
    in_cuda_.push_back(*view.in_cuda);
    view.device = reinterpret_cast<cl_mem>(&in_cuda_.back());
    view.offset = address - begin;
    return view;
}

void Arrays::find_places() {
    const cuda::SharedDevice device = device_->cuda();
    const nb::gil_scoped_release no_gil;
    const std::vector<cuda::Array> all(in_cuda_.begin(), in_cuda_.end());
    cuda_ = std::make_unique<cuda::Arrays>(device, all);
}

void Arrays::replace(ArrayLayout& layout, cl_mem& buffer) const {
    for (std::size_t number = 0; number < in_cuda_.size(); ++number)
        if (buffer == reinterpret_cast<const _cl_mem*>(&in_cuda_[number])) {
            const DeviceRange place = (*cuda_)[number];
            buffer = place.memory;
            layout.offset += place.offset;
            return;
        }
}

void Arrays::place(std::initializer_list<InputArray*> inputs, std::span<OutputTargets> outputs) {
    if (in_cuda_.empty()) return;
    find_places();
    for (InputArray* const input : inputs) replace(*input, input->device);
    for (OutputTargets& targets : outputs)
        for (const OutputTarget& target : targets.all()) {
            OutputArray& array = targets[target.output];
            replace(array, array.device);
        }
}

void Arrays::place(std::span<Request> requests) {
    if (in_cuda_.empty()) return;
    find_places();
    for (Request& request : requests)
        for (const OutputTarget& target : request.targets.all()) {
            OutputArray& array = request.targets[target.output];
            replace(array, array.device);
        }
}

void Arrays::begin() {
    if (cuda_ == nullptr) return;
    const nb::gil_scoped_release no_gil;
    cuda_->begin();
}

void Arrays::end() {
    if (cuda_ == nullptr) return;
    const nb::gil_scoped_release no_gil;
    cuda_->end();
}

InputArray Arrays::triples(nb::handle array, const char* what) {
    const ArrayView seen = view(array, what, false);
    if (seen.shape.size() != 2 || seen.shape[1] != 3)
        refuse(std::string(what) + " has the shape " + text_of(seen.shape) + "; expected (n, 3)");
    InputArray triples;
    triples.host = seen.host;
    triples.device = seen.device;
    triples.type = seen.type;
    triples.offset = seen.offset;
    triples.count = static_cast<std::size_t>(seen.shape[0]);
    if (!seen.is_packed()) {
        triples.strides[0] = stride_of(seen, 0, what);
        triples.component_stride = stride_of(seen, 1, what);
    }
    return triples;
}

OutputArray Arrays::output(nb::handle array, const OutputInfo& info, const std::vector<std::int64_t>& shape) {
    // A buffer of pyopencl has no shape: packed, of the output's own type.
    if (nb::hasattr(array, "int_ptr")) return {std::bit_cast<cl_mem>(nb::cast<std::uintptr_t>(array.attr("int_ptr")))};
    const std::string what = std::string("out: the array of '") + info.name + "'";
    const ArrayView seen = view(array, what, true);
    std::vector<std::int64_t> expected = shape;
    const bool is_vector = info.components > 1;
    if (is_vector) expected.push_back(static_cast<std::int64_t>(info.components));
    if (seen.shape != expected)
        refuse(what + " has the shape " + text_of(seen.shape) + "; expected " + text_of(expected));
    OutputArray output;
    output.host = seen.writable;
    output.device = seen.device;
    output.type = seen.type;
    output.offset = seen.offset;
    // Tensors of torch know.
    output.is_pinned = nb::hasattr(array, "is_pinned") && nb::cast<bool>(array.attr("is_pinned")());
    if (seen.is_packed()) {
        if (seen.host != nullptr) output.bytes = count(seen.shape) * bytes_of(seen.type);
        return output;
    }
    // NumPy's axes are z, y, x; the library's strides x, y, z.
    const std::size_t axes = shape.size();
    for (std::size_t axis = 0; axis < std::min<std::size_t>(axes, 3); ++axis)
        output.strides[axis] = stride_of(seen, axes - 1 - axis, what);
    if (axes > 3) output.block_stride = stride_of(seen, 0, what);
    if (is_vector) output.component_stride = stride_of(seen, axes, what);
    return output;
}

OutputTargets Arrays::outputs(const ArraysByName& arrays, const std::vector<std::int64_t>& shape) {
    OutputTargets targets;
    for (const auto& [name, array] : arrays) {
        const OutputInfo& info = output_named(nb::cast<std::string>(name));
        targets[info.output] = output(array, info, shape);
    }
    return targets;
}

std::vector<std::int64_t> shape_of(const Index3& size) {
    return {size[2], size[1], size[0]};
}

const OutputInfo& output_named(const std::string& name) {
    std::string names;
    for (const OutputInfo& info : output_table()) {
        if (name == info.name) return info;
        names += (names.empty() ? "" : ", ") + std::string(info.name);
    }
    refuse("there is no output '" + name + "'; the outputs are " + names);
}

namespace {

template <typename Value>
void negate_from(std::byte* at, const ArrayView& view, std::size_t axis) {
    if (axis == view.shape.size()) {
        auto& value = *reinterpret_cast<Value*>(at);
        value = std::isnan(value) ? value : -value;
        return;
    }
    for (std::int64_t i = 0; i < view.shape[axis]; ++i) negate_from<Value>(at + i * view.strides[axis], view, axis + 1);
}

// Changes the sign of distances and gradients; their NaN stay.
void negate(const ArraysByName& arrays) {
    Arrays held;
    std::vector<ArrayView> views;
    for (const auto& [name, array] : arrays) {
        const OutputInfo& info = output_named(nb::cast<std::string>(name));
        if (info.output != Output::distance && info.output != Output::gradient) continue;
        views.push_back(held.view(array, std::string("out: the array of '") + info.name + "'", true));
    }
    const nb::gil_scoped_release no_gil;
    for (const ArrayView& view : views) {
        auto* const first = static_cast<std::byte*>(view.writable);
        if (view.type == ElementType::float64)
            negate_from<double>(first, view, 0);
        else
            negate_from<float>(first, view, 0);
    }
}

}  // namespace

void add_arrays(nb::module_& module) {
    module.def("negate", &negate, nb::arg("arrays"), nb::sig("def negate(arrays: dict[str, typing.Any]) -> None"),
               "Changes the sign of the distances and the gradients, in place; NaN stay.");
    module.def(
        "allocate",
        [](std::size_t bytes) {
            std::unique_ptr<FieldArray<std::byte>> memory;
            try {
                memory = std::make_unique<FieldArray<std::byte>>(bytes);
            } catch (const std::bad_alloc&) {
                throw Error(ErrorCode::out_of_memory, "an array of " + std::to_string(bytes) +
                                                          " bytes does not fit the memory; choose a lower resolution, "
                                                          "fewer outputs, or slabs()");
            }
            void* const data = memory->data();
            const nb::capsule owner(memory.release(),
                                    [](void* array) noexcept { delete static_cast<FieldArray<std::byte>*>(array); });
            return nb::ndarray<nb::numpy, std::uint8_t, nb::ndim<1>>(data, {bytes}, owner);
        },
        nb::arg("bytes"), "Memory for fast stores, uninitialised: aligned to 64 bytes, on huge pages if it is large.");
    module.def("is_in_cuda", &is_in_cuda, nb::arg("array"), "Whether an array lies in memory of CUDA.");
    module.def(
        "outputs",
        [] {
            nb::list rows;
            for (const OutputInfo& info : output_table()) {
                std::string type = name_of(info.type);
                if (info.type == ElementType::float32) type = "float32";
                if (info.type == ElementType::float64) type = "float64";
                rows.append(nb::make_tuple(info.name, type, info.components, info.description));
            }
            return rows;
        },
        nb::sig("def outputs() -> list[tuple[str, str, int, str]]"),
        "The table of outputs: name, type of NumPy, numbers of a sample, description.");
}

}  // namespace clsdf::python
