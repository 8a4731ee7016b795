#pragma once

#include <hdf5.h>

#include <mutex>
#include <string>
#include <utility>

namespace clsdf::hdf5 {

/// One thread at a time in the library, which need not be built for more, and nothing printed by it.
class Session {
public:
    Session();
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    /// What the call that failed last says about it.
    static std::string reason();

private:
    std::lock_guard<std::mutex> lock_;
    H5E_auto2_t print_ = nullptr;  // what the program around us wants
    void* print_data_ = nullptr;
};

/// A handle and the function that closes it.
class Handle {
public:
    Handle(hid_t id, herr_t (*closing)(hid_t)) : id_(id), close_(closing) {}
    Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    ~Handle() { close(); }

    hid_t get() const { return id_; }
    bool is_valid() const { return id_ >= 0; }
    /// Whether it closed without an error.
    bool close() { return id_ < 0 || close_(std::exchange(id_, H5I_INVALID_HID)) >= 0; }

private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

/// How files are opened: without locks, which some file systems do not have.
Handle access();

}  // namespace clsdf::hdf5
