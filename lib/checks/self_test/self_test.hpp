#pragma once

#include "launch/programs.hpp"
#include "plan/field_method.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace clsdf::transform {

/// The properties that decide which code a computation runs on the device.
struct TestCase {
    KernelBody body = KernelBody::by_vector;      ///< never automatic
    std::shared_ptr<const FieldMethod> method{};  ///< as FieldMethod::tested_as() gives it; null: by bricks
    BrickVariant variant{};
    bool is_signed = true;  ///< the sign is swept
    bool is_wide = false;   ///< coarse bricks have bounds of their own
    bool is_later = false;  ///< see PreparedMesh: a kernel of their own makes the records

    /// Other cases all of whose kernels this one runs, too.
    std::vector<TestCase> contained() const;
    /// For messages and records, different for each case, e.g. "by_vector bricks NEAREST signed narrow".
    std::string name() const;
};

/// How often `begins` of a watch is called by ensure_tested() for a case that has not been tested, about.
std::size_t step_count(const TestCase& test_case);

/// Builds a case's programs, and, the first time on this device and driver version, computes a small known field with
/// them, with the launches of real computations, and compares it with its values. Compilers that specialise kernels at
/// their first launch do it then. Returns whether it was tested here. Throws Error(wrong_results) that says what
/// differs; with tuning_variable("CLSDF_SELF_TEST") "0" nothing is computed.
bool ensure_tested(const Device& device, const Programs& programs, const TestCase& test_case,
                   const device::BuildWatch& watch = {});

/// Programs that are tested together.
struct TestSubject {
    std::string name;                                 ///< for messages and records
    std::function<std::vector<cl::Program>()> build;  ///< called after the test if there can be no record
};
/// Runs test() if the subject has not been tested on this device and driver version; it returns what is wrong, in a
/// sentence. Returns whether it ran. Throws Error(wrong_results) that says what is wrong; with
/// tuning_variable("CLSDF_SELF_TEST") "0" it is not run.
bool test_once(const Device& device, const TestSubject& subject,
               const std::function<std::optional<std::string>()>& test);

/// Describes what the device computes wrong, in a sentence; nothing if all is right.
std::optional<std::string> run_self_test(const Device& device, const Programs& programs, const TestCase& test_case,
                                         const device::BuildWatch& watch = {});

/// The properties of a query of points that decide which code it runs on the device.
struct PointTestCase {
    bool are_scanned = false;  ///< many points
    bool is_later = false;     ///< as TestCase's; for many points
};

/// Builds the programs of queries of points and, the first time on this device and driver version, computes a small
/// known field at its samples and compares. Returns whether it was tested here. Throws Error(wrong_results) that says
/// what differs.
bool ensure_points_tested(const Device& device, const Programs& programs, const PointTestCase& test_case,
                          const device::BuildWatch& watch = {});

/// How often `begins` of a watch is called by ensure_points_tested() for programs that have not been tested, about.
inline constexpr std::size_t point_test_steps = 3;

}  // namespace clsdf::transform
