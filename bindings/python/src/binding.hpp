#pragma once

/// Shared by all files of the binding: nanobind, its casters, and the parts that the module is made of.
#include <clsdf/clsdf.hpp>
#include <clsdf/outer.hpp>

#include "triples.hpp"

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace nb = nanobind;

namespace clsdf::python {

void add_errors(nb::module_& module);
void add_arrays(nb::module_& module);
void add_grids(nb::module_& module);
void add_devices(nb::module_& module);
void add_meshes(nb::module_& module);
void add_transforms(nb::module_& module);
void add_scenes(nb::module_& module);
void add_links(nb::module_& module);
void add_plans(nb::module_& module);
void add_shared_arrays(nb::module_& module);
void add_files(nb::module_& module);
void add_sparse_fields(nb::module_& module);

/// The owner of an array's memory, which deletes it with the last array.
template <typename Memory>
nb::capsule owner_of(std::unique_ptr<Memory> memory) {
    return {memory.release(), [](void* own) noexcept { delete static_cast<Memory*>(own); }};
}

/// An array in the memory of a vector, which it takes.
template <typename Array, typename Item>
Array array_in(std::vector<Item> items, std::initializer_list<std::size_t> shape) {
    auto memory = std::make_unique<std::vector<Item>>(std::move(items));
    void* const data = memory->data();
    return Array(data, shape, owner_of(std::move(memory)));
}

/// Error(invalid_argument) with this message.
[[noreturn]] void refuse(const std::string& message);

/// How an error shows a value: the start of its repr().
std::string shown(nb::handle value);
/// A whole number of an argument, `what`; refused if it is none.
std::int64_t whole_of(nb::handle value, const char* what);
/// The same from 0 on.
std::size_t count_of(nb::handle value, const char* what);

/// Call before anything that needs a device. OpenCL's drivers and threads do not survive a fork, and a call would hang:
/// throws Error(device_failure) in a process that was forked after its parent came here.
void check_process();
/// False in such a process: objects of the device are left alone there, since their destructors wait for threads that
/// do not exist.
bool is_process_of_devices() noexcept;

/// Vertices, faces, the faces as given, and the numbers, in the order of clsdf.OuterSurface.
nb::tuple tuple_of(OuterSurface surface);

/// The value of an enumeration whose name_of() is the text.
template <typename Value>
Value value_named(const char* what, const std::string& text, std::initializer_list<Value> values) {
    std::string names;
    for (const Value value : values) {
        if (text == name_of(value)) return value;
        names += names.empty() ? "" : ", ";
        names += name_of(value);
    }
    refuse(std::string(what) + " '" + text + "' is not known; the choices are " + names);
}

}  // namespace clsdf::python
