#pragma once

#include <clsdf/distance_transform.hpp>
#include <clsdf/error.hpp>

#include "core/statistics.hpp"
#include "device/context.hpp"

#include <cstddef>
#include <functional>
#include <vector>

namespace clsdf::calls {

/// A call that runs: the functions of its options, and what it has taken so far. If one of the functions throws, the
/// call ends: it does not try again with less memory, even if the error is out_of_memory.
struct RunningCall {
    /// Throws Error(cancelled) if the caller wants the call to stop.
    void throw_if_stopped();
    void report(const Progress& progress);
    /// Both, to be called between launches with the fraction done of samples or points, which are [begin, end) of the
    /// call's; empty if there is nothing to call.
    std::function<void(double)> between(double begin, double end);

    /// Whether the error means that the call needs more memory than there is.
    bool is_short_of_memory(const Error& error) const {
        return error.code() == ErrorCode::out_of_memory && !has_thrown;
    }

    /// ensure(watch) builds, loads or tests programs and returns whether it tested them. expected: about how many steps
    /// there are.
    void compile(std::size_t expected, const std::function<bool(const device::BuildWatch&)>& ensure);

    /// Reports that all is done. Returns what it took.
    const CallStatistics& finish();

    template <typename Function, typename... Arguments>
    auto pass_on(const Function& function, const Arguments&... arguments);

    const CallOptions& options;
    CallStatistics statistics{};
    bool has_thrown = false;  ///< one of its functions
    std::size_t step = 0;     ///< of compiling
};

/// The options of a part of a call, whose samples are [begin, end) of the call's. `call` must outlive them.
CallOptions part_of(const CallOptions& call, double begin, double end);

/// A way to need less memory.
struct Remedy {
    std::function<bool()> apply;  ///< returns whether it has changed anything
    bool repeats = false;         ///< may be applied again and again
};

/// Returns what attempt() returns. When memory is short, applies the first remedy that changes anything, and tries
/// again; when none is left, the error is thrown. call: whose functions are called; null: none.
template <typename Attempt>
auto with_remedies(const RunningCall* call, const std::vector<Remedy>& remedies, const Attempt& attempt) {
    auto next = remedies.begin();
    const auto apply_next = [&] {
        bool has_changed = false;
        while (!has_changed && next != remedies.end()) {
            has_changed = next->apply();
            if (!has_changed || !next->repeats) ++next;
        }
        return has_changed;
    };
    for (;;) {
        try {
            return attempt();
        } catch (const Error& error) {
            const bool is_short =
                call != nullptr ? call->is_short_of_memory(error) : error.code() == ErrorCode::out_of_memory;
            if (!is_short || !apply_next()) throw;
        }
    }
}

}  // namespace clsdf::calls
