#include "run_call.hpp"

#include "interruption.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/turn_to_compile.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <new>
#include <optional>
#include <system_error>
#include <utility>

namespace {

/// Ends with the process at the latest.
std::optional<clsdf::TurnToCompile>& turn_to_compile() {
    static std::optional<clsdf::TurnToCompile> turn;
    return turn;
}

clsdf::CallOptions watched_call(ProgressBar& bar, Report& report, std::stop_token stop) {
    clsdf::CallOptions call;
    call.progress = [&bar, &report, stop](const clsdf::Progress& progress) {
        if (progress.stage == clsdf::Progress::Stage::computing) {
            turn_to_compile().reset();
            bar.show(progress.fraction);
        } else {
            take_turn_to_compile(report, stop);
            bar.show(text_of(progress));
        }
    };
    call.should_stop = [stop = std::move(stop)] { return stop.stop_requested(); };
    call.log = [&bar, &report](const std::string& message) {
        bar.clear();
        report.warn(message);
    };
    return call;
}

}  // namespace

std::string text_of(const clsdf::Progress& compiling) {
    return fmt::format("compiling kernels {} of {}", compiling.step, compiling.steps);
}

bool is_first_use() {
    std::error_code error;
    const std::filesystem::directory_iterator files(clsdf::Device::default_record_folder(), error);
    return std::ranges::none_of(files, [](const auto& file) { return file.path().extension() == ".tested"; });
}

void take_turn_to_compile(const Report& report, const std::stop_token& stop) {
    constexpr double silence = 2, longest_wait = 30;  // seconds
    static bool has_asked = false;
    if (std::exchange(has_asked, true) || !is_first_use()) return;
    bool has_told = false;
    turn_to_compile().emplace(clsdf::Device::default_record_folder(), [&](double seconds) {
        if (seconds > silence && !std::exchange(has_told, true))
            report.print("waiting for another process that compiles programs, {:.0f} s at most\n", longest_wait);
        return seconds < longest_wait && !stop.stop_requested();
    });
}

void run_call(Report& report, const CallErrors& errors, const std::function<void(const RunningCall&)>& work) {
    const Interruption interruption;
    try {
        {
            ProgressBar bar(!report.quiet);
            work({watched_call(bar, report, interruption.token()), bar, interruption.token()});
        }
        if (!errors.work_writes) interruption.finish(errors.cancelled);
    } catch (const std::bad_alloc&) {
        if (errors.too_large.empty()) throw;
        throw clsdf::Error(clsdf::ErrorCode::out_of_memory, errors.too_large);
    } catch (const clsdf::Error& error) {
        // The compilers of some devices react to the same signals and fail; the reason is the user's wish.
        interruption.finish(errors.cancelled);
        if (!errors.explain) throw;
        throw errors.explain(error);
    }
}
