#pragma once

#include "binding.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace clsdf::python {

/// Arrays by the names of outputs.
using ArraysByName = nb::typed<nb::dict, nb::str, nb::any>;

/// Where the numbers of a Python array lie: one with the buffer protocol or DLPack, or pyopencl's.
struct ArrayView {
    ElementType type = ElementType::automatic;
    const void* host = nullptr;
    void* writable = nullptr;  ///< `host`, of an array that is written to
    cl_mem device = nullptr;
    std::size_t offset = 0;  ///< bytes
    std::vector<std::int64_t> shape;
    std::vector<std::int64_t> strides;  ///< bytes

    bool is_packed() const;  ///< in C order
};

/// The arrays of one call. They are used without a copy, and live until this is destroyed: with the GIL.
class Arrays {
public:
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

private:
    std::vector<nb::ndarray<nb::ro>> held_;
};

/// (nz, ny, nx): NumPy's shape of the grid's samples.
std::vector<std::int64_t> shape_of(const Index3& size);

const OutputInfo& output_named(const std::string& name);

}  // namespace clsdf::python
