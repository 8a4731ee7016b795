#pragma once

#include "binding.hpp"
#include "devices.hpp"

#include <clsdf/cuda.hpp>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace clsdf::python {

/// Arrays by the names of outputs.
using ArraysByName = nb::typed<nb::dict, nb::str, nb::any>;

/// The place of the numbers of a Python array: one with the buffer protocol or DLPack, pyopencl's, or one in memory of
/// CUDA.
struct ArrayView {
    ElementType type = ElementType::automatic;
    const void* host = nullptr;
    void* writable = nullptr;  ///< `host`, of an array that is written to
    cl_mem device = nullptr;
    std::size_t offset = 0;  ///< bytes
    std::vector<std::int64_t> shape;
    std::vector<std::int64_t> strides;  ///< bytes
    /// Of an array in memory of CUDA. `device` is known after Arrays::place(), and `offset` is until then that of the
    /// first element in these bytes.
    std::optional<cuda::Array> in_cuda{};

    bool is_packed() const;  ///< in C order
};

/// Whether an array lies in memory of CUDA: it has DLPack or __cuda_array_interface__.
bool is_in_cuda(nb::handle array);

/// The arrays of one call. They are used without a copy, and live until this is destroyed: with the GIL. The buffers of
/// arrays in memory of CUDA are known after place().
class Arrays {
public:
    /// Without a device, arrays in memory of CUDA are refused.
    explicit Arrays(const PyDevice* device = nullptr) : device_(device) {}
    ~Arrays();
    Arrays(const Arrays&) = delete;
    Arrays& operator=(const Arrays&) = delete;

    /// `what` names the array in messages: "points". The shape is (n, 3), of floats, doubles or integers of 32 or 64
    /// bits.
    InputArray triples(nb::handle array, const char* what);

    /// An array to write to. `shape` is that of its samples, (nz, ny, nx), (n,) or (blocks, nz, ny, nx); vectors have
    /// one axis more.
    OutputArray output(nb::handle array, const OutputInfo& info, const std::vector<std::int64_t>& shape);

    /// The targets of a dictionary.
    OutputTargets outputs(const ArraysByName& arrays, const std::vector<std::int64_t>& shape);

    /// Where an array lies. `what` names it in messages.
    ArrayView view(nb::handle array, const std::string& what, bool writable);

    /// Puts the buffers of arrays in memory of CUDA in their places.
    void place(std::initializer_list<InputArray*> inputs, std::span<OutputTargets> outputs);
    void place(std::span<Request> requests);
    /// Around a call of the library that blocks, after place(): OpenCL has arrays in memory of CUDA between them.
    void begin();
    void end();
    /// Those in memory of CUDA, to be kept beyond the call; null if there are none.
    std::unique_ptr<cuda::Arrays> take_cuda() { return std::move(cuda_); }

private:
    void find_places();
    void replace(ArrayLayout& layout, cl_mem& buffer) const;
    ArrayView view_in_cuda(nb::handle array, const std::string& what, bool writable);

    const PyDevice* device_;
    std::deque<cuda::Array> in_cuda_;  ///< the address of one stands in for its buffer until place()
    std::unique_ptr<cuda::Arrays> cuda_;
    std::vector<nb::ndarray<nb::ro>> held_;
};

/// (nz, ny, nx): NumPy's shape of the grid's samples.
std::vector<std::int64_t> shape_of(const Index3& size);

const OutputInfo& output_named(const std::string& name);

}  // namespace clsdf::python
