#include "command_line.hpp"
#include "interruption.hpp"
#include "report.hpp"

#include <clsdf/error.hpp>

#include <algorithm>
#include <chrono>
#include <new>
#include <string_view>
#include <thread>

using clsdf::ErrorCode;

namespace {

// Found before the command line is parsed, because its errors are JSON, too.
bool asks_for_json(int argument_count, char** arguments) {
    char** const end = std::find(arguments, arguments + argument_count, std::string_view("--"));
    return std::find(arguments, end, std::string_view("--json")) != end;
}

}  // namespace

int main(int argument_count, char** arguments) {
    open_closed_streams();
    let_writes_fail();
    Report report;
    report.json = asks_for_json(argument_count, arguments);
    end_when_left_by_a_library(report.json);
    ExitStatus status = ExitStatus::device;
    try {
        end_when_interrupted(report.json);
        status = CommandLine(report).run(argument_count, arguments);
        report.finish();
    } catch (const clsdf::Error& error) {
        if (interrupted() && error.code() != ErrorCode::cancelled) {
            // A signal is ending the process and made the call fail.
            std::this_thread::sleep_for(std::chrono::seconds(1));
            status = report.fail(ErrorCode::cancelled, "cancelled; nothing was written");
        } else {
            status = report.fail(error.code(), error.what());
        }
    } catch (const std::bad_alloc&) {
        status = report.fail(ErrorCode::out_of_memory,
                             "the memory is too small for this; choose a lower --resolution or a larger --spacing");
    } catch (const std::exception& error) {
        status = report.fail(ErrorCode::device_failure, std::string("internal error: ") + error.what());
    }
    ignore_interruptions();
    return static_cast<int>(status);
}
