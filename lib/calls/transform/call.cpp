#include "transform/call.hpp"

#include <algorithm>

namespace clsdf::transform {

template <typename Function, typename... Arguments>
auto Caller::pass_on(const Function& function, const Arguments&... arguments) {
    try {
        return function(arguments...);
    } catch (...) {
        has_thrown_ = true;
        throw;
    }
}

void Caller::throw_if_stopped() {
    if (options_.should_stop && pass_on(options_.should_stop))
        throw Error(ErrorCode::cancelled, "the computation was cancelled");
}

void Caller::progress(double fraction) {
    report({.fraction = fraction});
}

void Caller::report(const Progress& progress) {
    if (options_.progress) pass_on(options_.progress, progress);
}

void Caller::warn(const std::string& message) {
    if (options_.log) pass_on(options_.log, message);
}

void CallMutex::check_thread() const {
    if (owner_.load() == std::this_thread::get_id())
        throw Error(ErrorCode::invalid_argument,
                    "a function of a call's options used the transform that makes the call; use it when the call has "
                    "returned");
}

void CallMutex::lock() {
    check_thread();
    mutex_.lock();
    owner_ = std::this_thread::get_id();
}

void CallMutex::unlock() {
    owner_ = std::thread::id();
    mutex_.unlock();
}

device::BuildWatch Compiling::watch(std::size_t expected) {
    const auto report_as = [this, expected](Progress::Stage stage) {
        return [this, expected, stage] {
            ++step_;
            caller_.throw_if_stopped();
            const std::size_t steps = std::max(expected, step_);
            caller_.report({stage, static_cast<double>(step_ - 1) / static_cast<double>(steps), step_, steps});
        };
    };
    return {report_as(Progress::Stage::compiling), report_as(Progress::Stage::testing)};
}

}  // namespace clsdf::transform
