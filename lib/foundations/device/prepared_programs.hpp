#pragma once

#include "device/opencl.hpp"
#include "device/records.hpp"

#include <filesystem>
#include <optional>
#include <string>

namespace clsdf::device {

/// The environment variables that change what compilers of PoCL, AMD and Intel make, a line each.
std::string compiler_environment();

/// A folder of compiled programs, "*.program". A program is taken for the same text, options, platform, driver, device
/// and compiler_environment(). Of a processor its level of instructions counts, not its model, if the driver is PoCL.
class PreparedPrograms {
public:
    static constexpr std::string_view ending = ".program";

    /// Empty, as at the start: none is read, or written.
    void read_from(std::filesystem::path folder) { read_ = Records(std::move(folder), ending); }
    void write_to(std::filesystem::path folder) { written_ = Records(std::move(folder), ending); }

    /// Nothing if there is none, or if the driver refuses it.
    std::optional<cl::Program> find(const cl::Context& context, const cl::Device& device, const std::string& options,
                                    const std::string& source) const;
    /// Writes a program that was compiled, and returns it as find() will: drivers finish binaries when they load them.
    /// Returns the program itself if nothing is written, or if the driver does not give its binary or refuses it.
    /// Throws Error(output_failure).
    cl::Program write(const cl::Program& program, const cl::Context& context, const cl::Device& device,
                      const std::string& options, const std::string& source) const;

private:
    Records read_{{}, ending};
    Records written_{{}, ending};
};

}  // namespace clsdf::device
