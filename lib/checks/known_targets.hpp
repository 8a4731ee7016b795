#pragma once

#include "checks/self_test.hpp"

namespace clsdf::checks {

/// The program that stores boxes of samples in the caller's buffers: targets::BoxStore.
TestSubject stored_boxes_subject(const Device& device, const engine::Programs& programs);

/// The same program, which stores links: targets::RowStore.
TestSubject stored_links_subject(const Device& device, const engine::Programs& programs);

/// The program that puts bricks in order: targets::BrickStore.
TestSubject ordered_bricks_subject(const Device& device, const engine::Programs& programs);

}  // namespace clsdf::checks
