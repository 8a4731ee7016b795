#include "calls.hpp"

#include <bit>
#include <cstdint>
#include <string>
#include <utility>

namespace clsdf::python {

namespace {

// Between two questions whether Ctrl-C was pressed: each takes the GIL.
constexpr std::chrono::milliseconds interval{50};

}  // namespace

void warn(const std::string& message) {
    const nb::gil_scoped_acquire gil;
    const nb::object category = nb::module_::import_("clsdf").attr("MeshWarning");
    if (PyErr_WarnEx(category.ptr(), message.c_str(), 2) != 0) throw nb::python_error();
}

namespace {

const char* name_of(Progress::Stage stage) {
    switch (stage) {
        case Progress::Stage::compiling:
            return "compiling";
        case Progress::Stage::testing:
            return "testing";
        case Progress::Stage::computing:
            break;
    }
    return "computing";
}

}  // namespace

Call::Call(nb::object progress, nb::handle wait_for)
    : progress_(std::move(progress)),
      wait_for_(wait_for.is_none() ? nb::object(nb::none()) : nb::object(nb::list(wait_for))),
      events_(events_of(wait_for_)),
      asked_(std::chrono::steady_clock::now()) {
    options_.should_stop = [this] {
        ask_for_signals();
        return false;
    };
    options_.log = warn;
    options_.wait_list = events_;
    if (progress_.is_none()) return;
    options_.progress = [this](const Progress& progress) {
        const nb::gil_scoped_acquire gil;
        progress_(name_of(progress.stage), progress.fraction);
    };
}

// Python's exception, as KeyboardInterrupt, passes through the library and ends the call.
void Call::ask_for_signals() {
    const auto now = std::chrono::steady_clock::now();
    if (now - asked_ < interval) return;
    asked_ = now;
    const nb::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
}

std::vector<cl_event> events_of(nb::handle wait_for) {
    std::vector<cl_event> events;
    if (wait_for.is_none()) return events;
    for (const nb::handle event : wait_for)
        events.push_back(std::bit_cast<cl_event>(nb::cast<std::uintptr_t>(event.attr("int_ptr"))));
    return events;
}

}  // namespace clsdf::python
