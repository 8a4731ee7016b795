#pragma once

#include <cfenv>

namespace clsdf {

/// Rounding to nearest and no traps during its lifetime, on the thread that makes it and on threads that it starts:
/// those of a driver for processors inherit the floating-point environment. Kernels, and their headers on the host,
/// divide by zero, and rely on that rounding.
class DefaultFloatingPoint {
public:
    DefaultFloatingPoint() {
        std::fegetenv(&callers_);
        std::fesetenv(FE_DFL_ENV);
    }
    DefaultFloatingPoint(const DefaultFloatingPoint&) = delete;
    DefaultFloatingPoint& operator=(const DefaultFloatingPoint&) = delete;
    ~DefaultFloatingPoint() { std::fesetenv(&callers_); }

private:
    std::fenv_t callers_{};
};

}  // namespace clsdf
