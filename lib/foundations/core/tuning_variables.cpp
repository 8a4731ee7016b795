#include "core/tuning_variables.hpp"

#include <clsdf/tuning.hpp>

#include <atomic>
#include <cstdlib>

namespace clsdf {

namespace {

std::atomic<bool> reads_environment = false;

}  // namespace

void tuning::read_environment() noexcept {
    reads_environment = true;
}

const char* tuning_variable(const char* name) noexcept {
    return reads_environment ? std::getenv(name) : nullptr;
}

}  // namespace clsdf
