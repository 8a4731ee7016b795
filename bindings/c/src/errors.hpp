#pragma once

#include <clsdf.h>

#include <clsdf/error.hpp>

#include <cstdint>
#include <exception>
#include <new>
#include <string>

/// How a failure becomes a status and a message. Each of the two libraries has its own record().
namespace clsdf::c {

/// Keeps the message of this thread's call. Throws nothing: without memory it keeps another message.
void record(const char* message, int opencl_code) noexcept;

/// A callback of the caller's ended the call.
struct CallbackEnded {
    clsdf_status status;
    std::string message;
    int opencl_code;
};

inline Error misuse(const std::string& message) {
    return {ErrorCode::invalid_argument, message};
}

/// Runs the body of a function of the interface.
template <typename Body>
clsdf_status guarded(const Body& body) noexcept {
    try {
        record("", 0);
        body();
        record("", 0);  // a callback may have left a message
        return CLSDF_OK;
    } catch (const CallbackEnded& end) {
        record(end.message.c_str(), end.opencl_code);
        return end.status;
    } catch (const Error& error) {
        record(error.what(), error.opencl_code());
        return static_cast<clsdf_status>(error.code());
    } catch (const std::bad_alloc&) {
        record("the host has not enough memory for this call", 0);
        return CLSDF_OUT_OF_MEMORY;
    } catch (const std::exception& failure) {
        record(failure.what(), 0);
    } catch (...) {
        record("an exception of no known type", 0);
    }
    return CLSDF_UNEXPECTED;
}

/// The same for a function that makes a handle: null after a failure.
template <typename Handle, typename Body>
clsdf_status made(Handle** result, const char* name, const Body& body) noexcept {
    if (result != nullptr) *result = nullptr;
    return guarded([&] {
        if (result == nullptr) throw misuse(std::string(name) + " is null; give the address of a handle");
        *result = body();
    });
}

}  // namespace clsdf::c
