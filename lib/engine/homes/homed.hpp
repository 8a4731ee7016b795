#pragma once

#include "homes/kept.hpp"

#include <functional>
#include <memory>
#include <utility>

namespace clsdf::engine {

/// A value that is in memory of the host, in memory of the device, or in both: its homes. Host and Device are its two
/// forms. Each is made when it is asked for and is not there, of the other one or of other values, in the way that is
/// given once, to the constructor. Only this class says where a value is.
template <class Host, class Device>
class Homed final : public KeptValue {
public:
    using MakeOnHost = std::function<std::shared_ptr<const Host>()>;
    using MakeOnDevice = std::function<std::shared_ptr<const Device>()>;

    /// all: as of Kept. A function may be null if its form is never asked for but when it is set.
    Homed(KeptValues& all, MadeOf made_of_in, UsedBy used_by_in, MakeOnHost make_on_host, MakeOnDevice make_on_device)
        : KeptValue(made_of_in, used_by_in),
          make_on_host_(std::move(make_on_host)),
          make_on_device_(std::move(make_on_device)) {
        all.push_back(this);
    }
    Homed(const Homed&) = delete;
    Homed& operator=(const Homed&) = delete;

    /// Makes the form that is missing. May wait for the device. Throws Error.
    const std::shared_ptr<const Host>& on_host() {
        if (!host_) host_ = make_on_host_();
        return host_;
    }
    const std::shared_ptr<const Device>& on_device() {
        if (!device_) device_ = make_on_device_();
        return device_;
    }

    /// Null if it is not there.
    const std::shared_ptr<const Host>& if_on_host() const { return host_; }
    const std::shared_ptr<const Device>& if_on_device() const { return device_; }
    bool is_made() const { return host_ != nullptr || device_ != nullptr; }

    /// A new value, in one of its forms or in both.
    void set(std::shared_ptr<const Host> host, std::shared_ptr<const Device> device) {
        host_ = std::move(host);
        device_ = std::move(device);
        is_only_copy_ = false;
    }
    /// A new value of the caller's, which could not be made again.
    void set_only_copy(std::shared_ptr<const Device> device) {
        set(nullptr, std::move(device));
        is_only_copy_ = true;
    }
    /// Whether the device has a value that could not be made again.
    bool is_only_copy() const { return is_only_copy_ && host_ == nullptr && device_ != nullptr; }

    KeptMemory memory() const override {
        const KeptMemory of_device = memory_of(device_.get());
        return {.host_bytes = host_ ? memory_of(host_.get()).host_bytes : of_device.host_bytes,
                .device_bytes = of_device.device_bytes};
    }
    bool is_in_use() const override { return device_.use_count() > 1; }
    void forget() override { set(nullptr, nullptr); }
    bool can_leave_device() const override { return !is_only_copy(); }
    void leave_device() override {
        if (can_leave_device()) device_.reset();
    }

private:
    MakeOnHost make_on_host_;
    MakeOnDevice make_on_device_;
    std::shared_ptr<const Host> host_;
    std::shared_ptr<const Device> device_;
    bool is_only_copy_ = false;  // while the host does not have it
};

}  // namespace clsdf::engine
