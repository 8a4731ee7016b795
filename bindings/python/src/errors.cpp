#include "binding.hpp"

#include <fmt/format.h>
#include <unistd.h>
#include <atomic>
#include <exception>

namespace clsdf::python {

namespace {

PyObject* error_class = nullptr;  // clsdf.Error; lives as long as the process

// nanobind's translators get the exception here and pass on what is not theirs.
void translate(const std::exception_ptr& exception, void* /*unused*/) {
    try {
        std::rethrow_exception(exception);
    } catch (const Error& error) {
        PyObject* const type = error_class != nullptr ? error_class : PyExc_RuntimeError;
        const nb::object instance =
            nb::steal(PyObject_CallFunction(type, "ssi", error.what(), name_of(error.code()), error.opencl_code()));
        if (instance.is_valid()) PyErr_SetObject(type, instance.ptr());
    }
}

std::atomic<pid_t> process_of_devices = 0;

}  // namespace

void refuse(const std::string& message) {
    throw Error(ErrorCode::invalid_argument, message);
}

std::string shown(nb::handle value) {
    return nb::cast<std::string>(nb::repr(value)).substr(0, 100);
}

std::int64_t whole_of(nb::handle value, const char* what) {
    std::int64_t number = 0;
    if (nb::try_cast(value, number)) return number;
    refuse(fmt::format("{}: {} is not a whole number", what, shown(value)));
}

std::size_t count_of(nb::handle value, const char* what) {
    const std::int64_t number = whole_of(value, what);
    if (number >= 0) return static_cast<std::size_t>(number);
    refuse(fmt::format("{}: {} is negative", what, number));
}

void check_process() {
    pid_t first = 0;
    const pid_t here = getpid();
    if (!process_of_devices.compare_exchange_strong(first, here) && first != here)
        throw Error(ErrorCode::device_failure,
                    "this process was forked from one that had used clsdf, and OpenCL does not work in it; start "
                    "processes with multiprocessing.get_context(\"spawn\") or \"forkserver\", or use clsdf in the "
                    "children only");
}

bool is_process_of_devices() noexcept {
    return process_of_devices == 0 || process_of_devices == getpid();
}

void add_errors(nb::module_& module) {
    nb::register_exception_translator(translate);
    module.def(
        "_set_error_class", [](nb::object type) { error_class = type.release().ptr(); }, nb::arg("type"));
    module.def("version", &version, "The version of the library, \"major.minor.patch\".");
}

}  // namespace clsdf::python
