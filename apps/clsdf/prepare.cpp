#include "prepare.hpp"

#include "core/stopwatch.hpp"
#include "interruption.hpp"
#include "progress_bar.hpp"

#include <clsdf/picture.hpp>

#include <fmt/format.h>

#include <array>
#include <optional>

using clsdf::Stopwatch;
using nlohmann::ordered_json;

namespace {

/// The kernels that a call of "clsdf compute" needs.
struct Call {
    const char* name;
    bool triangle;
    bool count;
};

constexpr std::array<Call, 4> calls{Call{"compute", false, false}, Call{"compute --json", false, true},
                                    Call{"compute --with triangle", true, false},
                                    Call{"compute --with triangle --json", true, true}};

/// The time of one call.
struct Step {
    std::string name;
    double seconds = 0;
    bool is_tested = false;  ///< tested now; false if it was tested before or has no test
};

class Preparation {
public:
    Preparation(Report& report, const clsdf::Device& device, const std::stop_token& stop)
        : report_(report), device_(device), stop_(stop), mesh_(clsdf::make_shape("cube")) {}

    /// Kernels that sweep large triangles are among these: the faces of a cube.
    Step compile(const Call& call) {
        clsdf::TransformOptions options;
        clsdf::CallOptions watched;
        watched.count = call.count;
        watched.should_stop = [this] { return stop_.stop_requested(); };
        ProgressBar progress(!report_.quiet);
        watched.compiling = [&](const clsdf::Compilation& compilation) {
            progress.show(fmt::format("{}: {}", call.name, text_of(compilation)));
        };
        options.log = [&](const std::string& message) {
            progress.clear();
            report_.warn(message);
        };
        const Stopwatch watch;
        clsdf::DistanceTransform transform(device_, mesh_, options, watched);
        const clsdf::Outputs outputs{.triangle = call.triangle};
        const clsdf::Grid grid = clsdf::Grid::around(mesh_, 64, clsdf::Band::symmetric(0.1));
        Step step{call.name};
        for (const clsdf::Band& band : {clsdf::Band::symmetric(0.1), clsdf::Band::full()})
            step.is_tested |= transform.compile(grid, band, outputs, watched);
        step.seconds = watch.seconds();
        return step;
    }

    /// Traces a small picture, because some drivers compile a kernel at its first launch.
    Step render() {
        const Stopwatch watch;
        const clsdf::Band band = clsdf::Band::full();
        const clsdf::Field field = clsdf::DistanceTransform(device_, mesh_)(clsdf::Grid::around(mesh_, 8, band), band);
        clsdf::picture::SurfaceOptions options;
        options.width = options.height = 16;
        options.should_stop = [this] { return stop_.stop_requested(); };
        clsdf::picture::SurfacePictures(field, device_).hits(options);
        return {"render", watch.seconds()};
    }

private:
    Report& report_;
    clsdf::Device device_;
    std::stop_token stop_;
    clsdf::Mesh mesh_;
};

ordered_json prepare(Report& report, const clsdf::DeviceInfo& info, bool again, const std::stop_token& stop) {
    ordered_json steps = ordered_json::array();
    const auto add = [&](const Step& step) {
        report.print("   {:<30}  {:6.2f} s{}\n", step.name, step.seconds, step.is_tested ? ", tested" : "");
        steps.push_back({{"name", step.name}, {"seconds", step.seconds}, {"tested", step.is_tested}});
    };
    report.print("{}  {} ({})\n", info.index, info.name, info.platform);
    const clsdf::Device device = clsdf::Device::select(std::to_string(info.index));
    if (again) device.forget_tests();
    Preparation preparation(report, device, stop);
    for (const Call& call : calls) add(preparation.compile(call));
    add(preparation.render());
    return {{"index", info.index}, {"name", info.name}, {"steps", steps}};
}

}  // namespace

std::string text_of(const clsdf::Compilation& compilation) {
    if (compilation.is_waiting) return "waiting for another process that compiles the same kernels";
    return fmt::format("compiling kernels {} of {}", compilation.step, compilation.steps);
}

void prepare(Report& report, const std::vector<clsdf::DeviceInfo>& devices, bool again) {
    const Interruption interruption;
    std::optional<clsdf::Error> failure;
    report.result["prepared"] = ordered_json::array();
    for (const clsdf::DeviceInfo& info : devices) {
        try {
            report.result["prepared"].push_back(prepare(report, info, again, interruption.token()));
        } catch (const clsdf::Error& error) {
            // The compilers of some devices react to the same signals and fail; the reason is the user's wish.
            if (interruption.token().stop_requested())
                throw clsdf::Error(clsdf::ErrorCode::cancelled, "cancelled; what was compiled before is kept");
            if (failure) report.warn(failure->what());
            failure = error;
        }
    }
    if (failure) throw clsdf::Error(*failure);
}
