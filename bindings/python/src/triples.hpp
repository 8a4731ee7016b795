#pragma once

#include <nanobind/nanobind.h>

#include <array>
#include <cstdint>
#include <type_traits>

namespace nanobind::detail {

/// Triples of numbers (x, y, z): tuples for Python, made of any sequence of three numbers, also a NumPy array.
template <typename Number>
struct TripleCaster {
    using Triple = std::array<Number, 3>;
    static constexpr bool is_real = std::is_floating_point_v<Number>;
    NB_TYPE_CASTER(Triple, const_name("@") + const_name("numpy.typing.ArrayLike") + const_name("@") +
                               const_name<is_real>("tuple[float, float, float]", "tuple[int, int, int]") +
                               const_name("@"))

    bool from_python(handle source, std::uint32_t /*flags*/, cleanup_list* /*cleanup*/) noexcept {
        const bool is_triple = PySequence_Check(source.ptr()) != 0 && PySequence_Size(source.ptr()) == 3;
        for (Py_ssize_t i = 0; is_triple && i < 3; ++i) {
            const object item = steal(PySequence_GetItem(source.ptr(), i));
            if (item.is_valid()) value[static_cast<std::size_t>(i)] = number(item);
            if (PyErr_Occurred() != nullptr) break;
        }
        const bool failed = PyErr_Occurred() != nullptr;
        PyErr_Clear();
        return is_triple && !failed;
    }

    static handle from_cpp(const Triple& triple, rv_policy /*policy*/, cleanup_list* /*cleanup*/) noexcept {
        return make_tuple(triple[0], triple[1], triple[2]).release();
    }

private:
    static Number number(handle item) {
        if constexpr (is_real) {
            return PyFloat_AsDouble(item.ptr());
        } else {
            const object whole = steal(PyNumber_Index(item.ptr()));
            return whole.is_valid() ? PyLong_AsLongLong(whole.ptr()) : 0;
        }
    }
};

template <>
struct type_caster<std::array<double, 3>> : TripleCaster<double> {};
template <>
struct type_caster<std::array<std::int64_t, 3>> : TripleCaster<std::int64_t> {};

}  // namespace nanobind::detail
