#pragma once

#include "disguise/record.hpp"

/// Kernels that fail (Fault::in_kernel). The launch succeeds and the kernel does not run. As on PoCL 3.1, commands that
/// are enqueued behind it in the queue do not run either, until the host waits for the queue or sees the status of one
/// of them. The events of all of them have a negative status. Waits for the queue, blocking reads and blocking mappings
/// succeed, and leave the host's memory as it was. Later commands run, unless an event of their wait list has failed.
/// PoCL itself cannot be used: it ends the process if nobody has the event of a command that fails so, and never ends a
/// command that waits for an event that has failed.
namespace clsdf::disguise {

/// The kernel that is launched in this queue fails. Sets the event, which may be null.
cl_int fail_kernel(cl_command_queue queue, cl_int status, cl_event* event);

/// Whether a command must not run.
bool is_failing(cl_command_queue queue, cl_uint waits, const cl_event* wait_list);
/// A command that must not run. Sets the event, which may be null. is_blocking: the host waits for it.
cl_int fail_command(cl_command_queue queue, bool is_blocking, cl_event* event);
/// The host has waited for a queue.
void end_failing(cl_command_queue queue);
/// The host has waited for events, or has seen their status.
void end_failing(cl_uint events, const cl_event* list);

}  // namespace clsdf::disguise
