#pragma once

#include <clsdf/outputs.hpp>

#include <sys/types.h>
#include <stop_token>
#include <string>
#include <vector>

/// The subcommand that the process runs.
inline constexpr const char* compile_ahead = "compile-ahead";

/// A second process that compiles programs while this one compiles others: PoCL compiles one program at a time in a
/// process, and keeps programs on disk for all. It prints nothing, does no harm if it fails, and ends with this object.
class SecondCompiler {
public:
    /// Runs "clsdf compile-ahead" with these arguments for the device that --device names. It does something for a
    /// processor of PoCL alone.
    SecondCompiler(const std::string& device, const std::vector<std::string>& arguments);
    SecondCompiler(const SecondCompiler&) = delete;
    SecondCompiler& operator=(const SecondCompiler&) = delete;
    ~SecondCompiler();

    /// Returns when it has ended, or soon after a stop is requested.
    void wait(const std::stop_token& stop);

private:
    pid_t process_ = 0;  ///< 0: none was started
};

/// The arguments that compile the bricks of a field with these outputs.
std::vector<std::string> bricks_ahead(clsdf::OutputSet outputs);
