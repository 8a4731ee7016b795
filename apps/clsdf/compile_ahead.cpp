#include "command.hpp"
#include "devices.hpp"
#include "option_values.hpp"
#include "report.hpp"
#include "second_compiler.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/tuning.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <string>
#include <vector>

namespace {

void compile_level(const std::string& choice, const std::string& folder) {
    const clsdf::Device device = open_device(choice);
    device.read_programs("");
    device.write_programs(folder);
    clsdf::tuning::compile_level(device);
}

/// Builds those of this processor's level, too.
void check_levels(const clsdf::Device& device) {
    const std::vector<std::string> missing = clsdf::tuning::missing_programs(device);
    if (!missing.empty())
        throw clsdf::Error(clsdf::ErrorCode::unsupported, fmt::format("the bundled driver lacks {} programs: {}",
                                                                      missing.size(), fmt::join(missing, "; ")));
    clsdf::tuning::compile_level(device);
}

}  // namespace

Command add_compile_ahead(Parser& program) {
    struct Options {
        std::string device;
        std::vector<std::string> with;
        bool prepare = false;
        std::string programs;
        bool check = false;
    };
    const auto options = std::make_shared<Options>();
    Parser parser = program.add_subcommand(compile_ahead, "Compile programs beside another process that needs them");
    parser.hide();
    add_device_option(parser, options->device, "what computes");
    add_outputs_option(parser, options->with);
    parser.add("--prepare", options->prepare, "instead of the bricks: half of what \"clsdf devices --prepare\" does");
    parser.add("--programs", options->programs, "instead: write all programs of a bundled driver, for this level")
        .takes_text("FOLDER");
    parser.add("--check", options->check, "instead: tell which programs the bundled driver lacks");
    return {parser, [options](Report& report) {
                if (!options->programs.empty()) {
                    compile_level(options->device, options->programs);
                    return ExitStatus::done;
                }
                const clsdf::Device device = open_device(options->device);
                if (options->check)
                    check_levels(device);
                else if (!specialises_at_launch(device))
                    return ExitStatus::done;  // a driver that compiles nothing at a launch, such as the bundled one
                else if (options->prepare)
                    prepare_ahead(report, device);
                else
                    clsdf::tuning::compile_bricks(device, parse_outputs(options->with));
                return ExitStatus::done;
            }};
}
