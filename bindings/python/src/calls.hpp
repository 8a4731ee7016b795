#pragma once

#include "binding.hpp"

#include <chrono>
#include <string>
#include <vector>

namespace clsdf::python {

/// The options of one call, for Python: its progress function, its events, Ctrl-C and warnings. Make and destroy it
/// with the GIL; the library calls it back without.
class Call {
public:
    /// `progress` is None or a function of the stage ("compiling", "testing" or "computing") and the fraction of it
    /// that is done. `wait_for` is None or an iterable of pyopencl's events, which live as long as the call.
    explicit Call(nb::object progress = nb::none(), nb::handle wait_for = nb::none());
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

    const CallOptions& options() const { return options_; }
    /// Of what was made before: its warnings have been given.
    void mute() { options_.log = {}; }
    void refuse_unusable_points(bool are_refused) { options_.refuse_unusable_points = are_refused; }

private:
    void ask_for_signals();

    nb::object progress_;
    nb::object wait_for_;
    std::vector<cl_event> events_;
    std::chrono::steady_clock::time_point asked_;
    CallOptions options_;
};

/// A warning on the line that called the package: two frames up, past the package's own. For callbacks of the library,
/// without the GIL.
void warn(const std::string& message);

/// The handles of a list of pyopencl's events, which must outlive them; empty for None.
std::vector<cl_event> events_of(nb::handle wait_for);

}  // namespace clsdf::python
