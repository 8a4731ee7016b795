#include <clsdf/turn_to_compile.hpp>

#include "core/file_locks.hpp"
#include "core/files.hpp"

#include <fcntl.h>
#include <chrono>
#include <filesystem>
#include <system_error>
#include <thread>

namespace clsdf {

struct TurnToCompile::Lock {
    explicit Lock(int descriptor) : file(descriptor) {}

    Descriptor file;
};

TurnToCompile::TurnToCompile(const std::string& folder, const std::function<bool(double seconds)>& goes_on) {
    if (folder.empty()) return;
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    const std::string name = (std::filesystem::path(folder) / "compiling.lock").string();
    auto lock = std::make_unique<Lock>(::open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
    if (lock->file.number() < 0 || !is_of_one_machine(lock->file.number())) return;
    const auto began = std::chrono::steady_clock::now();
    while (!try_to_lock(lock->file.number())) {
        if (!goes_on(std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count())) return;
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    lock_ = std::move(lock);
}

TurnToCompile::TurnToCompile(TurnToCompile&& other) noexcept = default;
TurnToCompile& TurnToCompile::operator=(TurnToCompile&& other) noexcept = default;
TurnToCompile::~TurnToCompile() = default;

bool TurnToCompile::is_taken() const noexcept {
    return lock_ != nullptr;
}

}  // namespace clsdf
