#pragma once

#include "device/opencl.hpp"
#include "device/records.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace clsdf::device {

/// The environment variables that change what compilers of PoCL, AMD and Intel make, a line each.
std::string compiler_environment();

/// The level of a processor's instructions, as PoCL names it at the end of the version of its devices: "haswell", in
/// the bundled driver "x86-64-v3". Empty for devices of others. Throws cl::Error.
std::string processor_level(const cl::Device& device);

/// All that a binary depends on beside environment, options and text: platform, driver and device; of PoCL its version
/// without its compiler's, and, at the end, processor_level(). Throws cl::Error.
std::string target_of(const cl::Device& device);

/// Under which a program is stored.
std::string program_key(std::string_view target, std::string_view environment, std::string_view options,
                        std::string_view text);

/// Folders of compiled programs, "*.program". A program is taken for the same text, options, target_of() its device and
/// compiler_environment().
class PreparedPrograms {
public:
    static constexpr std::string_view ending = ".program";

    /// Programs of a driver without a compiler, which no environment variable changes. They come before those below.
    void read_first(std::filesystem::path folder) { bundled_ = Records(std::move(folder), ending); }
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
    Records bundled_{{}, ending};
    Records read_{{}, ending};
    Records written_{{}, ending};
};

}  // namespace clsdf::device
