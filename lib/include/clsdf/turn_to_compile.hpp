#pragma once

#include <clsdf/export.hpp>

#include <functional>
#include <memory>
#include <string>

namespace clsdf {

/// The turn to compile, among the processes that keep their records in one folder (Device::keep_records()): the first
/// one compiles, and the others wait and find what it made. Without turns four workers that start with empty caches
/// compile the same programs four times, on the same cores.
///
/// No call of the library takes a turn; the command and the Python package do. Take one before the first call of a
/// process that may compile, and end it after that call. Ranks of MPI that start together need none if one of them runs
/// Device::keep_records() and such a call before the others.
///
/// The turn is a lock (flock) on the file "compiling.lock" in the folder, which ends with the process. Nobody
/// waits on file systems that several machines may share, on which locks are not known to work.
class CLSDF_EXPORT TurnToCompile {
public:
    /// Waits until no other holder has the turn of the folder, which is made if it does not exist. `goes_on` is asked
    /// every 20 ms, with the seconds since the call began: false ends the wait, without the turn. Its exceptions are
    /// passed on. There is no turn and no wait if the folder is "" or cannot be written to. A second turn of the
    /// process waits for the first one, too. Thread-safe; throws std::bad_alloc alone.
    explicit TurnToCompile(const std::string& folder, const std::function<bool(double seconds)>& goes_on);
    TurnToCompile(TurnToCompile&& other) noexcept;
    TurnToCompile& operator=(TurnToCompile&& other) noexcept;
    TurnToCompile(const TurnToCompile&) = delete;
    TurnToCompile& operator=(const TurnToCompile&) = delete;
    /// Ends the turn.
    ~TurnToCompile();

    /// Whether this process has the turn.
    bool is_taken() const noexcept;

private:
    struct Lock;
    std::unique_ptr<Lock> lock_;
};

}  // namespace clsdf
